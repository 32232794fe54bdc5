//! Figures of a store on a real disk, with a memory of any size: how long a start takes, what a snapshot costs the steps
//! beside it. The memory is made of effects as a learner returns them, in a world of one block on a row.

use std::path::Path;
use std::time::{Duration, Instant};

use pschema_learner::Frame;
use pschema_learner::curriculum::{Afterwards, Curriculum, Lift, Stage};
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Memory;
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};

use crate::error::StoreError;
use crate::{Cause, Change, Opened, Options, Store};

/// Schemas made by one batch while a memory is built up.
const BATCH: usize = 1_000;
/// Actions of the body.
const ACTIONS: i64 = 1_000;
/// How long it waits to be woken before it looks for itself.
const PATIENCE: Duration = Duration::from_millis(100);
/// Steps timed without a snapshot beside them.
const STEPS: usize = 500;
/// Steps timed at most with one.
const STEPS_MAX: usize = 20_000;

/// What was measured.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// Schemas in memory.
    pub schemas: usize,
    /// Bytes of the snapshot.
    pub snapshot_bytes: u64,
    /// How long it took, beside steps that were taken as fast as they became durable.
    pub snapshot_s: f64,
    /// The longest that handing a step over took: what making a snapshot costs the daemon's own thread.
    pub hand_us_max: f64,
    /// From handing a step over until it was durable, without a snapshot beside it: median and 99th percentile.
    pub commit_us: (f64, f64),
    /// The same while a snapshot was made.
    pub commit_beside_snapshot_us: (f64, f64),
    /// Steps of which that is.
    pub steps_beside_snapshot: usize,
    /// Cloning memory's chunks.
    pub clone_us: f64,
    /// One digest.
    pub digest_ms: f64,
    /// From nothing to a memory that can be stepped: snapshot, and the journal after it.
    pub start_s: f64,
    /// Frames of that journal.
    pub frames: u64,
}

