//! Rings: files that import each other, directly or by way of other files.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::source::Arrow;

/// The rings of some files, each as the arrows that tie it. The largest set of files that all reach each other is one ring.
pub fn rings<'a>(arrows: impl IntoIterator<Item = &'a Arrow>) -> Vec<Vec<&'a Arrow>> {
    let arrows: Vec<&Arrow> = arrows.into_iter().collect();
    let mut targets: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
    for arrow in &arrows {
        targets.entry(&arrow.from).or_default().insert(&arrow.to);
    }
    let reached: BTreeMap<&Path, BTreeSet<&Path>> =
        targets.keys().map(|file| (*file, reached_from(file, &targets))).collect();
    let reaches = |from: &Path, to: &Path| reached.get(from).is_some_and(|files| files.contains(to));
    let mut rings: BTreeMap<&Path, Vec<&Arrow>> = BTreeMap::new();
    for arrow in arrows {
        if reaches(&arrow.to, &arrow.from) {
            // A ring is known by the first of its files.
            let others = reached[&*arrow.from].iter().filter(|file| reaches(file, &arrow.from));
            let first = others.min().copied().unwrap_or(&arrow.from);
            rings.entry(first).or_default().push(arrow);
        }
    }
    rings.into_values().collect()
}

/// Every file that can be reached from `file` along arrows.
fn reached_from<'a>(file: &'a Path, targets: &BTreeMap<&'a Path, BTreeSet<&'a Path>>) -> BTreeSet<&'a Path> {
    let mut reached = BTreeSet::new();
    let mut waiting = vec![file];
    while let Some(next) = waiting.pop() {
        for target in targets.get(next).into_iter().flatten() {
            if reached.insert(*target) {
                waiting.push(target);
            }
        }
    }
    reached
}

/// A ring in words: one line for each pair of files, with the names that the first takes from the second.
pub fn told(ring: &[&Arrow]) -> String {
    let mut pairs: BTreeMap<(&Path, &Path), Vec<String>> = BTreeMap::new();
    for arrow in ring {
        let named = format!("{} (line {})", arrow.name, arrow.line);
        pairs.entry((&arrow.from, &arrow.to)).or_default().push(named);
    }
    let lines = pairs.iter().map(|((from, to), names)| {
        format!("  {} takes from {}: {}\n", from.display(), to.display(), names.join(", "))
    });
    lines.collect()
}
