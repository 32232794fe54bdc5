//! The fuzz targets: each gives bytes from outside to the code that reads them. Any bytes must be read or refused; the reader
//! must never panic, hang, or take more memory than its limit. The targets in `fuzz/` and the test `fuzz` call these functions.

use std::cell::{OnceCell, RefCell};
use std::fs;
use std::path::{Path, PathBuf};

use pschema_inspect::codec::{self, Reply};
use pschema_inspect::{
    AchieveOrder, Ask, CancelOrder, ClaimQuery, DetailQuery, ExplanationQuery, GraphQuery, LiveQuery, Order,
    PlanQuery, PredictionQuery, PursuitQuery, Question, ReportQuery, Request, SayOrder, SchemaQuery,
    SchemaSort, StageOrder, StatusQuery, TraceQuery, WhyNotQuery,
};
use pschema_protocol::body::{Body, BodyLoop, Senses};
use pschema_protocol::description::Description;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::wire::decode;
use pschema_protocol::wire::encode;
use pschema_protocol::wire::message::{Admission, RawFrame, RawHello};
use pschema_protocol::wire::{Record, Text, VERSION, Welcome, WireProperty, WireReply};
use pschema_server::in_process::InProcess;
use pschema_server::inspect;
use pschema_server::{Setup, config};
use pschema_sim::config::WorldFile;
use pschema_store::past::{Past, export};
use tempfile::TempDir;

use crate::Row;

/// A function that reads bytes from outside.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// The target's name, which is also that of its folder in `fuzz/corpus`.
    pub name: &'static str,
    /// Reads `bytes` and returns, whatever they are.
    pub read: fn(&[u8]),
    /// Sound input, from which fuzzing begins.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// The most memory that reading may take, in bytes.
    pub memory_max: usize,
}

const MIB: usize = 1024 * 1024;
/// Memory for the longest answer of 16 MiB, as bytes and as values, and for a young learner.
const SMALL: usize = 64 * MIB;
/// Memory for the longest value on disk, likewise.
const LARGE: usize = 192 * MIB;

/// All targets.
pub const TARGETS: [Target; 11] = [
    Target { name: "hello", read: hello, seeds: edits, memory_max: SMALL },
    Target { name: "frames", read: frames, seeds: edits, memory_max: SMALL },
    Target { name: "reply", read: reply, seeds: edits, memory_max: SMALL },
    Target { name: "request", read: request, seeds: requests, memory_max: SMALL },
    Target { name: "answer", read: answer, seeds: answers, memory_max: SMALL },
    Target { name: "domain", read: domain, seeds: domains, memory_max: SMALL },
    Target { name: "world", read: world, seeds: worlds, memory_max: SMALL },
    Target { name: "curriculum", read: curriculum, seeds: curricula, memory_max: SMALL },
    Target { name: "learner", read: learner, seeds: learners, memory_max: SMALL },
    Target { name: "store", read: store, seeds: edits, memory_max: LARGE },
    Target { name: "export", read: export, seeds: exports, memory_max: LARGE },
];

/// The target of that name.
///
/// # Panics
/// When there is none.
#[must_use]
pub fn target(name: &str) -> Target {
    *TARGETS.iter().find(|target| target.name == name).unwrap_or_else(|| panic!("no fuzz target {name}"))
}

/// Numbers out of bytes; zeros once they are at their end.
struct Draw<'a>(&'a [u8]);

