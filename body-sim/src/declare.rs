//! How the simulated body describes itself.

use std::path::Path;

use pschema_arm::{ArmIds, FingerArm};
use pschema_protocol::description::Description;

use crate::config::WorldFile;
use crate::noise::Noise;
use crate::workspace::Workspace;

/// So much of a world's name is said, in bytes, and so many hexadecimal digits of the digest.
const NAME_BYTES_SAID: usize = 15;
const DIGITS_SAID: usize = 8;

/// The description of a body in a work space, and the ids in it. `world` is the name of the world, or of its file.
#[must_use]
pub fn declare(name: &str, world: &str, workspace: &Workspace) -> (Description, ArmIds) {
    let file = &workspace.file;
    let colours = file.colours.iter().map(|colour| colour.name.clone());
    let (description, ids) = FingerArm {
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
    .declare();
    (description.in_world(&identity(world, file)), ids)
}

/// What tells a world from others that look alike: its name, without its folder, and a digest of all that the file says but for
/// the faults of senses and moves. Those are the body's, and its fields mean the same with them and without.
fn identity(name: &str, file: &WorldFile) -> String {
    let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    let mut said: String =
        stem.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '.')).collect();
    while said.len() > NAME_BYTES_SAID {
        said.pop();
    }
    // Read values are written, so that comments and the order of keys make no other world.
    let values = format!("{:?}", WorldFile { noise: Noise::default(), ..file.clone() });
    let digest = blake3::hash(values.as_bytes()).to_hex();
    format!("{said}-{}", digest.get(..DIGITS_SAID).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use crate::config::{NARROW, WIDE};

    use super::*;

    fn kind(name: &str, text: &str) -> String {
        let workspace = Workspace::new(name, WorldFile::parse(name, text).unwrap()).unwrap();
        let (description, _) = declare("arm", name, &workspace);
        description.check().unwrap();
        assert_eq!(description.kind_and_world().0, "sim-arm");
        description.kind
    }

    /// Another friction looks the same in all that a body declares beside its world.
    #[test]
    fn a_world_is_told_from_others_that_look_alike() {
        let wide = kind("wide", WIDE);
        assert!(wide.starts_with("sim-arm@wide-"), "{wide}");
        assert_ne!(kind("wide", &WIDE.replace("friction = 0.9", "friction = 0.2")), wide);
        assert_ne!(kind("wide", NARROW), wide);
        // The same world says the same, wherever its file is and however it is written.
        assert_eq!(
            kind("/some/where/wide.toml", &WIDE.replace("friction = 0.9", "friction = 0.90 # wood")),
            wide
        );
        assert_eq!(
            kind("wide", &WIDE.replace("blob_missed = 0 ", "blob_missed = 0.1 ")),
            wide,
            "a fault of the eye"
        );
        let long = kind("ein-sehr-langer-name-ä@ öüß.toml", WIDE);
        assert!(long.starts_with("sim-arm@ein-sehr-langer-"), "{long}");
    }
}
