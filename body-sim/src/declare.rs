//! How the simulated body describes itself.

use pschema_arm::{ArmIds, FingerArm};
use pschema_protocol::description::Description;

use crate::workspace::Workspace;

/// The description of a body in a work space, and the ids in it.
#[must_use]
pub fn declare(name: &str, workspace: &Workspace) -> (Description, ArmIds) {
    let file = &workspace.file;
    let colours = file.colours.iter().map(|colour| colour.name.clone());
    FingerArm {
        name: name.to_owned(),
        kind: "sim-arm".to_owned(),
        fields: workspace.fields.count(),
        finger_colour: file.finger.colour.clone(),
        object_colours: colours.filter(|name| *name != file.finger.colour).collect(),
        objects: file.objects.iter().map(|object| object.name.clone()).collect(),
        places: workspace.places.len(),
        moves: workspace.taught.iter().map(|taught| taught.joints).collect(),
        pushes: workspace.pushes.iter().map(|push| (push.from, push.to)).collect(),
    }
    .declare()
}
