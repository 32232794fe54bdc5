//! The package's exceptions, which are written in Python, as the errors of the Rust crates become them.

use std::fmt::Display;

use pschema_protocol::body::RunError;
use pschema_protocol::client::ClientError;
use pschema_protocol::transport::TransportError;
use pyo3::import_exception;
use pyo3::prelude::*;

import_exception!(pschema.errors, Error);
import_exception!(pschema.errors, ArgumentError);
import_exception!(pschema.errors, DeclarationError);
import_exception!(pschema.errors, FrameError);
import_exception!(pschema.errors, NoDaemonError);
import_exception!(pschema.errors, RefusedError);
import_exception!(pschema.errors, AnswerError);

/// For `map_err`: an error that is said as it prints.
pub(crate) fn error(said: impl Display) -> PyErr {
    Error::new_err(said.to_string())
}

/// Why a body's run failed.
pub(crate) fn of_run(failed: RunError) -> PyErr {
    match failed {
        RunError::Description(refusal) => DeclarationError::new_err(refusal.to_string()),
        RunError::FramesRefused { .. } => FrameError::new_err(failed.to_string()),
        RunError::Refused { code, .. } => RefusedError::new_err((failed.to_string(), code)),
        // There is no place for it, which is no refusal of the protocol and has no number.
        RunError::Transport(TransportError::Full { .. }) => RefusedError::new_err((failed.to_string(), 0)),
        failed => error(failed),
    }
}

/// Why a daemon could not be asked.
pub(crate) fn of_client(failed: &ClientError) -> PyErr {
    let said = failed.to_string();
    if failed.is_no_daemon() { NoDaemonError::new_err(said) } else { error(said) }
}
