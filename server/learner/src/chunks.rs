//! A growing list that is cheap to clone: chunks are shared until one of them is changed. What inspects
//! memory clones it and never delays a step.

use std::sync::Arc;

const CHUNK_LEN: usize = 64;

/// A list in shared chunks.
#[derive(Clone, Debug)]
pub struct Chunks<T> {
    chunks: Vec<Arc<Vec<T>>>,
    len: usize,
}

impl<T> Default for Chunks<T> {
    fn default() -> Self {
        Self { chunks: Vec::new(), len: 0 }
    }
}

impl<T: Clone> Chunks<T> {
    /// How many items there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The item at `at`.
    #[must_use]
    pub fn get(&self, at: usize) -> Option<&T> {
        self.chunks.get(at / CHUNK_LEN)?.get(at % CHUNK_LEN)
    }

    /// The item at `at`, to change; copies its chunk if a clone still shares it.
    pub fn get_mut(&mut self, at: usize) -> Option<&mut T> {
        Arc::make_mut(self.chunks.get_mut(at / CHUNK_LEN)?).get_mut(at % CHUNK_LEN)
    }

    /// Adds an item at the end.
    pub fn push(&mut self, item: T) {
        if self.len.is_multiple_of(CHUNK_LEN) {
            self.chunks.push(Arc::new(Vec::with_capacity(CHUNK_LEN)));
        }
        if let Some(last) = self.chunks.last_mut() {
            Arc::make_mut(last).push(item);
            self.len += 1;
        }
    }

    /// All items in order.
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.chunks.iter().flat_map(|chunk| chunk.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::Chunks;

    #[test]
    fn a_clone_keeps_what_it_saw() {
        let mut chunks = Chunks::default();
        for item in 0..200 {
            chunks.push(item);
        }
        let before = chunks.clone();
        *chunks.get_mut(70).unwrap() = 7;
        chunks.push(200);
        assert_eq!(before.get(70), Some(&70));
        assert_eq!((before.len(), chunks.len()), (200, 201));
        assert_eq!(before.iter().copied().collect::<Vec<_>>(), (0..200).collect::<Vec<_>>());
    }
}
