//! What a service manager is told: that the daemon answers, what it is doing, that its loop still turns, that it ends.
//! The protocol is that of `sd_notify(3)`: lines of text to the socket that `NOTIFY_SOCKET` names, a path or, after `@`, an
//! abstract name. Without one nothing is told to anyone.

use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

/// How often the manager is told what the daemon is doing, when it does not ask for more.
const STATUS_EVERY: Duration = Duration::from_secs(10);
/// The most often it is told.
const STATUS_EVERY_MIN: Duration = Duration::from_millis(10);

/// The service manager, from the daemon's side. Used by the daemon's loop and nobody else: a loop that is stuck is
/// silent, and the manager starts the daemon again.
#[derive(Debug)]
pub(crate) struct Supervisor {
    socket: Option<UnixDatagram>,
    every: Duration,
    watched: bool,
    next: Instant,
}

impl Supervisor {
    /// As the environment says.
    pub(crate) fn from_environment() -> Self {
        let socket = connected().unwrap_or_else(|error| {
            tracing::warn!(%error, "NOTIFY_SOCKET is set, and the service manager can't be reached by it");
            None
        });
        let watchdog = watchdog();
        // A tenth of the manager's patience: it advises half, and a busy machine takes its time.
        let every = watchdog.map_or(STATUS_EVERY, |patience| STATUS_EVERY.min(patience / 10));
        let every = every.max(STATUS_EVERY_MIN);
        Self { socket, every, watched: watchdog.is_some(), next: Instant::now() }
    }

    /// How long the loop may sleep and still tell in time.
    pub(crate) fn sleep_max(&self) -> Duration {
        self.every
    }

    /// The daemon answers.
    pub(crate) fn ready(&self, status: &str) {
        self.tell(&format!("READY=1\nSTATUS={status}\n"));
    }

    /// The loop turns. `status` is asked for when it is time to tell.
    pub(crate) fn turned(&mut self, status: impl FnOnce() -> String) {
        let now = Instant::now();
        if now < self.next || self.socket.is_none() {
            return;
        }
        self.next = now + self.every;
        let ping = if self.watched { "WATCHDOG=1\n" } else { "" };
        self.tell(&format!("STATUS={}\n{ping}", status()));
    }

    /// The daemon ends.
    pub(crate) fn stopping(&self) {
        self.tell("STOPPING=1\nSTATUS=ending\n");
    }

    /// Never waits: a manager that does not read is told less.
    fn tell(&self, message: &str) {
        if let Some(socket) = &self.socket
            && let Err(error) = socket.send(message.as_bytes())
        {
            tracing::debug!(%error, "the service manager could not be told");
        }
    }
}

fn connected() -> io::Result<Option<UnixDatagram>> {
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

/// How long the manager bears with silence; none when it does not watch this process.
fn watchdog() -> Option<Duration> {
    let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let ours = number("WATCHDOG_PID").is_none_or(|pid| pid == u64::from(std::process::id()));
    number("WATCHDOG_USEC").filter(|patience| ours && *patience > 0).map(Duration::from_micros)
}
