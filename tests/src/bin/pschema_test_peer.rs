//! A body or a tool for tests to stop and to kill: `pschema-test-peer (body|broken|tool) LEARNER NAME [POINT]`. The broken body sends
//! frames, and does nothing that a reply tells it.
//!
//! With a point it goes as far as there, says so on stdout, and does nothing any more. Points are what the protocol
//! leftovers: `hello loaned`, `frame sent` and so on. A body says on stdout how many orders it has carried out.

use std::fmt;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pschema_inspect::{StatusQuery, ask};
use pschema_protocol::body::{BodyLoop, RunOptions, run};
use pschema_protocol::client::Client;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::transport::body_link::BodyLink;
use pschema_tests::Row;
use tracing::field::{Field, Visit};
use tracing::{Event, Subscriber};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [role, learner, name, point @ ..] = arguments.as_slice() else {
        eprintln!("usage: pschema-test-peer (body|broken|tool) LEARNER NAME [POINT]");
        return ExitCode::from(2);
    };
    let pause = point.first().map(|point| Pause { point: point.clone() });
    let log = tracing_subscriber::fmt::layer()
        .with_writer(std::io::stderr)
        .with_filter(tracing_subscriber::filter::LevelFilter::INFO);
    tracing_subscriber::registry().with(pause).with(log).init();
    match go(role, learner, name) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn go(role: &str, learner: &str, name: &str) -> Result<(), Box<dyn std::error::Error>> {
    let place = Place::new(RuntimeDir::from_environment()?, LearnerName::new(learner)?);
    match role {
        "body" => body(place, name),
        "broken" => broken(&place, name),
        "tool" => tool(&place),
        _ => Err(format!("{role} is neither body, broken nor tool").into()),
    }
}

fn body(place: Place, name: &str) -> Result<(), Box<dyn std::error::Error>> {
    let row = Row::new(name);
    let acts = row.acts.clone();
    std::thread::spawn(move || {
        let mut said = 0;
        loop {
            let now = acts.load(Ordering::SeqCst);
            if now != said {
                println!("{now} orders");
                said = now;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    run(row, &RunOptions::new(place))?;
    Ok(())
}

fn broken(place: &Place, name: &str) -> Result<(), Box<dyn std::error::Error>> {
    let stop = AtomicBool::new(false);
    let mut body = BodyLoop::new(Row::new(name));
    let mut link = BodyLink::attach(place, body.description(), &stop)?;
    body.attached(link.session());
    loop {
        link.exchange(body.next_frame(), &stop)?;
    }
}

fn tool(place: &Place) -> Result<(), Box<dyn std::error::Error>> {
    let mut client = Client::connect(place, Duration::from_secs(20))?;
    loop {
        ask(StatusQuery {}, |request| client.request(request))?;
    }
}

/// Halts the thread that comes to a point.
struct Pause {
    point: String,
}

impl<S: Subscriber> Layer<S> for Pause {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let mut message = Message(String::new());
        event.record(&mut message);
        if message.0 == self.point {
            println!("at {}", self.point);
            loop {
                std::thread::park();
            }
        }
    }
}

struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            self.0 = format!("{value:?}");
        }
    }
}
