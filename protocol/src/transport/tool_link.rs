//! The end of a tool: it sends one request at a time, and receives the answer page by page.

use std::time::{Duration, Instant};

use iceoryx2::service::port_factory::PortFactory as _;

use super::debug::opaque_debug;
use super::error::setup;
use super::gone::has_gone;
use super::services::{self, Role, ToolClient, client};
use super::waker::PeerBase;
use super::{Spin, TransportError};
use crate::domain::Place;
use crate::limits::{PAGE_BYTES, PAGES_MAX, REQUEST_BYTES_MAX, TOOLS_MAX};
use crate::refusal::Refusal;
use crate::wire::{Page, decode, encode};

/// How often a waiting tool looks whether the daemon lives.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// The purpose for which a tool connects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To ask, perhaps for a long time.
    Question,
    /// To give an order, or to ask one thing and leave. Places are kept for it ([`OPERATORS_MAX`](crate::limits::OPERATORS_MAX)).
    Order,
}

/// A tool's connection to a daemon.
pub struct ToolLink {
    client: ToolClient,
    base: PeerBase,
    /// The number of the last request. Numbers begin at random, so that no two tools count alike (`held`).
    requests: u64,
}

opaque_debug!(ToolLink);

impl ToolLink {
    /// Connects to the daemon that serves `place` now.
    ///
    /// # Errors
    /// [`TransportError::Domain`] when none serves it or it is still starting, [`TransportError::Full`] when
    /// it has its number of tools, [`TransportError::Setup`] when iceoryx2 refuses, as it does when the daemon
    /// ends or is replaced meanwhile.
    pub fn connect(place: &Place, purpose: Purpose) -> Result<Self, TransportError> {
        let base = PeerBase::open(place, "tool")?;
        let service = services::tools(&base.node, Role::Peer)?;
        let client = client!(service, base.epoch, services::TOOL_PLACES, "tools");
        // Counted with this one: of two that come at once, none may take a place of the operators.
        if purpose == Purpose::Question && service.dynamic_config().number_of_clients() > TOOLS_MAX {
            return Err(TransportError::Full { sort: "tools", limit: TOOLS_MAX });
        }
        let requests = base.wake;
        Ok(Self { client, base, requests })
    }

    /// Asks and waits for the whole answer.
    ///
    /// # Errors
    /// [`TransportError::Refused`] with the daemon's reason, [`TransportError::TimedOut`] when no page came for
    /// `timeout`, [`TransportError::DaemonGone`], [`TransportError::TooLong`], or what the transport said.
    pub fn request(&mut self, bytes: &[u8], timeout: Duration) -> Result<Vec<u8>, TransportError> {
        self.requests = self.requests.wrapping_add(1);
        if bytes.len() > REQUEST_BYTES_MAX {
            return Err(TransportError::TooLong { length: bytes.len(), limit: REQUEST_BYTES_MAX });
        }
        let mut page = encode::page(self.requests, (0, 1), bytes);
        page.wake = self.base.wake;
        let loan = self.client.loan_uninit().map_err(setup("send a request"))?;
        let pending = loan.write_payload(page).send().map_err(setup("send a request"))?;
        self.base.notify();
        tracing::trace!("request sent");
        let mut answer = Assembly { pages: None, next: 0, bytes: Vec::new() };
        let mut progress = Instant::now();
        let mut spin = Spin::usual();
        spin.happened(progress);
        loop {
            let mut received = false;
            while let Some(page) = pending.receive().map_err(setup("receive an answer"))? {
                received = true;
                tracing::trace!(page = page.page, "page received");
                // One of an answer to another tool, which had this one's place on the service before, is not ours.
                if page.request != self.requests {
                    continue;
                }
                if answer.take(&page).map_err(TransportError::Wrong)? {
                    return answer.finish(&page);
                }
            }
            if received {
                // There is room for more pages.
                self.base.notify();
                progress = Instant::now();
                spin.happened(progress);
            }
            if spin.goes_on(Instant::now()) {
                std::hint::spin_loop();
                continue;
            }
            if has_gone(|| pending.is_connected(), || self.base.epoch.is_current(), || pending.has_response())
            {
                return Err(TransportError::DaemonGone);
            }
            if progress.elapsed() >= timeout {
                return Err(TransportError::TimedOut { waited: timeout });
            }
            let rest = timeout.saturating_sub(progress.elapsed()).min(LOOK_EVERY);
            // An error means that a signal came, and the loop looks again.
            self.base.listener.timed_wait(|_| {}, rest).ok();
        }
    }

    /// Whether the daemon connected to still serves the learner.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.base.epoch.is_current()
    }
}

/// An answer that is put together from its pages.
struct Assembly {
    pages: Option<u32>,
    next: u32,
    bytes: Vec<u8>,
}

