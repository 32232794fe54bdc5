//! Storeys: the files of a crate in layers, each of which may import from its own layer and from those below it.

use std::path::Path;

use crate::plan::Storey;
use crate::source::Imports;

/// Every way in which the crate whose source is in `folder` is built otherwise than its storeys say.
pub fn problems(folder: &Path, storeys: &[Storey], imports: &[&Imports]) -> Vec<String> {
    let mut problems = Vec::new();
    let rooms = imports.iter().flat_map(|imports| &imports.rooms).filter(|room| room.starts_with(folder));
    for room in rooms.clone().filter(|room| place(storeys, room).is_none()) {
        problems
            .push(format!("{} is in no storey: say in ARCHITECTURE.md which it belongs to", room.display()));
    }
    for (storey, named) in
        storeys.iter().flat_map(|storey| storey.rooms.iter().map(move |room| (storey, room)))
    {
        if !rooms.clone().any(|room| room.starts_with(named)) {
            problems.push(format!(
                "storey {} names {}, and there is no such file",
                storey.name,
                named.display()
            ));
        }
    }
    for arrow in imports.iter().flat_map(|imports| &imports.arrows) {
        let (Some(from), Some(to)) = (place(storeys, &arrow.from), place(storeys, &arrow.to)) else {
            continue;
        };
        if to < from {
            problems.push(format!(
                "{}:{} (in {}) takes {} from {} (in {}, which is above)",
                arrow.from.display(),
                arrow.line,
                storeys[from].name,
                arrow.name,
                arrow.to.display(),
                storeys[to].name
            ));
        }
    }
    problems
}

/// Which storey a file is in, 0 for the highest. The longest path that fits decides, so that a file may be in another storey than
/// the folder around it.
fn place(storeys: &[Storey], file: &Path) -> Option<usize> {
    let places = storeys.iter().enumerate().flat_map(|(at, storey)| {
        let fitting = storey.rooms.iter().filter(|room| file.starts_with(room));
        fitting.map(move |room| (room.components().count(), at))
    });
    places.max().map(|(_, at)| at)
}
