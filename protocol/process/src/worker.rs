//! A thread that ends with its owner.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};

/// A thread that works until its owner drops this: the thread is then told to stop, woken if it is parked, and waited for.
#[derive(Debug)]
pub struct Worker {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts a thread of this name. `work` returns soon after the flag that it is given is set.
    ///
    /// # Errors
    /// When the system starts no thread.
    pub fn start(name: &str, work: impl FnOnce(&AtomicBool) + Send + 'static) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let thread = Builder::new().name(name.to_owned()).spawn(move || work(&flag))?;
        Ok(Self { stop, thread: Some(thread) })
    }

    /// Wakes the thread, should it be parked.
    pub fn wake(&self) {
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        self.wake();
        let Some(thread) = self.thread.take() else { return };
        let name = thread.thread().name().unwrap_or_default().to_owned();
        if thread.join().is_err() {
            tracing::error!(thread = name, "a thread had panicked; its work was not done since");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parked_thread_is_woken_and_waited_for() {
        let ended = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&ended);
        let worker = Worker::start("test", move |stop| {
            while !stop.load(Ordering::SeqCst) {
                std::thread::park();
            }
            told.store(true, Ordering::SeqCst);
        });
        drop(worker.expect("a thread can be started"));
        assert!(ended.load(Ordering::SeqCst));
    }

    #[test]
    fn a_thread_that_panicked_does_not_end_its_owner() {
        drop(Worker::start("test", |_| panic!("as the test wants it")).expect("a thread can be started"));
    }
}