/// Makes a memory of `schemas` schemas in the empty directory `directory`, has a snapshot made while steps are taken, ends
/// without saying so, and starts again.
///
/// # Errors
/// When the disk can't be read or written, or the directory holds a memory already that was begun otherwise.
pub fn figures(directory: &Path, schemas: usize) -> Result<Figures, StoreError> {
    let (parameters, curriculum) = (Parameters::default(), free());
    let mut options = Options::new("bench", 1, &parameters, &curriculum);
    // Only at the end of building.
    options.retention.snapshot_bytes = u64::MAX;
    let own = std::thread::current();
    let Opened { learner, store, .. } = crate::open(directory, options, move || own.unpark())?;
    let mut life = Life { memory: learner.into_memory(), store, frame: frame(0) };
    life.build(schemas)?;
    let memory = &life.memory;
    let cloned = Instant::now();
    let content = memory.content().clone();
    let clone_us = micros(cloned.elapsed());
    let digested = Instant::now();
    let before = digest(&content);
    let digest_ms = micros(digested.elapsed()) / 1e3;
    drop(content);
    let commits = life.steps(STEPS, |_| true)?;
    life.store.request_snapshot();
    let started = Instant::now();
    let snapshot = life.store.snapshot_step();
    let beside = life.steps(STEPS_MAX, |store| store.snapshot_step() == snapshot)?;
    while life.store.snapshot_step() == snapshot {
        if let Some(failure) = life.store.failure() {
            return Err(failure);
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let snapshot_s = started.elapsed().as_secs_f64();
    let step = life.memory.content().step;
    let (schemas, snapshot_bytes) = (life.memory.content().schemas.len(), life.store.snapshot_bytes());
    drop(life);
    let started = Instant::now();
    let Opened { learner, store, .. } = crate::open(directory, options, || ())?;
    let start_s = started.elapsed().as_secs_f64();
    let found = store.recovered();
    if found.step != step || before.is_empty() {
        return Err(StoreError::Content(format!("{} of {step} steps were found again", found.step)));
    }
    drop(learner);
    Ok(Figures {
        schemas,
        snapshot_bytes,
        snapshot_s,
        hand_us_max: beside.iter().map(|time| time.0).fold(0.0, f64::max),
        commit_us: percentiles(&commits),
        commit_beside_snapshot_us: percentiles(&beside),
        steps_beside_snapshot: beside.len(),
        clone_us,
        digest_ms,
        start_s,
        frames: found.frames,
    })
}

fn micros(time: Duration) -> f64 {
    time.as_secs_f64() * 1e6
}

/// Median and 99th percentile of the times until a step was durable.
fn percentiles(times: &[(f64, f64)]) -> (f64, f64) {
    let mut sorted: Vec<f64> = times.iter().map(|time| time.1).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |share: usize| sorted.get((sorted.len() * share / 100).min(sorted.len().saturating_sub(1)));
    (at(50).copied().unwrap_or(0.0), at(99).copied().unwrap_or(0.0))
}

/// A curriculum that asks nothing.
#[must_use]
pub fn free() -> Curriculum {
    let stage = Stage {
        name: "free".to_owned(),
        lift: Lift::All,
        learning: true,
        trials: 0,
        arrange: Vec::new(),
        until: None,
        until_absent: None,
        trial_actions_max: 0,
        saturation: None,
        habituation: None,
        say: Vec::new(),
    };
    Curriculum {
        name: "free".to_owned(),
        pools: Vec::new(),
        stages: vec![stage],
        afterwards: Afterwards::Continue,
    }
}

struct Life {
    memory: Memory,
    store: Store,
    frame: Frame,
}

impl Life {
    fn take(&mut self, cause: Cause<'_>, effects: &[Effect]) -> Result<u64, StoreError> {
        for effect in effects {
            self.memory.apply(effect).map_err(|error| StoreError::Content(error.to_string()))?;
        }
        let change = Change { cause, at_unix_ms: 0, effects };
        self.store.append(&change, self.memory.content())
    }

    fn build(&mut self, schemas: usize) -> Result<(), StoreError> {
        self.take(Cause::Declared("row"), &[Effect::Declared(Box::new(declaration()))])?;
        let mut made = self.memory.content().schemas.len();
        while made < schemas {
            let until = schemas.min(made + BATCH);
            let effects: Vec<Effect> = (made..until).map(created).collect();
            self.take(Cause::Order("build"), &effects)?;
            made = until;
        }
        Ok(())
    }

    /// Takes at most so many steps while `on` says so; for each, how long handing it over took, and how long it was until
    /// it was durable, in µs.
    fn steps(&mut self, max: usize, on: impl Fn(&Store) -> bool) -> Result<Vec<(f64, f64)>, StoreError> {
        let mut times = Vec::new();
        while times.len() < max && on(&self.store) {
            let step = self.memory.content().step;
            self.frame = frame(i64::try_from(step).unwrap_or(0) % 7_919);
            let frame = self.frame.clone();
            let effects = stepped(&frame, &self.memory);
            let began = Instant::now();
            let batch = self.take(Cause::Step(&frame), &effects)?;
            let handed = began.elapsed();
            while !self.store.is_durable(batch) {
                if let Some(failure) = self.store.failure() {
                    return Err(failure);
                }
                // The writer wakes it; the limit is for a writer that died.
                std::thread::park_timeout(PATIENCE);
            }
            times.push((micros(handed), micros(began.elapsed())));
        }
        Ok(times)
    }
}

fn at(kind: u16, field: i64) -> Observation {
    Observation::new(TypeId(kind), [(PropertyId(0), Value::Integer(field))])
}

fn frame(field: i64) -> Frame {
    let observations = (0..8).map(|place| at(1, field + place)).collect();
    Frame { body: BodyId(0), outcome: None, observations }
}

/// The schema of this number: a block in a field, a finger moved there, a touch.
fn created(number: usize) -> Effect {
    let number = i64::try_from(number).unwrap_or(0);
    let (field, action) = (number / ACTIONS, number % ACTIONS);
    Effect::Created {
        pre: vec![at(1, field), at(1, field + 1)],
        action: PrimitiveId(u32::try_from(action).unwrap_or(0)),
        post: vec![(at(0, action), false), (at(2, field), false)],
        parent: None,
        contradicts: None,
    }
}

/// What an ordinary step changes.
fn stepped(frame: &Frame, memory: &Memory) -> Vec<Effect> {
    let content = memory.content();
    let step = usize::try_from(content.step).unwrap_or(0);
    let primitive = PrimitiveId(u32::try_from(step % usize::try_from(ACTIONS).unwrap_or(1)).unwrap_or(0));
    vec![
        Effect::Attempted { primitive, carried_out: true },
        // A schema anywhere in memory, so that every chunk is copied sooner or later.
        created(step.wrapping_mul(7_919) % content.schemas.len().max(1)),
        Effect::Attended(frame.observations.clone()),
        Effect::StepEnded { body: BodyId(0), random: content.step, pending: None },
    ]
}

fn declaration() -> Declaration {
    let field = DeclaredProperty { name: "field".to_owned(), unit: String::new(), kind: ValueKind::Integer };
    let sense = |name: &str| DeclaredType {
        name: name.to_owned(),
        own: false,
        transient: false,
        heard: false,
        properties: vec![field.clone()],
    };
    Declaration {
        body: "row".to_owned(),
        observation_types: ["finger", "object", "touch"].map(sense).to_vec(),
        actions: vec![DeclaredAction { name: "move".to_owned(), parameters: vec![field.clone()] }],
        repertoire: (0..ACTIONS).map(|to| (0, vec![Parameter::Integer(to)])).collect(),
    }
}
