//! The daemon's pulse: a small question is asked again and again for as long as the body lives, and each answer renews
//! the sign of life that the [watch](crate::watch) looks at. A daemon that has gone, or is stopped or stuck, does not
//! answer.

use std::sync::atomic::Ordering;
use std::time::Duration;

use pschema_inspect::{AskError, PursuitQuery, ask};
use pschema_process::Worker;
use pschema_protocol::client::Client;
use pschema_protocol::domain::Place;

use crate::watch::Beat;

/// How often the daemon is asked within the longest silence.
const SHARE: u32 = 5;

/// Feels the pulse of the daemon at a place on a thread of its own, until the returned worker is dropped, and renews `beat`
/// with it.
///
/// # Errors
/// When no thread can be started.
pub(crate) fn begin(place: Place, beat: Beat, silence_max: Duration) -> std::io::Result<Worker> {
    let every = silence_max / SHARE;
    Worker::start("pulse", move |stop| {
        let mut client = None;
        while !stop.load(Ordering::SeqCst) {
            feel(&place, &mut client, &beat, silence_max);
            std::thread::park_timeout(every);
        }
    })
}

fn feel(place: &Place, client: &mut Option<Client>, beat: &Beat, patience: Duration) {
    if client.as_ref().is_some_and(|client| !client.is_current()) {
        *client = None;
    }
    if client.is_none() {
        *client = Client::connect(place, patience).ok();
    }
    let Some(connected) = client else { return };
    // Any answer is a sign of life, also that there is nothing to answer.
    match ask(PursuitQuery {}, |request| connected.request(request)) {
        Ok(_) | Err(AskError::Problem(_)) => beat.renew(),
        Err(error) => {
            tracing::debug!(%error, "no pulse");
            *client = None;
        }
    }
}
