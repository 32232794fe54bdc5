//! A port that takes every line apart by itself, knows nothing of the driver's gate, and writes down every motion.
//! Motions arrive at once.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use pschema_adept::line::{Line, LineError, Stopper};

/// What the port was told, and what it makes of it.
#[derive(Default)]
pub(crate) struct Port {
    pub(crate) joints: Vec<f64>,
    vias: Vec<Vec<f64>>,
    /// All points of all motions begun, with their speeds.
    pub(crate) targets: Vec<(u32, Vec<f64>)>,
    pending: Vec<(u32, Vec<f64>)>,
    pub(crate) motions: u64,
    last: u32,
    line: Vec<u8>,
    out: VecDeque<u8>,
}

#[derive(Clone)]
pub(crate) struct FakeLine(pub(crate) Arc<Mutex<Port>>);

impl FakeLine {
    pub(crate) fn at(joints: &[f64]) -> Self {
        Self(Arc::new(Mutex::new(Port { joints: joints.to_vec(), ..Port::default() })))
    }
}

fn fletcher(text: &str) -> u32 {
    let (mut low, mut high) = (0, 0);
    for byte in text.bytes() {
        low = (low + u32::from(byte)) % 255;
        high = (high + low) % 255;
    }
    (high << 8) | low
}

impl Port {
    fn say(&mut self, text: &str) {
        let line = format!("{text} *{}\r\n", fletcher(text));
        self.out.extend(line.into_bytes());
    }

    fn obey(&mut self, line: &str) {
        if line.is_empty() || line == "STOP" {
            self.vias.clear();
            self.pending.clear();
            return;
        }
        let (text, sum) = line.rsplit_once(" *").unwrap_or_else(|| panic!("a line without a sum: {line:?}"));
        assert_eq!(sum.parse::<u32>().ok(), Some(fletcher(text)), "{line:?}");
        let words: Vec<&str> = text.split(' ').collect();
        let number: u32 = words[1].parse().unwrap();
        let values =
            |from: usize| -> Vec<f64> { words[from..].iter().map(|word| word.parse().unwrap()).collect() };
        match words[0] {
            "HELLO" => self.say(&format!("OK {number} PSCHEMA 1 {} 1000", self.joints.len())),
            "STAT" => self.say(&format!("OK {number} 1 1 0 0 0 0 {} 0", self.last)),
            "WHERE" => {
                let joints: Vec<String> = self.joints.iter().map(|joint| format!("{joint:.3}")).collect();
                self.say(&format!("OK {number} {}", joints.join(" ")));
            }
            "VIA" => {
                self.pending.push((words[2].parse().unwrap(), values(3)));
                self.say(&format!("OK {number} {}", self.pending.len()));
            }
            "MOVE" => {
                assert!(number > self.last, "an order that was sent before");
                self.pending.push((words[3].parse().unwrap(), values(4)));
                self.joints = values(4);
                self.targets.append(&mut self.pending);
                self.motions += 1;
                self.last = number;
                self.say(&format!("OK {number}"));
                self.say(&format!("END {number} 0"));
            }
            "STOP" | "PING" | "RESET" | "POWER" => {
                self.pending.clear();
                self.say(&format!("OK {number}"));
            }
            other => panic!("the driver said {other:?}"),
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match byte {
                3 => {}
                b'\n' => {
                    let line = String::from_utf8(std::mem::take(&mut self.line)).unwrap();
                    self.obey(&line);
                }
                byte => self.line.push(*byte),
            }
        }
    }
}

impl Line for FakeLine {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.0.lock().unwrap().take(bytes);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize, LineError> {
        let mut port = self.0.lock().unwrap();
        let count = buffer.len().min(port.out.len());
        if count == 0 {
            drop(port);
            std::thread::sleep(wait);
            return Ok(0);
        }
        for (to, byte) in buffer.iter_mut().zip(port.out.drain(..count)) {
            *to = byte;
        }
        Ok(count)
    }

    fn discard(&mut self) -> Result<(), LineError> {
        self.0.lock().unwrap().out.clear();
        Ok(())
    }

    fn stopper(&self) -> Result<Box<dyn Stopper>, LineError> {
        Ok(Box::new(self.clone()))
    }
}

impl Stopper for FakeLine {
    fn stop(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.0.lock().unwrap().take(bytes);
        Ok(())
    }
}
