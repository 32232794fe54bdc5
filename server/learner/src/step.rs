//! The learner and its cycle: one frame in, one decision out (paper, II).
//!
//! A step is a deterministic function of the frame and of memory. It changes memory only by the effects
//! that it returns, through [`Memory::apply`]; applying them to a copy of the earlier memory gives the same
//! memory. No clock, no I/O, no thread; the only randomness is the seeded generator in memory.

use crate::association::{associate, happened};
use crate::attention::attend;
use crate::babbling::executable;
use crate::bound::Bound;
use crate::chaining::Reach;
use crate::choice::{self, Choice, Situation, known_ids};
use crate::creation::{self, Creation};
use crate::curriculum::{Curriculum, CurriculumError, SceneCommand};
use crate::decision::Decision;
use crate::draft::Draft;
use crate::effect::{Effect, Execution};
use crate::excitation::Perceived;
use crate::generalisation;
use crate::habituation::unhabituated;
use crate::matched::Matched;
use crate::memory::Memory;
use crate::observation::{Observation, Pattern, Substitution, SymbolId, TypeId};
use crate::parameters::{ParameterError, Parameters};
use crate::progress::{StageCommand, StageCommandError, StageEffect};
use crate::pursuit::{self, PursueError};
use crate::random::Random;
use crate::schema::SchemaId;
use crate::stages::{self, Demand, Novelty, is_lifted};
use crate::vocabulary::{BodyId, Declaration, DeclarationError, PrimitiveId};
use crate::world_state::WorldState;

/// What a body reports.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Which body.
    pub body: BodyId,
    /// How the last action, or arranging, went; none when nothing was asked.
    pub outcome: Option<ActionOutcome>,
    /// Everything it perceives, words heard since the last frame included.
    pub observations: Vec<Observation>,
}

/// How an action went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActionOutcome {
    /// Carried out.
    Done,
    /// Not begun.
    Refused,
    /// Begun and not completed.
    Failed,
    /// Not completed in time.
    TimedOut,
}

/// What a step decided, and everything it changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What the body is to do.
    pub output: Output,
    /// What changed, in order.
    pub effects: Vec<Effect>,
    /// Why, when an action was chosen.
    pub decision: Option<Decision>,
}

/// What a body is to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// Carry this out.
    Act(PrimitiveId),
    /// Arrange the surroundings so, in this order.
    Arrange(Vec<SceneCommand>),
    /// Nothing for now.
    Hold,
}

/// Why a learner can't be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LearnerError {
    /// A parameter is out of range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// The curriculum can't be followed.
    #[error(transparent)]
    Curriculum(#[from] CurriculumError),
}

/// A learner: memory, and the curriculum that it follows.
#[derive(Clone, Debug)]
pub struct Learner {
    memory: Memory,
    curriculum: Curriculum,
    /// The last search for chains; kept while it holds, and never part of memory.
    reach: Option<Reach>,
    /// The last matches of laws; likewise.
    matched: Matched,
}

impl Learner {
    /// A learner that knows nothing. `seed` decides its draws.
    ///
    /// # Errors
    /// When a parameter is out of range, or the curriculum can't be followed.
    pub fn new(seed: u64, parameters: Parameters, curriculum: Curriculum) -> Result<Self, LearnerError> {
        parameters.check()?;
        curriculum.check()?;
        Ok(Self {
            memory: Memory::new(seed, parameters),
            curriculum,
            reach: None,
            matched: Matched::default(),
        })
    }

    /// A learner that goes on from `memory`, with the parameters in it: given the same frames it decides as the
    /// learner would have that the memory was taken of.
    ///
    /// # Errors
    /// When a parameter is out of range, or the curriculum can't be followed.
    pub fn resume(memory: Memory, curriculum: Curriculum) -> Result<Self, LearnerError> {
        memory.parameters().check()?;
        curriculum.check()?;
        Ok(Self { memory, curriculum, reach: None, matched: Matched::default() })
    }

    /// Gives up its curriculum for another, which begins with the next frame, and goes on under other parameters:
    /// what it has learnt stays.
    ///
    /// # Errors
    /// When a parameter is out of range, or the curriculum can't be followed; nothing is changed then.
    pub fn change(
        &mut self,
        parameters: Parameters,
        curriculum: Curriculum,
    ) -> Result<Vec<Effect>, LearnerError> {
        parameters.check()?;
        curriculum.check()?;
        let mut draft = Draft::new(&mut self.memory);
        draft.emit(Effect::Stage(StageEffect::Left));
        let effects = draft.effects();
        let content = self.memory.content().clone();
        let memory = Memory::restore(content, parameters);
        *self = Self { memory, curriculum, reach: None, matched: Matched::default() };
        Ok(effects)
    }

