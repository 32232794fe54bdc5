//! What an arm with a finger says of itself - its senses, its actions, its scene commands - and how it reports.

use pschema_protocol::body::Senses;
use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};

use crate::side::Side;
use crate::square::{JOINT_RESOLUTION, JointPositions};

/// Indexes of the observation types.
pub mod observation {
    /// `finger{colour, field}`: where the finger is seen, told by its colour like anything else.
    pub const FINGER: u16 = 0;
    /// `object{colour, field}`: where something is seen.
    pub const OBJECT: u16 = 1;
    /// `touch{}`: the finger is in contact with something.
    pub const TOUCH: u16 = 2;
    /// `contact{side}`: which side of the finger feels it.
    pub const CONTACT: u16 = 3;
}

/// Indexes of the actions.
pub mod action {
    /// `move{j1, j2}`: go to joint positions; a contact ends it.
    pub const MOVE: u16 = 0;
    /// `push{j1, j2, to_j1, to_j2}`: set the finger down at joint positions, go straight to others, on through
    /// contact. Only of a body whose world has pushes.
    pub const PUSH: u16 = 1;
}

/// Indexes of the scene commands.
pub mod scene {
    /// `place{object, position}`: put an object down; the arm is parked first.
    pub const PLACE: u16 = 0;
    /// `remove{object}`: take it away.
    pub const REMOVE: u16 = 1;
    /// `park{}`: take the arm to its rest posture, out of sight.
    pub const PARK: u16 = 2;
}

/// What distinguishes one arm with a finger under a camera from another, simulated or real: all of them
/// describe themselves alike, so that what was learnt in one holds in another.
#[derive(Clone, Debug, PartialEq)]
pub struct FingerArm {
    /// The body's name.
    pub name: String,
    /// What kind of body.
    pub kind: String,
    /// How many visual fields there are.
    pub fields: usize,
    /// The finger's colour.
    pub finger_colour: String,
    /// The colours of objects that are told apart, in the order of their symbols.
    pub object_colours: Vec<String>,
    /// The objects that can be placed, in the order of their symbols.
    pub objects: Vec<String>,
    /// How many places there are for them.
    pub places: usize,
    /// The taught postures.
    pub moves: Vec<JointPositions>,
    /// The pushes, from and to; without any, pushing is no action of the body.
    pub pushes: Vec<(JointPositions, JointPositions)>,
}

impl FingerArm {
    /// The description of such a body.
    #[must_use]
    pub fn describe(self) -> Description {
        let max = (self.fields as i64 - 1).max(0);
        let field = || property("field", ValueKind::Integer { min: 0, max });
        let colour = property("colour", ValueKind::Symbol { symbols: self.object_colours });
        let finger_colour = property("colour", ValueKind::Symbol { symbols: vec![self.finger_colour] });
        let sides = Side::ALL.iter().map(|side| side.symbol().to_owned()).collect();
        let side = property("side", ValueKind::Symbol { symbols: sides });
        let object = || property("object", ValueKind::Symbol { symbols: self.objects.clone() });
        let position = ValueKind::Integer { min: 0, max: (self.places as i64 - 1).max(0) };
        let joint =
            |name| property(name, ValueKind::Real { min: 0.0, max: 1.0, resolution: JOINT_RESOLUTION });
        let mut actions =
            vec![ActionType { name: "move".into(), parameters: vec![joint("j1"), joint("j2")] }];
        if !self.pushes.is_empty() {
            let parameters = ["j1", "j2", "to_j1", "to_j2"].map(joint).to_vec();
            actions.push(ActionType { name: "push".into(), parameters });
        }
        let real = |joints: &JointPositions| [Value::Real(joints.j1), Value::Real(joints.j2)];
        let moves = self.moves.iter();
        let moves = moves.map(|to| Action { action: action::MOVE, parameters: real(to).to_vec() });
        let pushes = self
            .pushes
            .iter()
            .map(|(from, to)| Action { action: action::PUSH, parameters: [real(from), real(to)].concat() });
        Description {
            name: self.name,
            kind: self.kind,
            observation_types: vec![
                sense("finger", true, false, vec![finger_colour, field()]),
                sense("object", false, false, vec![colour, field()]),
                sense("touch", false, true, Vec::new()),
                sense("contact", false, true, vec![side]),
            ],
            actions,
            repertoire: moves.chain(pushes).collect(),
            scene_commands: vec![
                ActionType {
                    name: "place".into(),
                    parameters: vec![object(), property("position", position)],
                },
                ActionType { name: "remove".into(), parameters: vec![object()] },
                ActionType { name: "park".into(), parameters: Vec::new() },
            ],
        }
    }
}

/// What such a body senses in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Percept {
    /// The field that the finger is seen in.
    pub finger: Option<usize>,
    /// The symbol of the colour and the field of each object seen.
    pub objects: Vec<(u32, usize)>,
    /// Whether the finger is in contact.
    pub touching: bool,
    /// The sides that feel it.
    pub sides: Vec<Side>,
}

impl Percept {
    /// Reports it all as observations of the types declared by [`FingerArm`].
    pub fn report(&self, frame: &mut Senses) {
        if let Some(field) = self.finger {
            frame.observe(observation::FINGER, &[Value::Symbol(0), Value::Integer(field as i64)]);
        }
        for (index, object) in self.objects.iter().enumerate() {
            // Two things of one colour in one field are one observation.
            if !self.objects[..index].contains(object) {
                let (colour, field) = *object;
                frame.observe(observation::OBJECT, &[Value::Symbol(colour), Value::Integer(field as i64)]);
            }
        }
        if self.touching {
            frame.observe(observation::TOUCH, &[]);
        }
        for side in &self.sides {
            frame.observe(observation::CONTACT, &[Value::Symbol(*side as u32)]);
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

fn sense(name: &str, own: bool, transient: bool, properties: Vec<Property>) -> ObservationType {
    ObservationType { name: name.to_owned(), own, transient, properties }
}

fn property(name: &str, kind: ValueKind) -> Property {
    Property { name: name.to_owned(), kind, unit: String::new() }
}
