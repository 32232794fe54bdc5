//! What one could have taken instead: a Unix socket, messages in bincode with their length before them, both sides
//! blocking.

use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use pschema_tools::kit::Failure;
use serde::{Deserialize, Serialize};

use super::bare::RECORD_WORDS;

/// Its name in the runtime directory.
pub(super) const FILE: &str = "bench.socket";
/// How often who waits for a connection looks whether to go on; also how long a read may take.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// The longest message.
const BYTES_MAX: usize = 4 * 1024 * 1024;
/// Words of a reply: as many as one of the protocol's.
const REPLY_WORDS: usize = 47;

/// A frame as somebody would write it down: what is in a header, and records.
#[derive(Debug, Serialize, Deserialize)]
struct Frame {
    header: [u64; 7],
    records: Vec<[u64; RECORD_WORDS]>,
}

#[derive(Debug, Serialize, Deserialize)]
struct Reply {
    words: Vec<u64>,
}

fn encoded<T: Serialize>(value: &T) -> Result<Vec<u8>, Failure> {
    bincode::serde::encode_to_vec(value, bincode::config::standard()).map_err(failed)
}

fn decoded<T: for<'de> Deserialize<'de>>(bytes: &[u8]) -> Result<T, Failure> {
    let config = bincode::config::standard().with_limit::<BYTES_MAX>();
    bincode::serde::decode_from_slice(bytes, config).map(|(value, _)| value).map_err(failed)
}

fn send(stream: &mut UnixStream, bytes: &[u8]) -> io::Result<()> {
    let length = u32::try_from(bytes.len()).map_err(|_| ErrorKind::InvalidInput)?;
    let mut message = length.to_le_bytes().to_vec();
    message.extend_from_slice(bytes);
    stream.write_all(&message)
}

/// The next message; none when there will be no more.
fn receive(stream: &mut UnixStream, stop: &AtomicBool) -> io::Result<Option<Vec<u8>>> {
    let mut length = [0; 4];
    loop {
        match stream.read_exact(&mut length) {
            Ok(()) => break,
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => return Ok(None),
            // Between messages nobody is in the middle of anything.
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                if stop.load(Ordering::Relaxed) {
                    return Ok(None);
                }
            }
            Err(error) => return Err(error),
        }
    }
    let length = u32::from_le_bytes(length) as usize;
    if length > BYTES_MAX {
        return Err(io::Error::new(ErrorKind::InvalidData, format!("a message of {length} bytes")));
    }
    let mut bytes = vec![0; length];
    stream.read_exact(&mut bytes)?;
    Ok(Some(bytes))
}

fn failed(error: impl std::fmt::Display) -> Failure {
    Failure::Failed(format!("the socket can't be measured: {error}"))
}

/// Accepts one connection after another until `is_over`.
pub(super) fn serve(
    path: &Path,
    stop: &AtomicBool,
    mut is_over: impl FnMut() -> bool,
) -> Result<(), Failure> {
    let listener = UnixListener::bind(path).map_err(failed)?;
    listener.set_nonblocking(true).map_err(failed)?;
    thread::scope(|scope| {
        while !is_over() {
            match listener.accept() {
                Ok((stream, _)) => {
                    scope.spawn(move || {
                        // A client that went away has nobody to tell.
                        drop(replies(stream, stop));
                    });
                }
                Err(_) => thread::sleep(LOOK_EVERY),
            }
        }
        stop.store(true, Ordering::Relaxed);
    });
    Ok(())
}

fn replies(mut stream: UnixStream, stop: &AtomicBool) -> Result<(), Failure> {
    stream.set_nonblocking(false).map_err(failed)?;
    stream.set_read_timeout(Some(LOOK_EVERY)).map_err(failed)?;
    while let Some(bytes) = receive(&mut stream, stop).map_err(failed)? {
        let frame: Frame = decoded(&bytes)?;
        let mut words = vec![0; REPLY_WORDS];
        words[0] = frame.records.iter().flatten().fold(0_u64, |sum, word| sum.wrapping_add(*word));
        words[1] = frame.header[0];
        let reply = encoded(&Reply { words })?;
        send(&mut stream, &reply).map_err(failed)?;
    }
    Ok(())
}

/// The side that asks.
#[derive(Debug)]
pub(super) struct Socket(UnixStream);

impl Socket {
    pub(super) fn connect(path: &Path) -> io::Result<Self> {
        UnixStream::connect(path).map(Self)
    }

    /// From a frame to its reply, both made and read.
    pub(super) fn exchange(&mut self, payload: &[u64]) -> Result<Duration, Failure> {
        let (records, _) = payload.as_chunks::<RECORD_WORDS>();
        let frame = Frame { header: [payload.len() as u64; 7], records: records.to_vec() };
        let began = Instant::now();
        let bytes = encoded(&frame)?;
        send(&mut self.0, &bytes).map_err(failed)?;
        let reply = receive(&mut self.0, &AtomicBool::new(false)).map_err(failed)?;
        let reply = reply.ok_or_else(|| failed("the other side hung up"))?;
        let reply: Reply = decoded(&reply)?;
        let took = began.elapsed();
        let sum = payload.iter().fold(0_u64, |sum, word| sum.wrapping_add(*word));
        if reply.words.first() != Some(&sum) {
            return Err(failed("a payload came otherwise than it was sent"));
        }
        Ok(took)
    }
}
