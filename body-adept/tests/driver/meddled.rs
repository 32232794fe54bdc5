//! A line that garbles: it says another thing than it was told, always the same.

use std::time::Duration;

use pschema_adept::line::{Line, LineError, Stopper};

pub(crate) struct MeddlingLine {
    line: Box<dyn Line>,
    changes: &'static [(&'static str, &'static str)],
}

impl MeddlingLine {
    pub(crate) fn new(line: Box<dyn Line>, changes: &'static [(&'static str, &'static str)]) -> Self {
        Self { line, changes }
    }
}

impl Line for MeddlingLine {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        let mut text = String::from_utf8(bytes.to_vec()).unwrap();
        for (from, to) in self.changes {
            text = text.replace(from, to);
        }
        self.line.send(text.as_bytes())
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize, LineError> {
        self.line.receive(buffer, wait)
    }

    fn discard(&mut self) -> Result<(), LineError> {
        self.line.discard()
    }

    fn stopper(&self) -> Result<Box<dyn Stopper>, LineError> {
        self.line.stopper()
    }
}
