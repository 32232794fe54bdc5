//! What the simulated body says of itself: its senses, its actions, its scene commands.

use pschema_protocol::description::{
    Action, ActionType, Description, ObservationType, Property, Value, ValueKind,
};

use crate::config::WorldFile;
use crate::manifold::JointPositions;
use crate::touch::Side;
use crate::workspace::{JOINT_RESOLUTION, Workspace};

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

/// The description of a body in a work space.
#[must_use]
pub fn description(name: &str, workspace: &Workspace) -> Description {
    let file = &workspace.file;
    let field = || {
        let max = (workspace.fields.count() as i64 - 1).max(0);
        property("field", ValueKind::Integer { min: 0, max })
    };
    let colour = property("colour", symbols(object_colours(file)));
    let finger_colour = property("colour", symbols(std::iter::once(file.finger.colour.clone())));
    let side = property("side", symbols(Side::ALL.iter().map(|side| side.symbol().to_owned())));
    let object = || property("object", symbols(file.objects.iter().map(|object| object.name.clone())));
    let position = ValueKind::Integer { min: 0, max: (workspace.places.len() as i64 - 1).max(0) };
    let joint = |name| property(name, ValueKind::Real { min: 0.0, max: 1.0, resolution: JOINT_RESOLUTION });
    let mut actions = vec![ActionType { name: "move".into(), parameters: vec![joint("j1"), joint("j2")] }];
    if !workspace.pushes.is_empty() {
        let parameters = ["j1", "j2", "to_j1", "to_j2"].map(joint).to_vec();
        actions.push(ActionType { name: "push".into(), parameters });
    }
    let real = |joints: &JointPositions| [Value::Real(joints.j1), Value::Real(joints.j2)];
    let moves = workspace
        .taught
        .iter()
        .map(|taught| Action { action: action::MOVE, parameters: real(&taught.joints).to_vec() });
    let pushes = workspace
        .pushes
        .iter()
        .map(|push| Action { action: action::PUSH, parameters: [real(&push.from), real(&push.to)].concat() });
    Description {
        name: name.to_owned(),
        kind: "sim-arm".to_owned(),
        observation_types: vec![
            sense("finger", true, false, vec![finger_colour, field()]),
            sense("object", false, false, vec![colour, field()]),
            sense("touch", false, true, Vec::new()),
            sense("contact", false, true, vec![side]),
        ],
        actions,
        repertoire: moves.chain(pushes).collect(),
        scene_commands: vec![
            ActionType { name: "place".into(), parameters: vec![object(), property("position", position)] },
            ActionType { name: "remove".into(), parameters: vec![object()] },
            ActionType { name: "park".into(), parameters: Vec::new() },
        ],
    }
}

/// The symbol of a colour by its index in the world file: all colours but the finger's, in order. None for
/// the finger's.
#[must_use]
pub fn colour_symbol(file: &WorldFile, colour: usize) -> Option<u32> {
    let name = &file.colours.get(colour)?.name;
    object_colours(file).position(|other| other == *name).and_then(|index| u32::try_from(index).ok())
}

fn object_colours(file: &WorldFile) -> impl Iterator<Item = String> {
    file.colours.iter().map(|colour| colour.name.clone()).filter(|name| *name != file.finger.colour)
}

fn sense(name: &str, own: bool, transient: bool, properties: Vec<Property>) -> ObservationType {
    ObservationType { name: name.to_owned(), own, transient, properties }
}

fn property(name: &str, kind: ValueKind) -> Property {
    Property { name: name.to_owned(), kind, unit: String::new() }
}

fn symbols(symbols: impl Iterator<Item = String>) -> ValueKind {
    ValueKind::Symbol { symbols: symbols.collect() }
}
