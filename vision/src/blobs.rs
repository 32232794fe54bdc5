//! Blobs: connected regions of one colour. Runs of equal pixels along each row are joined with the runs they
//! touch in the row above (8-connected), by union-find.

use crate::classify::NO_COLOUR;

/// Blobs reported of one picture. When there are more, the largest are reported.
pub const BLOBS_MAX: usize = 256;

/// The rules that decide which pixels make a blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlobRules {
    /// Smallest area in pixels; anything smaller is noise.
    pub area_px_min: u32,
    /// Two blobs of one colour whose boxes are at most this far apart are one: something thin, as a finger's shaft,
    /// lies across it.
    pub gap_px_max: u32,
}

/// A connected region of one colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blob {
    /// Colour class: one more than the colour's index in its [`crate::classify::Classifier`].
    pub class: u8,
    /// Area in pixels.
    pub area_px: u32,
    /// Centre of area (u, v) in pixels.
    pub centre_px: (f64, f64),
    /// First column and row of the box around it.
    pub from_px: (u32, u32),
    /// Last column and row of the box around it.
    pub to_px: (u32, u32),
}

/// Finds blobs; keeps its working memory from picture to picture.
#[derive(Clone, Debug, Default)]
pub struct BlobFinder {
    runs: Vec<Run>,
    parents: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Run {
    row: u32,
    from: u32,
    to: u32,
    class: u8,
}

/// Sums over the pixels of a region, from which its blob is worked out. The sums of two parts add.
#[derive(Clone, Copy, Debug)]
struct Region {
    class: u8,
    area: u64,
    sum_u: u64,
    sum_v: u64,
    from: (u32, u32),
    to: (u32, u32),
}

impl BlobFinder {
    /// The blobs of a picture given as one class a pixel, rows of `width_px` from the top. Ordered by
    /// class, then area with the largest first, then position.
    pub fn find(&mut self, classes: &[u8], width_px: usize, rules: BlobRules) -> Vec<Blob> {
        self.collect_runs(classes, width_px);
        let mut regions = self.regions();
        regions.sort_by_key(|region| (std::cmp::Reverse(region.area), region.from));
        regions.truncate(BLOBS_MAX);
        merge_near(&mut regions, rules.gap_px_max);
        regions.retain(|region| region.area >= u64::from(rules.area_px_min));
        regions.sort_by_key(|region| (region.class, std::cmp::Reverse(region.area), region.from));
        regions.iter().map(Region::blob).collect()
    }

    fn collect_runs(&mut self, classes: &[u8], width_px: usize) {
        self.runs.clear();
        self.parents.clear();
        let mut above = 0..0;
        for (row, pixels) in classes.chunks_exact(width_px.max(1)).enumerate() {
            let first = self.runs.len();
            let mut from = blank(pixels);
            while let Some(&class) = pixels.get(from) {
                let rest = &pixels[from..];
                let length = rest.iter().position(|other| *other != class).unwrap_or(rest.len());
                let to = from + length;
                if class != NO_COLOUR {
                    self.parents.push(self.runs.len() as u32);
                    self.runs.push(Run { row: row as u32, from: from as u32, to: to as u32 - 1, class });
                }
                from = to + blank(&pixels[to..]);
            }
            let here = first..self.runs.len();
            self.join_rows(above, here.clone());
            above = here;
        }
    }

    /// Joins runs of two neighbouring rows that touch, also at corners. Both are sorted by column.
    fn join_rows(&mut self, above: std::ops::Range<usize>, here: std::ops::Range<usize>) {
        let mut upper = above.start;
        for lower in here {
            let run = self.runs[lower];
            while upper < above.end && self.runs[upper].to + 1 < run.from {
                upper += 1;
            }
            let mut touching = upper;
            while touching < above.end && self.runs[touching].from <= run.to + 1 {
                if self.runs[touching].class == run.class {
                    self.join(touching as u32, lower as u32);
                }
                touching += 1;
            }
        }
    }