impl Draw<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes([self.byte(), self.byte()])
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes([self.byte(), self.byte(), self.byte(), self.byte()])
    }

    fn u64(&mut self) -> u64 {
        u64::from(self.u32()) | u64::from(self.u32()) << 32
    }

    /// A number that is often of interest as a count or an index, or any number.
    fn count(&mut self) -> u32 {
        match self.byte() {
            value @ 0..=63 => value.into(),
            64..=95 => u32::MAX,
            96..=127 => 4096 + u32::from(self.byte() & 1),
            128..=159 => 512 + u32::from(self.byte() & 1),
            _ => self.u32(),
        }
    }

    fn one_of<'a, T>(&mut self, all: &'a mut [T]) -> Option<&'a mut T> {
        let at = usize::from(self.u16()).checked_rem(all.len())?;
        all.get_mut(at)
    }

    fn text<const N: usize>(&mut self, to: &mut Text<N>) {
        match self.byte() % 3 {
            0 => to.length = self.count(),
            1 => to.length = u32::from(self.byte() % 40),
            _ => {
                if let Some(byte) = to.bytes.get_mut(usize::from(self.byte()) % N) {
                    *byte = self.byte();
                }
            }
        }
    }

    fn property(&mut self, to: &mut WireProperty) {
        match self.byte() % 9 {
            0 => self.text(&mut to.name),
            1 => self.text(&mut to.unit),
            2 => to.kind = self.count(),
            3 => to.first_symbol = self.count(),
            4 => to.symbol_count = self.count(),
            5 => to.min = self.u64(),
            6 => to.max = self.u64(),
            7 => to.resolution = self.u64(),
            _ => to.reserved = self.u32(),
        }
    }

    fn record(&mut self, to: &mut Record) {
        match self.byte() % 4 {
            0 => to.index = self.u16() % 8,
            1 => to.count = self.u16() % 10,
            2 => to.kinds = self.u32(),
            _ => {
                if let Some(value) = to.values.get_mut(usize::from(self.byte() % 8)) {
                    *value = if self.0.len().is_multiple_of(2) { self.u64() } else { self.byte().into() };
                }
            }
        }
    }

    /// Changes one field of a hello.
    fn hello(&mut self, to: &mut RawHello) {
        let head = &mut *to.head;
        match self.byte() % 16 {
            0 => head.magic = self.u32(),
            1 => head.version = self.u32(),
            2 => head.observation_type_count = self.count(),
            3 => head.action_count = self.count(),
            4 => head.scene_command_count = self.count(),
            5 => head.symbol_count = self.count(),
            6 => head.primitive_count = self.count(),
            7 => self.text(&mut head.name),
            8 => self.text(&mut head.kind),
            9 => {
                if let Some(one) = self.one_of(&mut head.observation_types[..6]) {
                    match self.byte() % 4 {
                        0 => self.text(&mut one.name),
                        1 => one.flags = self.count(),
                        2 => one.property_count = self.count(),
                        _ => {
                            if let Some(property) = self.one_of(&mut one.properties) {
                                self.property(property);
                            }
                        }
                    }
                }
            }
            10 | 11 => {
                let of =
                    if self.byte().is_multiple_of(2) { &mut head.actions } else { &mut head.scene_commands };
                if let Some(one) = self.one_of(&mut of[..3]) {
                    match self.byte() % 3 {
                        0 => self.text(&mut one.name),
                        1 => one.parameter_count = self.count(),
                        _ => {
                            if let Some(parameter) = self.one_of(&mut one.parameters[..3]) {
                                self.property(parameter);
                            }
                        }
                    }
                }
            }
            12 | 13 => {
                if let Some(symbol) = self.one_of(&mut head.symbols[..8]) {
                    self.text(symbol);
                }
            }
            _ => {
                if let Some(primitive) = self.one_of(&mut to.primitives) {
                    self.record(primitive);
                }
            }
        }
    }

    fn frame(&mut self, to: &mut RawFrame) {
        let header = &mut to.header;
        match self.byte() % 13 {
            0 => header.magic = self.u32(),
            1 => header.version = self.u32(),
            2 => header.session = self.u64(),
            3 => header.sequence = self.u64(),
            4 => header.answers = self.u64(),
            5 => header.outcome = self.count(),
            6 => header.purpose = self.count(),
            7 => header.observation_count = self.count(),
            8 => to.records.truncate(usize::from(self.byte())),
            9 => {
                if let Some(first) = to.records.first().copied() {
                    let many = usize::from(self.u16() % 5000);
                    to.records.extend(std::iter::repeat_n(first, many));
                    header.observation_count = u32::try_from(to.records.len()).unwrap_or(u32::MAX);
                }
            }
            10 => {
                // The reason is read with the outcomes 2 and 3 only.
                header.outcome = 2 + u32::from(self.byte() & 1);
                self.text(&mut to.reason);
            }
            _ => {
                if let Some(record) = self.one_of(&mut to.records) {
                    self.record(record);
                }
            }
        }
    }
}

fn setup() -> Setup {
    let (curriculum, learner) = config::lesson("free", Default::default(), &[])
        .unwrap_or_else(|error| panic!("the built-in curriculum: {error}"));
    Setup { seed: 1, learner, curriculum }
}

/// A body with any description: a description that passes the checks can be sent and served.
struct Declared(Description);

impl Body for Declared {
    fn describe(&self) -> Description {
        self.0.clone()
    }

    fn sense(&mut self, _: &mut Senses) {}

