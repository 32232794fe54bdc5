//! A memory on disk that grows at will: effects as a learner returns them, in a world of one block on a row.

use std::path::Path;
use std::time::{Duration, Instant};

use pschema_learner::Frame;
use pschema_learner::curriculum::Curriculum;
use pschema_learner::effect::{Effect, Score};
use pschema_learner::memory::{Content, Memory};
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};
use pschema_store::{Cause, Change, Opened, Options, Store};
use pschema_tools::kit::Failure;

use crate::times::Times;

/// Schemas made by one batch while a memory is built up.
const BATCH: usize = 1_000;
/// Actions of the body.
const ACTIONS: i64 = 1_000;
/// How long it waits to be woken before it looks for itself.
const PATIENCE: Duration = Duration::from_millis(100);

/// The learner's parameters, and a curriculum that asks nothing.
pub(super) fn setting() -> (Parameters, Curriculum) {
    (Parameters::default(), Curriculum::free("free"))
}

/// A memory, and the store that keeps it.
pub(super) struct GrowingMemory {
    memory: Memory,
    store: Store,
}

impl GrowingMemory {
    /// The memory in a directory, which is made when it isn't there. The thread that calls this is the one that is woken
    /// when a step has become durable.
    pub(super) fn open(directory: &Path, options: Options<'_>) -> Result<Self, Failure> {
        let own = std::thread::current();
        let opened = pschema_store::open(directory, options, move || own.unpark());
        let Opened { learner, store, .. } = opened.map_err(Failure::of)?;
        Ok(Self { memory: learner.into_memory(), store })
    }

    pub(super) fn content(&self) -> &Content {
        self.memory.content()
    }

    pub(super) fn store(&mut self) -> &mut Store {
        &mut self.store
    }

    fn take(&mut self, cause: Cause<'_>, effects: &[Effect]) -> Result<u64, Failure> {
        for effect in effects {
            self.memory.apply(effect).map_err(Failure::of)?;
        }
        let change = Change { cause, at_unix_ms: 0, effects };
        self.store.append(&change, self.memory.content()).map_err(Failure::of)
    }

    /// Has `schemas` schemas made.
    pub(super) fn build(&mut self, schemas: usize) -> Result<(), Failure> {
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

    /// Takes at most so many steps while `on` says so. Returns how long each took from being handed over until it was
    /// durable.
    pub(super) fn steps(&mut self, max: usize, on: impl Fn(&Store) -> bool) -> Result<Times, Failure> {
        let mut times = Times::default();
        while times.len() < max && on(&self.store) {
            let step = self.memory.content().step;
            let frame = frame(i64::try_from(step).unwrap_or(0) % 7_919);
            let effects = stepped(&frame, &self.memory);
            let began = Instant::now();
            let batch = self.take(Cause::Step(&frame), &effects)?;
            while !self.store.is_durable(batch) {
                if let Some(failure) = self.store.failure() {
                    return Err(Failure::of(failure));
                }
                // The writer wakes it; the limit is for a writer that died.
                std::thread::park_timeout(PATIENCE);
            }
            times.push(began.elapsed());
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

/// An execution of a schema anywhere in memory, so that every chunk is copied sooner or later.
fn scored(number: usize) -> Effect {
    Effect::Executed {
        schema: SchemaId(u32::try_from(number).unwrap_or(0)),
        success: true,
        post: vec![Score::Held; 2],
        associations: Vec::new(),
    }
}

/// What an ordinary step changes.
fn stepped(frame: &Frame, memory: &Memory) -> Vec<Effect> {
    let content = memory.content();
    let step = usize::try_from(content.step).unwrap_or(0);
    let primitive = PrimitiveId(u32::try_from(step % usize::try_from(ACTIONS).unwrap_or(1)).unwrap_or(0));
    vec![
        Effect::Attempted { primitive, carried_out: true },
        scored(step.wrapping_mul(7_919) % content.schemas.len().max(1)),
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
        value: false,
        properties: vec![field.clone()],
    };
    Declaration {
        body: "row".to_owned(),
        observation_types: ["finger", "object", "touch"].map(sense).to_vec(),
        actions: vec![DeclaredAction { name: "move".to_owned(), parameters: vec![field.clone()] }],
        repertoire: (0..ACTIONS).map(|to| (0, vec![Parameter::Integer(to)])).collect(),
    }
}
