//! The other process: a daemon's end of the protocol with no learner behind it, beside the bare server and the socket's.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::Duration;

use pschema_process::Stop;
use pschema_protocol::description::{Action, ActionId};
use pschema_protocol::domain::{LearnerName, OwnedDomain, Place, RuntimeDir};
use pschema_protocol::transport::server::{Incoming, ServerTransport};
use pschema_protocol::wire::decode::{self, SessionChecks};
use pschema_protocol::wire::message::Reply;
use pschema_tools::kit::{Failure, follow_parent};

use super::bare::BareServer;
use super::{Mode, NAME, PeerArgs, socket};

/// How long the loop sleeps when nothing comes in.
const SLEEP: Duration = Duration::from_millis(50);

/// Serves until told to stop.
pub(crate) fn serve(args: &PeerArgs) -> Result<(), Failure> {
    follow_parent(args.parent.parent)?;
    let told = Stop::on_signals()?;
    let mode = args.mode;
    let runtime = RuntimeDir::from_environment()?;
    let socket = runtime.path().join(socket::FILE);
    let place = Place::new(runtime, LearnerName::new(NAME)?);
    let stop = AtomicBool::new(false);
    thread::scope(|scope| {
        let (ready, is_ready) = channel();
        let daemon = scope.spawn(|| daemon(place.clone(), mode, &stop, ready));
        // It never says so when it failed, and then its failure is told below.
        let bare = is_ready.recv().is_ok().then(|| scope.spawn(|| bare(&place, mode, &stop)));
        let served = socket::serve(&socket, &stop, || {
            let failed =
                daemon.is_finished() || bare.as_ref().is_some_and(thread::ScopedJoinHandle::is_finished);
            failed || told.check().is_err()
        });
        stop.store(true, Ordering::Relaxed);
        let ended = |result: thread::Result<Result<(), Failure>>| {
            result.unwrap_or_else(|_| Err(Failure::Failed("a thread of the other side panicked".to_owned())))
        };
        ended(daemon.join())?;
        bare.map_or(Ok(()), |bare| ended(bare.join()))?;
        served
    })
}

fn bare(place: &Place, mode: Mode, stop: &AtomicBool) -> Result<(), Failure> {
    BareServer::create(place, mode.bare())?.serve(stop)
}

/// A daemon whose learner always has the same to say: all of the protocol, and nothing else.
fn daemon(place: Place, mode: Mode, stop: &AtomicBool, ready: Sender<()>) -> Result<(), Failure> {
    let mut transport = ServerTransport::create(OwnedDomain::create(place)?).map_err(Failure::of)?;
    transport.set_spin(mode.spin());
    ready.send(()).ok();
    let mut sessions: BTreeMap<u64, SessionChecks> = BTreeMap::new();
    let mut number = 0;
    while !stop.load(Ordering::Relaxed) {
        transport.wait(SLEEP);
        transport.poll(&mut |incoming| match incoming {
            Incoming::Hello { hello, reply } => {
                number += 1;
                let sent = match decode::hello(&hello) {
                    Ok(hello) => {
                        sessions.insert(number, SessionChecks::new(number, hello.description));
                        reply.accept(number, NAME)
                    }
                    Err(refusal) => reply.refuse(&refusal, NAME),
                };
                drop(sent);
            }
            Incoming::Frame { frame, reply } => {
                let Some(session) = sessions.get_mut(&reply.session()) else { return };
                let answer = match session.check(frame) {
                    Ok(frame) => order(frame.sequence),
                    Err(refusal) => Reply::Refused { code: refusal.code(), reason: refusal.to_string() },
                };
                session.replied(&answer);
                drop(reply.send(&answer));
            }
            Incoming::BodyGone { session, .. } => {
                sessions.remove(&session);
            }
            Incoming::Request { .. } | Incoming::Refused { .. } => {}
        });
    }
    Ok(())
}

/// The action that is asked for.
fn order(sequence: u64) -> Reply {
    let to = i64::try_from(sequence % 460).unwrap_or(0);
    Reply::Act(Action::new(ActionId::from_index(0), [to]))
}
