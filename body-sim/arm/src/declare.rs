//! How an arm with a finger describes itself - its senses, its actions, its scene commands - and how it reports.

use pschema_protocol::body::Senses;
use pschema_protocol::description::{
    ActionId, ActionType, Description, ObservationType, Property, SenseId, Value,
};

use crate::side::Side;
use crate::square::{JOINT_RESOLUTION, JointPositions};

/// The ids of the senses, actions and scene commands that a [`FingerArm`] declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArmIds {
    /// `finger{colour, field}`: the field that the finger is seen in. Its colour tells it from objects.
    pub finger: SenseId,
    /// `object{colour, field}`: the field that an object is seen in.
    pub object: SenseId,
    /// `touch{}`: the finger is in contact with something.
    pub touch: SenseId,
    /// `contact{side}`: a side of the finger that feels the contact.
    pub contact: SenseId,
    /// The action `move{j1, j2}`: go to joint positions; a contact ends it.
    pub move_to: ActionId,
    /// The action `push{j1, j2, to_j1, to_j2}`: set the finger down at joint positions, go straight to others, on through
    /// contact. Only of a body whose world has pushes.
    pub push: Option<ActionId>,
    /// The scene command `place{object, position}`: put an object down; the arm is parked first.
    pub place: ActionId,
    /// The scene command `remove{object}`: take an object away.
    pub remove: ActionId,
    /// The scene command `park{}`: take the arm to its rest posture, out of sight.
    pub park: ActionId,
}

/// The properties in which one arm with a finger under a camera differs from another, simulated or real. All of them
/// describe themselves alike, so that schemas learnt in one body hold in another.
#[derive(Clone, Debug, PartialEq)]
pub struct FingerArm {
    /// The body's name.
    pub name: String,
    /// The kind of body: `sim-arm`, `adept-arm`.
    pub kind: String,
    /// How many visual fields there are.
    pub fields: usize,
    /// The finger's colour.
    pub finger_colour: String,
    /// The colours of objects that are told apart, in the order of their symbols.
    pub object_colours: Vec<String>,
    /// The objects that can be placed, in the order of their symbols.
    pub objects: Vec<String>,
    /// How many places there are for objects.
    pub places: usize,
    /// The taught postures.
    pub moves: Vec<JointPositions>,
    /// The start and the end of each push. Without any, pushing is no action of the body.
    pub pushes: Vec<(JointPositions, JointPositions)>,
}

impl FingerArm {
    /// The description of a body with these properties, and the ids in it.
    #[must_use]
    pub fn declare(self) -> (Description, ArmIds) {
        let mut description = Description::new(self.name, self.kind);
        let up_to = |name, count: usize| Property::integer(name, 0..=(count as i64 - 1).max(0));
        let seen = |sense: ObservationType, colours| {
            sense.property(Property::symbol("colour", colours)).property(up_to("field", self.fields))
        };
        let finger = seen(ObservationType::state("finger").own(), vec![self.finger_colour]);
        let object = seen(ObservationType::state("object"), self.object_colours);
        let side = Property::symbol("side", Side::ALL.map(Side::symbol));
        let contact = ObservationType::event("contact").property(side);
        let joint =
            |action: ActionType, name| action.parameter(Property::real(name, 0.0..=1.0, JOINT_RESOLUTION));
        let move_to = ["j1", "j2"].into_iter().fold(ActionType::new("move"), joint);
        let push = ["j1", "j2", "to_j1", "to_j2"].into_iter().fold(ActionType::new("push"), joint);
        let of_object = |name| ActionType::new(name).parameter(Property::symbol("object", &self.objects));
        let ids = ArmIds {
            finger: description.observation(finger),
            object: description.observation(object),
            touch: description.observation(ObservationType::event("touch")),
            contact: description.observation(contact),
            move_to: description.action(move_to),
            push: (!self.pushes.is_empty()).then(|| description.action(push)),
            place: description.scene_command(of_object("place").parameter(up_to("position", self.places))),
            remove: description.scene_command(of_object("remove")),
            park: description.scene_command(ActionType::new("park")),
        };
        for JointPositions { j1, j2 } in self.moves {
            description.primitive(ids.move_to, [j1, j2]);
        }
        for (push, (from, to)) in self.pushes.iter().flat_map(|pushed| ids.push.map(|push| (push, pushed))) {
            description.primitive(push, [from.j1, from.j2, to.j1, to.j2]);
        }
        (description, ids)
    }
}

/// The sensations of an arm with a finger in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Percept {
    /// The field that the finger is seen in.
    pub finger: Option<usize>,
    /// Each object seen: the symbol of its colour, and its field.
    pub objects: Vec<(u32, usize)>,
    /// Whether the finger is in contact.
    pub touching: bool,
    /// The sides of the finger that feel the contact.
    pub sides: Vec<Side>,
}

impl Percept {
    /// Reports the sensations as observations of the types that [`FingerArm::declare`] gave these ids.
    pub fn report(&self, ids: ArmIds, frame: &mut Senses) {
        if let Some(field) = self.finger {
            frame.observe(ids.finger, (Value::Symbol(0), field as i64));
        }
        for (index, object) in self.objects.iter().enumerate() {
            // Two things of one colour in one field are one observation.
            if !self.objects[..index].contains(object) {
                let (colour, field) = *object;
                frame.observe(ids.object, (Value::Symbol(colour), field as i64));
            }
        }
        if self.touching {
            frame.observe(ids.touch, ());
        }
        for side in &self.sides {
            frame.observe(ids.contact, [Value::Symbol(*side as u32)]);
        }
    }
}

/// The symbol of a colour among those of objects: all colours that are told apart but the finger's, in their order. None
/// for the finger's own colour.
#[must_use]
pub fn object_symbol(colour: usize, finger_colour: usize) -> Option<u32> {
    let symbol = if colour > finger_colour { colour - 1 } else { colour };
    u32::try_from(symbol).ok().filter(|_| colour != finger_colour)
}