    /// Its memory, to go on from.
    #[must_use]
    pub fn into_memory(self) -> Memory {
        self.memory
    }

    /// What it knows.
    #[must_use]
    pub fn memory(&self) -> &Memory {
        &self.memory
    }

    /// What it is led through.
    #[must_use]
    pub fn curriculum(&self) -> &Curriculum {
        &self.curriculum
    }

    /// Takes in what a body declares of itself.
    ///
    /// # Errors
    /// When it contradicts what is known; memory is then as it was.
    pub fn declare(&mut self, declaration: Declaration) -> Result<(BodyId, Vec<Effect>), DeclarationError> {
        self.memory.content().vocabulary.check(&declaration)?;
        let name = declaration.body.clone();
        let mut draft = Draft::new(&mut self.memory);
        draft.emit(Effect::Declared(Box::new(declaration)));
        let effects = draft.effects();
        let body = self.memory.content().vocabulary.body_named(&name);
        Ok((body.unwrap_or(BodyId(u16::MAX)), effects))
    }

    /// The number of a symbol, a word for instance; new symbols are taken in.
    pub fn symbol(&mut self, name: &str) -> (SymbolId, Vec<Effect>) {
        let mut draft = Draft::new(&mut self.memory);
        if draft.memory().content().vocabulary.symbol_named(name).is_none() {
            draft.emit(Effect::SymbolsMet(vec![name.to_owned()]));
        }
        let id = draft.memory().content().vocabulary.symbol_named(name);
        (id.unwrap_or(SymbolId(u32::MAX)), draft.effects())
    }

    /// Obeys an operator's developmental control.
    ///
    /// # Errors
    /// When there is no such stage; memory is then as it was.
    pub fn stage(&mut self, command: &StageCommand) -> Result<Vec<Effect>, StageCommandError> {
        let mut draft = Draft::new(&mut self.memory);
        stages::command(&mut draft, &self.curriculum, command)?;
        Ok(draft.effects())
    }

    /// Takes up a goal: `body` pursues it, with at most `actions_max` actions, until it holds or nothing known
    /// leads there. One goal at a time.
    ///
    /// # Errors
    /// When it can't be pursued; memory is then as it was.
    pub fn pursue(
        &mut self,
        body: BodyId,
        goal: Vec<Pattern>,
        actions_max: u32,
    ) -> Result<Vec<Effect>, PursueError> {
        let mut draft = Draft::new(&mut self.memory);
        pursuit::begin(&mut draft, &self.curriculum, body, goal, actions_max)?;
        Ok(draft.effects())
    }

    /// Calls off the goal that is pursued.
    ///
    /// # Errors
    /// When none is.
    pub fn cancel_goal(&mut self) -> Result<Vec<Effect>, PursueError> {
        let mut draft = Draft::new(&mut self.memory);
        pursuit::cancel(&mut draft)?;
        Ok(draft.effects())
    }

