//! What tools and daemon say to each other has a version, and every change of it raises that: a tool of another release
//! would read other numbers into the same bytes.

#![allow(clippy::unwrap_used)] // A test panics to fail.

use std::path::PathBuf;

use pschema_inspect::{Answer, GraphScope, GraphTie, Request, SchemaSort, StageOrder, ValueText, Verdict};
use pschema_protocol::wire::TOOLS_VERSION;
use serde_reflection::{Registry, Tracer, TracerConfig};

/// Every type that crosses, with its fields and variants in their order.
fn schema() -> Registry {
    let mut tracer = Tracer::new(TracerConfig::default());
    tracer.trace_simple_type::<Request>().unwrap();
    tracer.trace_simple_type::<StageOrder>().unwrap();
    tracer.trace_simple_type::<SchemaSort>().unwrap();
    tracer.trace_simple_type::<ValueText>().unwrap();
    tracer.trace_simple_type::<GraphScope>().unwrap();
    tracer.trace_simple_type::<GraphTie>().unwrap();
    tracer.trace_simple_type::<Verdict>().unwrap();
    tracer.trace_simple_type::<Answer>().unwrap();
    tracer.registry().unwrap()
}

#[test]
fn a_change_of_what_tools_and_daemon_say_raises_its_version() {
    let name = format!("tests/golden/tools-{TOOLS_VERSION}.txt");
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(&name);
    let now = format!("{:#?}\n", schema());
    if !path.exists() && std::env::var_os("PSCHEMA_BLESS").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &now).unwrap();
    }
    let kept = std::fs::read_to_string(&path);
    let kept = kept.unwrap_or_else(|error| {
        panic!("protocol/{name}: {error}. Of a version that is new, run this once with PSCHEMA_BLESS=1, and keep the file")
    });
    if let Some((line, (was, is))) =
        kept.lines().zip(now.lines()).enumerate().find(|(_, (was, is))| was != is)
    {
        let line = line + 1;
        panic!(
            "what tools and daemon say has changed (protocol/{name}:{line}: {was:?} became {is:?}): raise \
             TOOLS_VERSION in protocol/src/wire/layout.rs, and run this once with PSCHEMA_BLESS=1"
        );
    }
    assert_eq!(kept.len(), now.len(), "protocol/{name}: something was added at its end: raise TOOLS_VERSION");
}