    fn act(&mut self, _: &pschema_protocol::description::Action) -> pschema_protocol::body::Outcome {
        pschema_protocol::body::Outcome::Done
    }
}

/// Hellos: a learner can live with the body of every hello that passes the checks.
fn hello(bytes: &[u8]) {
    let mut draw = Draw(bytes);
    let mut raw = BodyLoop::new(Row::new("row")).hello().unwrap_or_else(|error| panic!("{error}"));
    for _ in 0..draw.byte() % 8 {
        draw.hello(&mut raw);
    }
    let Ok(checked) = decode::hello(&raw) else { return };
    let again = encode::hello(&checked.description, checked.pid, raw.head.wake);
    let again = again.unwrap_or_else(|error| panic!("what was checked can't be sent: {error}"));
    let back = decode::hello(&again).unwrap_or_else(|error| panic!("what was sent is refused: {error}"));
    assert_eq!(back.description, checked.description);
    // Attached as it would be; a learner may still be unwilling.
    if let Ok(mut run) = InProcess::new(Declared(checked.description), setup()) {
        for _ in 0..3 {
            let Ok(_) = run.advance() else { return };
        }
    }
}

/// Frames, one after the other, of a body that is attached.
fn frames(bytes: &[u8]) {
    let mut draw = Draw(bytes);
    let mut body = BodyLoop::new(Row::new("row"));
    let mut session = decode::SessionChecks::new(7, body.description().clone());
    body.attached(7);
    for _ in 0..draw.byte() % 6 {
        let mut raw = body.next_frame().clone();
        let changes = draw.byte() % 5;
        for _ in 0..changes {
            draw.frame(&mut raw);
        }
        let taken = session.check(&raw);
        assert!(changes > 0 || taken.is_ok(), "a sound frame was refused: {taken:?}");
        if let Ok(frame) = taken {
            let types = &body.description().observation_types;
            assert!(frame.observations.iter().all(|one| usize::from(one.sense().index()) < types.len()));
        }
        // The next is sound again: as one that attaches anew.
        session = decode::SessionChecks::new(7, body.description().clone());
        body.attached(7);
    }
}

/// Replies and welcomes, as a body reads them.
fn reply(bytes: &[u8]) {
    let mut draw = Draw(bytes);
    let description = BodyLoop::new(Row::new("row")).description().clone();
    let action = description.repertoire.first().cloned();
    let Some(action) = action else { return };
    let mut raw: WireReply = encode::reply(7, 3, &pschema_protocol::wire::message::Reply::Act(action));
    let mut welcome: Welcome = encode::welcome(7, "learner");
    for _ in 0..draw.byte() % 6 {
        match draw.byte() % 11 {
            0 => raw.magic = draw.u32(),
            1 => raw.version = draw.u32(),
            2 => raw.kind = draw.count(),
            3 => raw.code = draw.count(),
            4 => raw.wait_ms = draw.u32(),
            5 => draw.text(&mut raw.reason),
            6 => welcome.code = draw.count(),
            7 => welcome.session = draw.u64(),
            8 => draw.text(&mut welcome.learner),
            9 => draw.text(&mut welcome.reason),
            _ => draw.record(&mut raw.order),
        }
    }
    let _refused = decode::reply(&raw, &description, 7, 3).is_err();
    if let Ok(Admission::Accepted { session, .. }) = decode::welcome(&welcome) {
        assert_ne!(session, 0);
    }
}

/// Whether a daemon can read `bytes` as a question or an order.
#[must_use]
pub fn is_request(bytes: &[u8]) -> bool {
    codec::decode::<Request>(bytes).is_ok()
}

/// Questions and orders, as the daemon reads and answers them.
fn request(bytes: &[u8]) {
    let Ok(request) = codec::decode::<Request>(bytes) else { return };
    let learnt = || {
        let mut run = InProcess::new(Row::new("row"), setup()).unwrap_or_else(|error| panic!("{error}"));
        for _ in 0..60 {
            run.advance().unwrap_or_else(|error| panic!("{error}"));
        }
        run
    };
    thread_local! {
        static RUN: OnceCell<InProcess<Row>> = const { OnceCell::new() };
    }
    let answered = |run: &InProcess<Row>, question: &Question| {
        let reply = inspect::reply(&run.view(), question);
        assert!(is_answer(&reply), "{question:?}: a reply that no tool can read");
    };
    match request {
        Request::Order(Order::Say(say)) => {
            let mut run = learnt();
            if run.say(&say.words).is_ok() {
                run.advance().unwrap_or_else(|error| panic!("{error}"));
            }
        }
        Request::Order(Order::Achieve(achieve)) => {
            let mut run = learnt();
            if run.achieve(&achieve).is_ok() {
                run.advance().unwrap_or_else(|error| panic!("{error}"));
            }
            answered(&run, &Question::Pursuit(PursuitQuery {}));
        }
        Request::Order(order) => {
            if let Some(question) = order.told_by() {
                RUN.with(|run| answered(run.get_or_init(learnt), &question));
            }
        }
        Request::Question(question) => RUN.with(|run| answered(run.get_or_init(learnt), &question)),
    }
}

