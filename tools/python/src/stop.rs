//! The flag that ends a run.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::prelude::*;

/// The flag that ends a run, whichever thread sets it.
#[pyclass(module = "pschema", frozen)]
#[derive(Default)]
pub(crate) struct Stop {
    flag: Arc<AtomicBool>,
}

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Ends the run, once its frame or its action is over.
    fn set(&self) {
        self.flag.store(true, Ordering::Relaxed);
    }

    /// Whether the run is to end.
    fn is_set(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }
}

impl Stop {
    pub(crate) fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.flag)
    }
}