    /// One step. The numbers are those of the cycle in `docs/LEARNING.md`. A frame of a body that was never
    /// declared is answered with [`Output::Hold`] and changes nothing.
    pub fn step(&mut self, frame: &Frame) -> Step {
        let Learner { memory, curriculum, reach, matched } = self;
        if usize::from(frame.body.0) >= memory.content().pending.len() {
            return Step { output: Output::Hold, effects: Vec::new(), decision: None };
        }
        let mut draft = Draft::new(memory);
        // 1. A frame arrives.
        let pending = draft.memory().content().pending[usize::from(frame.body.0)].clone();
        stages::begin(&mut draft, curriculum, frame.body);
        let student = draft.memory().content().progress.student == Some(frame.body);
        // While a goal is pursued the curriculum waits, its teacher included.
        let led = student && pursuit::of(draft.memory().content(), frame.body).is_none();
        let heard =
            if led { stages::spoken(&mut draft, curriculum, &frame.observations) } else { Vec::new() };
        let with_heard;
        let frame = if heard.is_empty() {
            frame
        } else {
            let observations = frame.observations.iter().cloned().chain(heard).collect();
            with_heard = Frame { observations, ..frame.clone() };
            &with_heard
        };
        let (world, lifted) = lift(draft.memory(), curriculum, frame);
        // 2 to 7. Learn from the execution that it ends.
        let mut chain = Vec::new();
        let mut acted = None;
        let for_goal = pending.as_ref().is_some_and(|execution| execution.for_goal);
        match (pending, frame.outcome) {
            (Some(execution), Some(outcome)) => {
                let carried_out = outcome == ActionOutcome::Done;
                if stages::present(draft.memory(), curriculum).learning {
                    draft.emit(Effect::Attempted { primitive: execution.action, carried_out });
                    if carried_out {
                        acted = Some(learn(&mut draft, &execution, &world, &lifted));
                    }
                } else if carried_out {
                    acted = Some(Novelty::default());
                }
                if carried_out {
                    chain = execution.chain;
                }
            }
            (None, Some(ActionOutcome::Refused | ActionOutcome::Failed | ActionOutcome::TimedOut))
                if student && draft.memory().content().progress.trial_open =>
            {
                let reason = "the body could not arrange its surroundings as the curriculum asks".to_owned();
                draft.emit(Effect::Stage(StageEffect::Stuck(reason)));
            }
            _ => (),
        }
        // 8. Where the curriculum stands.
        let novelty = acted.filter(|_| student && !for_goal);
        if let Some(novelty) = novelty {
            stages::acted(&mut draft, curriculum, novelty, &world);
        }
        pursuit::observed(&mut draft, curriculum, frame, &world, acted.is_some());
        // 9 and 10. Choose, and resolve to a primitive: for the goal, if one is pursued.
        let outcome = frame.outcome.filter(|_| for_goal);
        let before = pursuit::Before { outcome, chain: &chain };
        let (output, decision, execution, random) = pursue(&mut draft, reach, frame.body, &world, &before)
            .unwrap_or_else(|| {
                let chain = if for_goal { &[][..] } else { &chain };
                choose(&mut draft, curriculum, (reach, matched), frame, novelty, chain)
            });
        draft.emit(Effect::StepEnded {
            body: frame.body,
            random: random.state(),
            pending: execution.map(Box::new),
        });
        Step { output, effects: draft.effects(), decision }
    }
}

/// The world state under the constraints of the present stage, and which types it lifts.
fn lift(memory: &Memory, curriculum: &Curriculum, frame: &Frame) -> (WorldState, Vec<bool>) {
    let lifted = stages::lifted(&memory.content().vocabulary, stages::present(memory, curriculum));
    let seen = frame.observations.iter().filter(|observation| is_lifted(&lifted, observation.kind()));
    (WorldState::new(seen.cloned()), lifted)
}

/// Steps 2 to 7: what an execution that was carried out teaches.
fn learn(draft: &mut Draft<'_>, execution: &Execution, after: &WorldState, lifted: &[bool]) -> Novelty {
    let lifted = |kind: TypeId| is_lifted(lifted, kind);
    let before = &execution.before;
    let none = Substitution::new();
    let executed: Vec<(SchemaId, &Substitution)> = execution
        .schema
        .map(|schema| (schema, &execution.binding))
        .into_iter()
        .chain(execution.carrier.map(|carrier| (carrier, &none)))
        .collect();
    let content = draft.memory().content();
    let reads = |(schema, binding): &(SchemaId, &Substitution)| Bound::new(content, *schema, binding);
    let bounds: Vec<_> = executed.iter().map(reads).collect();
    let bound = execution.schema.and_then(|_| bounds.first()?.as_ref());
    // 3 comes before 2 is applied: a schema's surprise is measured against what it knew beforehand.
    let surprise = creation::surprise(draft.memory(), bound, before, after, &lifted);
    for ((schema, _), bound) in executed.iter().zip(&bounds) {
        let Some(bound) = bound else { continue };
        let scored = creation::score(draft.memory(), *schema, bound, before, after, &lifted);
        draft.emit_all(scored);
    }
    // 4. Create.
    let Creation { created, updated, counter_example } =
        creation::create(draft, execution, &surprise, after, &lifted);
    // 5. Associate.
    let happened = happened(draft.memory(), before, after);
    draft.emit_all(happened);
    let mut concerned = executed.clone();
    concerned.extend(created.into_iter().chain(updated).map(|schema| (schema, &none)));
    let content = draft.memory().content();
    let reads = |(schema, binding): &(SchemaId, &Substitution)| Bound::new(content, *schema, binding);
    let explained: Vec<_> = concerned.iter().map(reads).collect();
    let around = WorldState::new(before.observations().iter().chain(after.observations()).cloned());
    for (schema, _) in &concerned {
        let associated = associate(draft.memory(), *schema, &explained, &around);
        draft.emit_all(associated);
    }
    // 6. Attend: to what the executed schema refers to, or the first schema of a primitive.
    let attending = if executed.is_empty() { concerned.len() } else { executed.len() };
    let attending = concerned.into_iter().map(|(schema, _)| schema).zip(&explained).take(attending);
    let attended = attend(draft.memory(), attending, before, after);
    draft.emit_all(attended);
    // 7. Generalise on every new schema, and retire what has failed too often.
    let before_generalising = draft.memory().content().generalised_count;
    if let Some(seed) = created.filter(|_| draft.memory().parameters().generalisation) {
        let generalised = generalisation::generalise(draft.memory(), seed);
        draft.emit_all(generalised);
    }
    if let Some(generalised) = execution.schema.filter(|id| generalisation::refuted(draft.memory(), *id)) {
        draft.emit(Effect::Retired { generalised });
    }
    Novelty {
        concrete: u32::from(created.is_some()),
        generalised: draft.memory().content().generalised_count - before_generalising,
        counter_examples: u32::from(counter_example),
    }
}