/// Replies, as a tool reads them: the question decides the type of the answer.
fn answer(bytes: &[u8]) {
    is_answer(bytes);
}

/// Whether a tool that asked one question or another can read `bytes` as the reply.
pub fn is_answer(bytes: &[u8]) -> bool {
    [
        reads::<StatusQuery>(bytes),
        reads::<SchemaQuery>(bytes),
        reads::<DetailQuery>(bytes),
        reads::<ClaimQuery>(bytes),
        reads::<ExplanationQuery>(bytes),
        reads::<WhyNotQuery>(bytes),
        reads::<ReportQuery>(bytes),
        reads::<TraceQuery>(bytes),
        reads::<PredictionQuery>(bytes),
        reads::<PlanQuery>(bytes),
        reads::<PursuitQuery>(bytes),
        reads::<LiveQuery>(bytes),
        reads::<GraphQuery>(bytes),
    ]
    .contains(&true)
}

fn reads<Q: Ask>(bytes: &[u8]) -> bool {
    let Ok(reply) = codec::decode::<Reply<Q::Answer>>(bytes) else { return false };
    let again = codec::encode(&reply).and_then(|bytes| codec::decode::<Reply<Q::Answer>>(&bytes).map(drop));
    // Not compared: a NaN is not itself.
    assert!(again.is_ok(), "{again:?}");
    true
}

/// The file by which bodies find their daemon.
fn domain(bytes: &[u8]) {
    in_a_file("one/domain", bytes, |path| {
        let runtime = path.parent().and_then(Path::parent).map(RuntimeDir::at);
        let (Some(Ok(runtime)), Ok(name)) = (runtime, LearnerName::new("one")) else { return };
        // Nobody serves it: a record that passed for one served would be trusted.
        assert!(Place::new(runtime, name).served().is_err());
    });
}

/// World files.
fn world(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _refused = WorldFile::parse("fuzzed.toml", text).is_err();
    }
}

/// Curriculum files.
fn curriculum(bytes: &[u8]) {
    in_a_file("curriculum.toml", bytes, |path| {
        let read = config::lesson(&path.to_string_lossy(), Default::default(), &[]);
        if let Ok((curriculum, learner)) = read {
            // A learner can begin with every file that is read, or says why not.
            let setup = Setup { seed: 1, learner, curriculum };
            if let Ok(mut run) = InProcess::new(Row::new("row"), setup) {
                for _ in 0..3 {
                    let Ok(_) = run.advance() else { return };
                }
            }
        }
    });
}

/// Files of a learner's parameters.
fn learner(bytes: &[u8]) {
    in_a_file("learner.toml", bytes, |path| {
        if let Ok(learner) = config::learner(Some(path)) {
            learner
                .parameters
                .check()
                .unwrap_or_else(|error| panic!("parameters that were read and are none: {error}"));
        }
    });
}

/// A data directory, one file of which was changed here and there; mostly with the checksums set right again, for
/// someone who forges can do so as well.
fn store(bytes: &[u8]) {
    const MAX_FILE: usize = 4 * MIB;
    let golden = golden();
    let mut draw = Draw(bytes);
    let Some((changed, _)) = golden.get(usize::from(draw.byte()).checked_rem(golden.len()).unwrap_or(0))
    else {
        return;
    };
    let directory = tempfile::Builder::new().prefix("psf").tempdir_in("/dev/shm");
    let directory = directory.unwrap_or_else(|error| panic!("a directory to be read: {error}"));
    for (name, content) in &golden {
        let mut content = content.clone();
        if name == changed {
            for _ in 0..=draw.byte() % 4 {
                edit(&mut draw, &mut content);
            }
            content.truncate(MAX_FILE);
            if !draw.byte().is_multiple_of(8) {
                set_checksums_right(&mut content);
            }
        }
        let path = directory.path().join(name);
        let made = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&path, &content));
        made.unwrap_or_else(|error| panic!("a file to be read: {error}"));
    }
    let Ok(past) = Past::open(directory.path()) else { return };
    let _sound = past.moment(None).is_ok();
    // Learning all of it again takes long; now and then is enough.
    let relearn = draw.byte() % 8 == 7;
    let _sound = past.verify(relearn, &mut |_| ()).is_ok();
    if let Ok(repair) = past.plan_repair() {
        let _repaired = past.repair_to(&repair, &directory.path().join("repaired")).is_ok();
    }
}