    fn root(&mut self, mut run: u32) -> u32 {
        while self.parents[run as usize] != run {
            let grandparent = self.parents[self.parents[run as usize] as usize];
            self.parents[run as usize] = grandparent;
            run = grandparent;
        }
        run
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The earlier run stays the root, so regions come out in reading order.
        self.parents[a.max(b) as usize] = a.min(b);
    }

    fn regions(&mut self) -> Vec<Region> {
        let mut regions: Vec<Region> = Vec::new();
        let mut region_of_root = vec![u32::MAX; self.runs.len()];
        for index in 0..self.runs.len() {
            let part = Region::of_run(&self.runs[index]);
            let root = self.root(index as u32) as usize;
            if region_of_root[root] == u32::MAX {
                region_of_root[root] = regions.len() as u32;
                regions.push(part);
            } else {
                regions[region_of_root[root] as usize].add(&part);
            }
        }
        regions
    }
}

/// Pixels of no colour at the start, which most are; counted many at a time.
fn blank(pixels: &[u8]) -> usize {
    const STRIDE: usize = 32;
    let is_blank = |part: &&[u8]| part.iter().fold(0, |all, class| all | (class ^ NO_COLOUR)) == 0;
    let start = pixels.chunks_exact(STRIDE).take_while(is_blank).count() * STRIDE;
    start + pixels[start..].iter().take_while(|class| **class == NO_COLOUR).count()
}

impl Region {
    fn of_run(run: &Run) -> Self {
        let length = u64::from(run.to - run.from + 1);
        let sum_u = (u64::from(run.from) + u64::from(run.to)) * length / 2;
        let (from, to) = ((run.from, run.row), (run.to, run.row));
        Self { class: run.class, area: length, sum_u, sum_v: u64::from(run.row) * length, from, to }
    }

    fn add(&mut self, other: &Self) {
        self.area += other.area;
        self.sum_u += other.sum_u;
        self.sum_v += other.sum_v;
        self.from = (self.from.0.min(other.from.0), self.from.1.min(other.from.1));
        self.to = (self.to.0.max(other.to.0), self.to.1.max(other.to.1));
    }

    fn near(&self, other: &Self, gap_px: u32) -> bool {
        let apart = |from: u32, to: u32, other_from: u32, other_to: u32| {
            from.saturating_sub(other_to).max(other_from.saturating_sub(to)).saturating_sub(1)
        };
        self.class == other.class
            && apart(self.from.0, self.to.0, other.from.0, other.to.0) <= gap_px
            && apart(self.from.1, self.to.1, other.from.1, other.to.1) <= gap_px
    }

