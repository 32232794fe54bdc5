//! Messages to a service manager: the daemon answers, the daemon is at such a step, its loop still turns, it ends.
//! The protocol is that of `sd_notify(3)`: lines of text to the socket that `NOTIFY_SOCKET` names, which is a path or, after
//! `@`, an abstract name. Without that variable no message is sent.
//!
//! The crate sd-notify (0.5.0) does not serve here: it can't reach an abstract name, and it waits for a manager that does
//! not read, which would stop the loop.

use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

/// How often the manager is told the daemon's status, if it does not ask for more.
const STATUS_EVERY: Duration = Duration::from_secs(10);
/// The shortest time between two messages.
const STATUS_EVERY_MIN: Duration = Duration::from_millis(10);

/// The service manager, from the daemon's side. Only the daemon's loop sends messages, so that a loop that is stuck is
/// silent: the manager then starts the daemon again.
#[derive(Debug)]
pub(crate) struct Supervisor {
    socket: Option<UnixDatagram>,
    every: Duration,
    watched: bool,
    next: Instant,
}

impl Supervisor {
    /// The manager that the environment names.
    pub(crate) fn from_environment() -> Self {
        let socket = connect().unwrap_or_else(|error| {
            tracing::warn!(%error, "NOTIFY_SOCKET is set, and the service manager can't be reached by it");
            None
        });
        let watchdog = watchdog();
        // A tenth of the manager's patience. The manual advises half of it, but a busy machine may delay the loop.
        let every = watchdog.map_or(STATUS_EVERY, |patience| STATUS_EVERY.min(patience / 10));
        let every = every.max(STATUS_EVERY_MIN);
        Self { socket, every, watched: watchdog.is_some(), next: Instant::now() }
    }

    /// How long the loop may sleep and still send its next message in time.
    pub(crate) fn sleep_max(&self) -> Duration {
        self.every
    }

    /// Tells that the daemon answers.
    pub(crate) fn ready(&self, status: &str) {
        self.tell(&format!("READY=1\nSTATUS={status}\n"));
    }

    /// Tells that the loop turns, and the daemon's status. `status` is called only when it is time for a message.
    pub(crate) fn turned(&mut self, status: impl FnOnce() -> String) {
        let now = Instant::now();
        if now < self.next || self.socket.is_none() {
            return;
        }
        self.next = now + self.every;
        let ping = if self.watched { "WATCHDOG=1\n" } else { "" };
        self.tell(&format!("STATUS={}\n{ping}", status()));
    }

    /// Tells that the daemon ends.
    pub(crate) fn stopping(&self) {
        self.tell("STOPPING=1\nSTATUS=ending\n");
    }

    /// Sends a message, without ever waiting: a manager that does not read misses some.
    fn tell(&self, message: &str) {
        if let Some(socket) = &self.socket
            && let Err(error) = socket.send(message.as_bytes())
        {
            tracing::debug!(%error, "the service manager could not be told");
        }
    }
}

fn connect() -> io::Result<Option<UnixDatagram>> {
    let Some(name) = std::env::var_os("NOTIFY_SOCKET").filter(|name| !name.is_empty()) else {
        return Ok(None);
    };
    let address = match name.as_bytes().strip_prefix(b"@") {
        Some(name) => SocketAddr::from_abstract_name(name)?,
        None => SocketAddr::from_pathname(&name)?,
    };
    let socket = UnixDatagram::unbound()?;
    socket.set_nonblocking(true)?;
    socket.connect_addr(&address)?;
    Ok(Some(socket))
}

/// How long a silence the manager allows; none if it does not watch this process.
fn watchdog() -> Option<Duration> {
    let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let ours = number("WATCHDOG_PID").is_none_or(|pid| pid == u64::from(std::process::id()));
    number("WATCHDOG_USEC").filter(|patience| ours && *patience > 0).map(Duration::from_micros)
}