/// The files of a data directory that is kept for ever, by name.
fn golden() -> Vec<(PathBuf, Vec<u8>)> {
    thread_local! {
        static FILES: OnceCell<Vec<(PathBuf, Vec<u8>)>> = const { OnceCell::new() };
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../server/store/tests/golden/v1");
    let read = || {
        let mut files = Vec::new();
        for folder in ["", "journal", "snapshot"] {
            let entries = fs::read_dir(root.join(folder)).into_iter().flatten().flatten();
            let names = entries.filter(|entry| entry.path().is_file() && entry.file_name() != "digest");
            files.extend(names.filter_map(|entry| {
                Some((Path::new(folder).join(entry.file_name()), fs::read(entry.path()).ok()?))
            }));
        }
        files.sort();
        assert!(files.len() > 3, "no data directory in {}", root.display());
        files
    };
    FILES.with(|files| files.get_or_init(read).clone())
}

/// Changes bytes somewhere: of a frame's head, or anywhere.
fn edit(draw: &mut Draw<'_>, content: &mut Vec<u8>) {
    let at = usize::try_from(draw.u32()).unwrap_or(0).checked_rem(content.len()).unwrap_or(0);
    match draw.byte() % 6 {
        0 => content.truncate(at),
        1 => drop(content.splice(at..at, [draw.byte(), draw.byte(), draw.byte()])),
        2 => drop(content.drain(at..(at + usize::from(draw.byte())).min(content.len()))),
        3 => {
            // A number as large as it gets, in the codec's own way.
            let forged = [&[0xfd_u8][..], &draw.u64().to_le_bytes()].concat();
            let end = (at + forged.len()).min(content.len());
            drop(content.splice(at..end, forged));
        }
        _ => {
            if let Some(byte) = content.get_mut(at) {
                *byte = draw.byte();
            }
        }
    }
}

/// Walks along the frames of a file (`docs/FORMAT.md`) and makes them a chain again.
fn set_checksums_right(content: &mut [u8]) {
    let (mut at, mut previous) = (0, None::<u32>);
    while let Some(head) = content.get(at..at + 32) {
        if !head.starts_with(b"PS") {
            return;
        }
        let length = head.get(4..8).and_then(|four| four.try_into().ok()).map_or(0, u32::from_le_bytes);
        let Some(end) =
            usize::try_from(length).ok().and_then(|length| at.checked_add(32)?.checked_add(length))
        else {
            return;
        };
        let Some(frame) = content.get_mut(at..end) else { return };
        let (head, payload) = frame.split_at_mut(32);
        if let (Some(previous), Some(to)) = (previous, head.get_mut(24..28)) {
            to.copy_from_slice(&previous.to_le_bytes());
        }
        let mut crc = crc32fast::Hasher::new();
        crc.update(head.get(..28).unwrap_or_default());
        crc.update(payload);
        let crc = crc.finalize();
        if let Some(to) = head.get_mut(28..) {
            to.copy_from_slice(&crc.to_le_bytes());
        }
        (at, previous) = (end, Some(crc));
    }
}

/// A memory as JSON Lines.
fn export(bytes: &[u8]) {
    let _read = export::read(&mut &bytes[..], |_| ()).is_ok();
}

fn exports() -> Vec<Vec<u8>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../server/store/tests/golden/export-1.jsonl");
    vec![fs::read(&path).unwrap_or_else(|error| panic!("{path:?}: {error}"))]
}

/// Does something with a file that holds `bytes`.
fn in_a_file(name: &str, bytes: &[u8], what: impl FnOnce(&Path)) {
    thread_local! {
        static DIRECTORY: RefCell<Option<TempDir>> = const { RefCell::new(None) };
    }
    let path = DIRECTORY.with(|directory| -> std::io::Result<PathBuf> {
        let mut directory = directory.borrow_mut();
        if directory.is_none() {
            // Short, for it stands in for a runtime directory.
            let made = tempfile::Builder::new().prefix("psf").tempdir_in("/tmp")?;
            fs::create_dir(made.path().join("one"))?;
            *directory = Some(made);
        }
        let path = directory.as_ref().map(|made| made.path().join(name)).unwrap_or_default();
        fs::write(&path, bytes)?;
        Ok(path)
    });
    what(&path.unwrap_or_else(|error| panic!("a file to be read: {error}")));
}