impl Assembly {
    /// Takes the next page; returns whether it was the last.
    fn take(&mut self, page: &Page) -> Result<bool, Refusal> {
        decode::tool_preamble(page.magic, page.version)?;
        let wrong = |problem: String| Err(Refusal::Page { page: page.page, pages: page.pages, problem });
        let pages = *self.pages.get_or_insert(page.pages);
        if page.pages != pages || page.page != self.next || page.page >= pages {
            return wrong(format!("expected page {} of {pages}", self.next));
        }
        if usize::try_from(pages).map_or(true, |pages| pages > PAGES_MAX) {
            return wrong(format!("at most {PAGES_MAX} are allowed"));
        }
        let used = usize::try_from(page.length).ok().and_then(|length| page.bytes.get(..length));
        let Some(used) = used else {
            return wrong(format!("it claims {} bytes of {PAGE_BYTES}", page.length));
        };
        if page.page + 1 < pages && used.len() != PAGE_BYTES {
            return wrong(format!("it has {} bytes and is not the last", used.len()));
        }
        self.bytes.extend_from_slice(used);
        self.next += 1;
        Ok(self.next == pages)
    }

    fn finish(self, last: &Page) -> Result<Vec<u8>, TransportError> {
        if last.code != 0 {
            let reason = String::from_utf8_lossy(&self.bytes).into_owned();
            return Err(TransportError::Refused { code: last.code, reason });
        }
        Ok(self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::client::Client;
    use crate::domain::{LearnerName, OwnedDomain, RuntimeDir};
    use crate::transport::server::{Incoming, ServerTransport};

    /// A daemon makes a service, and then its port on it. Who asked in between was told that it had gone.
    #[test]
    fn a_daemon_that_is_only_just_starting_is_waited_for() {
        let directory = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
        let runtime = RuntimeDir::at(&directory.path().join("run")).unwrap();
        let place = Place::new(runtime, LearnerName::new("starting").unwrap());
        let domain = OwnedDomain::create(place.clone()).unwrap();

        let node = services::node::<services::Ipc>(&place, domain.record(), "daemon").unwrap();
        let wake_daemon = services::wake_daemon(&node, Role::Daemon).unwrap();
        let wake_peers = services::wake_peers(&node, Role::Daemon).unwrap();
        let tools = services::tools(&node, Role::Daemon).unwrap();
        let asked =
            Client::connect(&place, Duration::from_millis(30)).and_then(|mut one| one.request(b"early"));
        let error = asked.unwrap_err();
        assert!(error.is_no_daemon() && error.to_string().contains("still starting"), "{error}");
        drop((tools, wake_peers, wake_daemon, node));

        let answer = std::thread::scope(|scope| {
            let asking = scope.spawn(|| {
                let start = Instant::now();
                let mut client = loop {
                    match Client::connect(&place, Duration::from_secs(20)) {
                        Err(error) if error.is_no_daemon() && start.elapsed().as_secs() < 20 => {}
                        client => break client,
                    }
                };
                let answer = client.as_mut().map(|client| client.request(b"asked").unwrap());
                answer.map_err(|error| error.to_string())
            });
            let mut transport = ServerTransport::create(domain).unwrap();
            while !asking.is_finished() {
                transport.wait(Duration::from_millis(10));
                transport.poll(&mut |incoming| {
                    if let Incoming::Request { bytes, reply } = incoming {
                        reply.answer(bytes);
                    }
                });
            }
            asking.join().unwrap()
        });
        assert_eq!(answer.unwrap(), b"asked");
    }

    fn page(number: u32, pages: u32, length: u32) -> Page {
        let bytes = [u8::try_from(number).unwrap(); PAGE_BYTES];
        Page { page: number, pages, length, ..encode::page(7, (0, 1), &bytes) }
    }

    fn assembly() -> Assembly {
        Assembly { pages: None, next: 0, bytes: Vec::new() }
    }

    const FULL: u32 = PAGE_BYTES as u32;

    #[test]
    fn pages_in_order_make_an_answer() {
        let mut answer = assembly();
        assert_eq!(answer.take(&page(0, 2, FULL)), Ok(false));
        assert_eq!(answer.take(&page(1, 2, 3)), Ok(true));
        let whole = [vec![0; PAGE_BYTES], vec![1; 3]].concat();
        assert_eq!(answer.finish(&page(1, 2, 3)).unwrap(), whole);
    }

    #[test]
    fn pages_that_contradict_each_other_are_refused() {
        let too_many = u32::try_from(PAGES_MAX + 1).unwrap();
        let wrong = [
            (page(0, 3, FULL), "expected page 1 of 3"),
            (page(2, 3, FULL), "expected page 1 of 3"),
            (page(1, 4, FULL), "expected page 1 of 3"),
            (page(1, 3, FULL - 1), "is not the last"),
            (page(1, 3, FULL + 1), "claims 32769 bytes"),
            (Page { version: 9, ..page(1, 3, FULL) }, "version 9"),
        ];
        for (page, complaint) in wrong {
            let mut answer = assembly();
            answer.take(&super::tests::page(0, 3, FULL)).unwrap();
            let error = answer.take(&page).unwrap_err().to_string();
            assert!(error.contains(complaint), "{error}");
        }
        let error = assembly().take(&page(0, too_many, FULL)).unwrap_err().to_string();
        assert!(error.contains("at most 512"), "{error}");
        assert!(assembly().take(&page(0, 0, 0)).is_err());
    }
}
