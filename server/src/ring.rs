//! The last items of a list that only grows, cheap to share: a clone costs two pointers, so that taking one delays
//! nothing.

use std::collections::VecDeque;
use std::sync::Arc;

/// At most `LEN_MAX` items, the last of all that were pushed. They stand in chunks of `CHUNK_LEN`; the oldest items are
/// dropped a chunk at a time. A push after a clone copies the chunk that it writes into, and nothing else.
#[derive(Clone, Debug)]
pub(crate) struct Ring<T, const LEN_MAX: usize, const CHUNK_LEN: usize> {
    full: Arc<VecDeque<Arc<Vec<T>>>>,
    /// The chunk that items are pushed into.
    open: Arc<Vec<T>>,
    /// Items dropped so far.
    dropped: u64,
}

impl<T, const LEN_MAX: usize, const CHUNK_LEN: usize> Default for Ring<T, LEN_MAX, CHUNK_LEN> {
    fn default() -> Self {
        const { assert!(LEN_MAX.is_multiple_of(CHUNK_LEN) && LEN_MAX > CHUNK_LEN) };
        Self { full: Arc::default(), open: Arc::default(), dropped: 0 }
    }
}

impl<T: Clone, const LEN_MAX: usize, const CHUNK_LEN: usize> Ring<T, LEN_MAX, CHUNK_LEN> {
    /// Adds an item at the end.
    pub(crate) fn push(&mut self, item: T) {
        if self.open.len() == CHUNK_LEN {
            let full = Arc::make_mut(&mut self.full);
            full.push_back(std::mem::take(&mut self.open));
            if full.len() * CHUNK_LEN == LEN_MAX {
                self.drop_oldest();
            }
        }
        Arc::make_mut(&mut self.open).push(item);
    }

    /// Drops the oldest items until at most `len` are left, or those of one chunk.
    pub(crate) fn shorten(&mut self, len: usize) {
        while self.len() > len && !self.full.is_empty() {
            self.drop_oldest();
        }
    }

    fn drop_oldest(&mut self) {
        if Arc::make_mut(&mut self.full).pop_front().is_some() {
            self.dropped += CHUNK_LEN as u64;
        }
    }

    /// How many items are left.
    pub(crate) fn len(&self) -> usize {
        self.full.len() * CHUNK_LEN + self.open.len()
    }

    /// How many items have been pushed.
    pub(crate) fn total(&self) -> u64 {
        self.dropped + self.len() as u64
    }

    /// The items from number `from` on, counted from the first ever pushed, or from the oldest that is left; with the
    /// number of the first.
    pub(crate) fn from(&self, from: u64) -> (u64, impl DoubleEndedIterator<Item = &T>) {
        let first = from.clamp(self.dropped, self.total());
        let skipped = usize::try_from(first - self.dropped).unwrap_or(usize::MAX);
        let chunks = self.full.range(self.full.len().min(skipped / CHUNK_LEN)..).chain([&self.open]);
        let within = skipped - (skipped / CHUNK_LEN).min(self.full.len()) * CHUNK_LEN;
        let mut items = chunks.flat_map(|chunk| chunk.iter());
        if let Some(last) = within.checked_sub(1) {
            items.nth(last);
        }
        (first, items)
    }
}

#[cfg(test)]
mod tests {
    use super::Ring;

    type Small = Ring<u64, 12, 4>;

    fn pushed(total: u64) -> Small {
        let mut ring = Small::default();
        (0..total).for_each(|item| ring.push(item));
        ring
    }

    fn items(ring: &Small, from: u64) -> (u64, Vec<u64>) {
        let (first, items) = ring.from(from);
        (first, items.copied().collect())
    }

    #[test]
    fn the_last_items_are_left_and_numbered_as_they_came() {
        for total in 0..40 {
            let ring = pushed(total);
            // Room is made by the chunk, and only when it is needed.
            let first = if total <= 12 { 0 } else { (total - 12).div_ceil(4) * 4 };
            assert_eq!(ring.total(), total);
            for from in 0..total + 3 {
                let begin = from.clamp(first, total);
                assert_eq!(items(&ring, from), (begin, (begin..total).collect()), "{from} of {total}");
            }
            let backwards: Vec<_> = ring.from(0).1.rev().copied().collect();
            assert_eq!(backwards, (first..total).rev().collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_ring_that_is_shortened_has_the_last_items_and_their_numbers() {
        for (total, len, left) in [(10, 9, 6), (10, 6, 6), (10, 0, 2), (8, 3, 4), (3, 0, 3), (0, 0, 0)] {
            let mut ring = pushed(total);
            ring.shorten(len);
            assert_eq!(items(&ring, 0), (total - left, (total - left..total).collect()), "{len} of {total}");
            assert_eq!(ring.total(), total);
            ring.push(total);
            assert_eq!(items(&ring, total), (total, vec![total]));
        }
    }

    #[test]
    fn a_clone_keeps_its_items() {
        for total in 1..30 {
            let mut ring = pushed(total);
            let clone = ring.clone();
            let before = items(&clone, 0);
            (0..9).for_each(|item| ring.push(item));
            assert_eq!((items(&clone, 0), ring.total()), (before, total + 9));
        }
    }
}