    fn blob(&self) -> Blob {
        let mean = |sum: u64| sum as f64 / self.area as f64 + 0.5;
        Blob {
            class: self.class,
            area_px: u32::try_from(self.area).unwrap_or(u32::MAX),
            centre_px: (mean(self.sum_u), mean(self.sum_v)),
            from_px: self.from,
            to_px: self.to,
        }
    }
}

/// Joins regions of one colour with little between them, until none is left to join.
fn merge_near(regions: &mut Vec<Region>, gap_px: u32) {
    let mut index = 0;
    while index < regions.len() {
        let near = (index + 1..regions.len()).find(|&other| regions[index].near(&regions[other], gap_px));
        match near {
            Some(other) => {
                let part = regions.remove(other);
                regions[index].add(&part);
                // The region has grown: earlier ones may be near it now.
                index = 0;
            }
            None => index += 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: BlobRules = BlobRules { area_px_min: 1, gap_px_max: 0 };

    fn find(rows: &[&str], rules: BlobRules) -> Vec<Blob> {
        let classes: Vec<u8> =
            rows.iter().flat_map(|row| row.bytes()).map(|b| b.saturating_sub(b'0')).collect();
        BlobFinder::default().find(&classes, rows[0].len(), rules)
    }

    #[test]
    fn centre_box_and_area() {
        let blobs = find(&["......", ".11...", ".11.2.", "......"], RULES);
        assert_eq!(blobs.len(), 2);
        let square = blobs[0];
        assert_eq!((square.class, square.area_px, square.centre_px), (1, 4, (2.0, 2.0)));
        assert_eq!((square.from_px, square.to_px), ((1, 1), (2, 2)));
        assert_eq!((blobs[1].class, blobs[1].centre_px), (2, (4.5, 2.5)));
    }

    #[test]
    fn a_u_shape_is_one_blob_and_corners_connect() {
        assert_eq!(find(&["1...1", "1...1", "11111"], RULES).len(), 1);
        assert_eq!(find(&["1....", ".1...", "..1.."], RULES).len(), 1);
        assert_eq!(find(&["1..1.", ".....", "1..1."], RULES).len(), 4);
    }

    #[test]
    fn what_a_thin_thing_divides_is_one_blob() {
        let rows = ["11.11", "11.11", "11.11"];
        assert_eq!(find(&rows, BlobRules { area_px_min: 1, gap_px_max: 0 }).len(), 2);
        let merged = find(&rows, BlobRules { area_px_min: 1, gap_px_max: 1 });
        assert_eq!(merged.len(), 1);
        assert_eq!((merged[0].area_px, merged[0].centre_px), (12, (2.5, 1.5)));
    }

    #[test]
    fn noise_is_dropped_and_their_number_is_limited() {
        assert!(find(&["1...2"], BlobRules { area_px_min: 2, gap_px_max: 0 }).is_empty());
        let speckle: Vec<u8> = (0..100 * 100).map(|i| u8::from(i % 2 == 0 && (i / 100) % 2 == 0)).collect();
        assert_eq!(BlobFinder::default().find(&speckle, 100, RULES).len(), BLOBS_MAX);
        assert!(BlobFinder::default().find(&[], 0, RULES).is_empty());
    }

    /// Against the plainest method there is: flood fill.
    #[test]
    fn agrees_with_flood_fill_on_random_pictures() {
        let mut state = 7_u64;
        for _ in 0..200 {
            let (width, height) = (17, 13);
            let classes: Vec<u8> = (0..width * height)
                .map(|_| {
                    state =
                        state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    ((state >> 40) % 3) as u8
                })
                .collect();
            let mut expected = flood_fill(&classes, width);
            let found =
                BlobFinder::default().find(&classes, width, BlobRules { area_px_min: 1, gap_px_max: 0 });
            // Boxes may touch where regions do not, and such regions are merged: compare areas by colour,
            // and the number only when nothing could be merged.
            let area = |class: u8| found.iter().filter(|b| b.class == class).map(|b| b.area_px).sum::<u32>();
            for class in [1, 2] {
                assert_eq!(area(class), classes.iter().filter(|&&c| c == class).count() as u32);
            }
            let mut finder = BlobFinder::default();
            finder.collect_runs(&classes, width);
            let mut regions: Vec<_> =
                finder.regions().iter().map(|r| (r.class, r.area, r.sum_u, r.sum_v)).collect();
            regions.sort_unstable();
            expected.sort_unstable();
            assert_eq!(regions, expected);
        }
    }

    fn flood_fill(classes: &[u8], width: usize) -> Vec<(u8, u64, u64, u64)> {
        let height = classes.len() / width;
        let mut seen = vec![false; classes.len()];
        let mut found = Vec::new();
        for start in 0..classes.len() {
            if classes[start] == NO_COLOUR || seen[start] {
                continue;
            }
            let (mut area, mut sum_u, mut sum_v) = (0, 0, 0);
            let mut open = vec![start];
            seen[start] = true;
            while let Some(at) = open.pop() {
                let (u, v) = (at % width, at / width);
                area += 1;
                sum_u += u as u64;
                sum_v += v as u64;
                for nv in v.saturating_sub(1)..=(v + 1).min(height - 1) {
                    for nu in u.saturating_sub(1)..=(u + 1).min(width - 1) {
                        let next = nv * width + nu;
                        if !seen[next] && classes[next] == classes[start] {
                            seen[next] = true;
                            open.push(next);
                        }
                    }
                }
            }
            found.push((classes[start], area, sum_u, sum_v));
        }
        found
    }
}