type Chosen = (Output, Option<Decision>, Option<Execution>, Random);

/// Steps 9 and 10 in pursuit of a goal; none when there is none, or when it is given up.
fn pursue(
    draft: &mut Draft<'_>,
    reach: &mut Option<Reach>,
    body: BodyId,
    world: &WorldState,
    before: &pursuit::Before<'_>,
) -> Option<Chosen> {
    let memory = draft.memory();
    if memory.content().progress.held || pursuit::of(memory.content(), body).is_none() {
        return None;
    }
    let reach = Reach::renew(reach, memory, body, world);
    let random = memory.content().random;
    let (execution, decision) = pursuit::next(draft, body, world, reach, before)?;
    Some((Output::Act(execution.action), Some(decision), Some(execution), random))
}

/// Steps 8 to 10: follows the curriculum, then goes on with the chain or takes the most exciting schema.
fn choose(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    (reach, matched): (&mut Option<Reach>, &mut Matched),
    frame: &Frame,
    mut acted: Option<Novelty>,
    chain: &[crate::effect::ChainLink],
) -> Chosen {
    let student = draft.memory().content().progress.student == Some(frame.body);
    let entered = |draft: &Draft<'_>| {
        let progress = &draft.memory().content().progress;
        (progress.stage, progress.finished)
    };
    let at_first = entered(draft);
    loop {
        let random = draft.memory().content().random;
        match stages::demand(draft, curriculum, student) {
            Demand::Hold => return (Output::Hold, None, None, random),
            Demand::Arrange(commands) => return (Output::Arrange(commands), None, None, random),
            Demand::Free => (),
        }
        let (world, _) = lift(draft.memory(), curriculum, frame);
        let memory = draft.memory();
        let reach = Reach::renew(reach, memory, frame.body, &world);
        let executable = executable(memory, frame.body, &known_ids(memory, &world));
        let perceived = &Perceived::new(&world);
        let wanting = |memory: &Memory| {
            let progress = &memory.content().progress;
            let first_step = progress.report().map_or(0, |report| report.first_step);
            let rule = stages::present(memory, curriculum).habituation.as_ref();
            rule.map_or_else(Vec::new, |rule| unhabituated(memory, rule, first_step, &executable))
        };
        let wanted = if memory.content().progress.habituating { wanting(memory) } else { Vec::new() };
        let body = frame.body;
        let situation = Situation {
            memory,
            body,
            world: &world,
            perceived,
            reach,
            unhabituated: &wanted,
            executable: &executable,
        };
        let scored = Choice::new(&situation, matched);
        if let Some(novelty) = acted.take() {
            // Only the first turn follows an action; a stage entered here starts its own count.
            let top = scored.top;
            if stages::saturate(draft, curriculum, novelty, top, |memory| !wanting(memory).is_empty()) {
                continue;
            }
            if draft.memory().content().progress.habituating && wanted.is_empty() {
                continue;
            }
        }
        let memory = draft.memory();
        let situation = Situation {
            memory,
            body,
            world: &world,
            perceived,
            reach,
            unhabituated: &wanted,
            executable: &executable,
        };
        if entered(draft) == at_first
            && let Some((execution, decision)) = choice::continue_chain(&situation, chain)
        {
            return (Output::Act(execution.action), Some(decision), Some(execution), random);
        }
        let mut random = random;
        return match scored.decide(&situation, &mut random) {
            Some((execution, decision)) => {
                (Output::Act(execution.action), Some(decision), Some(execution), random)
            }
            None => (Output::Hold, None, None, random),
        };
    }
}