fn edits() -> Vec<Vec<u8>> {
    (0..32_u8)
        .map(|at| (0..48).map(|byte: u8| at.wrapping_mul(37).wrapping_add(byte.wrapping_mul(at))).collect())
        .collect()
}

fn requests() -> Vec<Vec<u8>> {
    let text = str::to_owned;
    let query = SchemaQuery {
        action: Some(text("move")),
        pre: Some(text("finger{field=$x}")),
        post: Some(text("touch")),
        generalised: true,
        sort: SchemaSort::Excitation,
        limit: 7,
        offset: 2,
    };
    let goal = || vec![text("object{colour=blue, field=$x}"), text("touch")];
    let requests: [Request; 21] = [
        StatusQuery {}.into(),
        SchemaQuery::default().into(),
        query.into(),
        DetailQuery { id: 3 }.into(),
        ClaimQuery { action: Some(text("move")), limit: 4, offset: 1 }.into(),
        ExplanationQuery { step: Some(5), candidates_max: 9 }.into(),
        SayOrder { words: vec![text("touch"), text("it")] }.into(),
        StageOrder::Set(text("free")).into(),
        ReportQuery {}.into(),
        TraceQuery { from: 3 }.into(),
        PredictionQuery { action: text("move(field=3)") }.into(),
        PlanQuery { goal: goal(), ..PlanQuery::default() }.into(),
        PlanQuery { most: Some("touch".to_owned()), ..PlanQuery::default() }.into(),
        AchieveOrder { goal: goal(), actions_max: 20, ..AchieveOrder::default() }.into(),
        AchieveOrder { goal: goal(), again: true, actions_max: 20, most: None }.into(),
        PursuitQuery {}.into(),
        CancelOrder { number: 1 }.into(),
        GraphQuery { around: Some(3), depth: 2, goal: Vec::new(), limit: 9 }.into(),
        WhyNotQuery { schema: 3, step: None }.into(),
        ExplanationQuery { step: None, candidates_max: 9 }.into(),
        LiveQuery { trace_from: 0, candidates_max: 3, terms_max: 4, newest_max: 5 }.into(),
    ];
    requests.iter().filter_map(|request| codec::encode(request).ok()).collect()
}

fn answers() -> Vec<Vec<u8>> {
    let mut run = InProcess::new(Row::new("row"), setup()).unwrap_or_else(|error| panic!("{error}"));
    for _ in 0..20 {
        run.advance().unwrap_or_else(|error| panic!("{error}"));
    }
    let questions = requests().into_iter().filter_map(|bytes| match codec::decode(&bytes).ok()? {
        Request::Question(question) => Some(question),
        Request::Order(order) => order.told_by(),
    });
    questions.map(|question| inspect::reply(&run.view(), &question)).collect()
}

fn domains() -> Vec<Vec<u8>> {
    let rest = "epoch = 3\npid = 4711\nprefix = ps0123456789-\nstate = ready\n";
    vec![format!("protocol = {VERSION}\n{rest}").into_bytes()]
}

/// The files of a folder of the project, which lies beside the tests.
fn files(folder: &str) -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let entries = fs::read_dir(&root).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    paths.sort();
    assert!(!paths.is_empty(), "no files in {}", root.display());
    paths.iter().filter_map(|path| fs::read(path).ok()).collect()
}

fn worlds() -> Vec<Vec<u8>> {
    files("body-sim/worlds")
}

fn curricula() -> Vec<Vec<u8>> {
    files("server/curricula")
}

fn learners() -> Vec<Vec<u8>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../server/learner.toml");
    vec![fs::read(path).unwrap_or_else(|error| panic!("server/learner.toml: {error}"))]
}

/// The committed corpus of a target, in order of name.
///
/// # Panics
/// When a file of it can't be read.
#[must_use]
pub fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(name);
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.path()).collect();
    paths.sort();
    let read = |path: PathBuf| {
        let bytes = fs::read(&path).unwrap_or_else(|error| panic!("{path:?}: {error}"));
        (path, bytes)
    };
    paths.into_iter().map(read).collect()
}
