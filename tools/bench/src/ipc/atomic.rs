//! The least that is possible: two threads that see the same memory, and a number by which each knows that it is its turn.

use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// What both threads see.
#[derive(Debug)]
pub(super) struct Atomic {
    asked: AtomicU64,
    answered: AtomicU64,
    sum: AtomicU64,
    payload: Vec<AtomicU64>,
}

impl Atomic {
    pub(super) fn new(words: usize) -> Self {
        Self {
            asked: AtomicU64::new(0),
            answered: AtomicU64::new(0),
            sum: AtomicU64::new(0),
            payload: (0..words).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// So many payloads written, each read by the other thread: how long each took.
    pub(super) fn exchanges(&mut self, payload: &[u64], exchanges: u32) -> Vec<Duration> {
        (*self.asked.get_mut(), *self.answered.get_mut()) = (0, 0);
        let shared = &*self;
        thread::scope(|scope| {
            scope.spawn(move || (1..=u64::from(exchanges)).for_each(|number| shared.answer(number)));
            (1..=u64::from(exchanges)).map(|number| shared.ask(number, payload)).collect()
        })
    }

    fn ask(&self, number: u64, payload: &[u64]) -> Duration {
        let began = Instant::now();
        for (to, from) in self.payload.iter().zip(payload) {
            to.store(*from, Ordering::Relaxed);
        }
        self.asked.store(number, Ordering::Release);
        while self.answered.load(Ordering::Acquire) != number {
            std::hint::spin_loop();
        }
        began.elapsed()
    }

    fn answer(&self, number: u64) {
        while self.asked.load(Ordering::Acquire) != number {
            std::hint::spin_loop();
        }
        let read = |sum: u64, word: &AtomicU64| sum.wrapping_add(word.load(Ordering::Relaxed));
        self.sum.store(self.payload.iter().fold(0, read), Ordering::Relaxed);
        self.answered.store(number, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_payload_is_read_by_the_other_thread() {
        let mut atomic = Atomic::new(3);
        assert_eq!(atomic.exchanges(&[1, 2, 3], 10).len(), 10);
        assert_eq!(atomic.sum.load(Ordering::Relaxed), 6);
        assert_eq!(atomic.exchanges(&[4, 5, 6], 2).len(), 2);
        assert_eq!(atomic.sum.load(Ordering::Relaxed), 15);
    }
}
