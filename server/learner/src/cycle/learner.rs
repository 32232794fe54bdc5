//! The learner: a memory, and the curriculum that it is led through.

use crate::cycle::step::{self, Caches};
use crate::cycle::{pursue, stages};
use crate::memory::Memory;
use crate::memory::draft::Draft;
use crate::nouns::curriculum::{Curriculum, CurriculumError};
use crate::nouns::effect::Effect;
use crate::nouns::frame::{Frame, Step};
use crate::nouns::mechanisms::Mechanisms;
use crate::nouns::observation::SymbolId;
use crate::nouns::parameters::{ParameterError, Parameters};
use crate::nouns::progress::{StageCommand, StageCommandError, StageEffect};
use crate::nouns::pursuit::{Goal, PursueError, Pursuit};
use crate::nouns::vocabulary::limits::DESCRIPTION_BYTES_MAX;
use crate::nouns::vocabulary::{BodyId, Declaration, DeclarationError};

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

/// A learner: memory, and the curriculum that it follows. The crate's page has a whole life of one.
///
/// ```
/// use pschema_learner::curriculum::Curriculum;
/// use pschema_learner::parameters::Parameters;
/// use pschema_learner::vocabulary::Declaration;
/// use pschema_learner::{Frame, Learner, Output};
///
/// let mut learner = Learner::new(7, Parameters::default(), Curriculum::free("play"))?;
/// let (body, effects) = learner.declare(Declaration { body: "arm".to_owned(), ..Declaration::default() })?;
/// assert_eq!(effects.len(), 1);
/// // A body that has no action waits.
/// let step = learner.step(&Frame { body, outcome: None, observations: Vec::new() });
/// assert_eq!((step.output, learner.memory().content().step), (Output::Hold, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Learner {
    memory: Memory,
    curriculum: Curriculum,
    caches: Caches,
}

impl Learner {
    /// A learner that knows nothing. `seed` decides its draws.
    ///
    /// # Errors
    /// When a parameter is out of range, or the curriculum can't be followed.
    pub fn new(seed: u64, parameters: Parameters, curriculum: Curriculum) -> Result<Self, LearnerError> {
        parameters.check()?;
        curriculum.check()?;
        Ok(Self { memory: Memory::new(seed, parameters), curriculum, caches: Caches::default() })
    }

    /// A learner that goes on from `memory`, with the parameters in it: given the same frames it decides as the
    /// learner would have that the memory was taken of.
    ///
    /// # Errors
    /// When a parameter is out of range, or the curriculum can't be followed.
    pub fn resume(memory: Memory, curriculum: Curriculum) -> Result<Self, LearnerError> {
        memory.parameters().check()?;
        curriculum.check()?;
        Ok(Self { memory, curriculum, caches: Caches::default() })
    }

    /// Gives up its curriculum for another, which begins with the next frame, and goes on under other parameters. Memory stays as it
    /// is otherwise.
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
        *self = Self { memory, curriculum, caches: Caches::default() };
        Ok(effects)
    }

    /// Its memory, to go on from.
    #[must_use]
    pub fn into_memory(self) -> Memory {
        self.memory
    }

    /// Its memory, to look at.
    #[must_use]
    pub fn memory(&self) -> &Memory {
        &self.memory
    }

    /// The curriculum that it is led through.
    #[must_use]
    pub fn curriculum(&self) -> &Curriculum {
        &self.curriculum
    }

    /// Takes in the declaration of a body, and returns the body's number.
    ///
    /// # Errors
    /// When the declaration contradicts memory or is more than memory holds; memory is then as it was.
    pub fn declare(&mut self, declaration: Declaration) -> Result<(BodyId, Vec<Effect>), DeclarationError> {
        self.memory.content().vocabulary.check(&declaration)?;
        let name = declaration.body.clone();
        let mut draft = Draft::new(&mut self.memory);
        draft.emit(Effect::Declared(Box::new(declaration)));
        let effects = draft.effects();
        let body = self.memory.content().vocabulary.body_named(&name);
        Ok((body.unwrap_or(BodyId(u16::MAX)), effects))
    }

    /// The number of a symbol, a word for instance; a new symbol is taken in. When memory can hold no more symbols the number is
    /// one that no symbol has, and an observation of it is not perceived.
    pub fn symbol(&mut self, name: &str) -> (SymbolId, Vec<Effect>) {
        let mut draft = Draft::new(&mut self.memory);
        draft.meet_symbol(name);
        let id = draft.memory().content().vocabulary.symbol_named(name);
        (id.unwrap_or(SymbolId(u32::MAX)), draft.effects())
    }

    /// Keeps how a declared body describes itself, for the host to compare when the body comes back. It decides nothing, and the
    /// digest leaves it out. A description that is too long, or the same, is not kept.
    pub fn describe(&mut self, body: BodyId, text: String) -> Vec<Effect> {
        let content = self.memory.content();
        let known = usize::from(body.0) < content.vocabulary.bodies().len();
        if !known || text.len() > DESCRIPTION_BYTES_MAX || content.description(body) == Some(&text) {
            return Vec::new();
        }
        let mut draft = Draft::new(&mut self.memory);
        draft.emit(Effect::Described { body, text });
        draft.effects()
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
        goal: impl Into<Goal>,
        actions_max: u32,
    ) -> Result<Vec<Effect>, PursueError> {
        let mut draft = Draft::new(&mut self.memory);
        pursue::begin(&mut draft, &self.curriculum, body, goal.into(), actions_max)?;
        Ok(draft.effects())
    }

    /// Calls off the goal that is pursued.
    ///
    /// # Errors
    /// When none is.
    pub fn cancel_goal(&mut self) -> Result<Vec<Effect>, PursueError> {
        let mut draft = Draft::new(&mut self.memory);
        pursue::cancel(&mut draft)?;
        Ok(draft.effects())
    }

    /// Whether it wants nothing of any body until an operator gives an order: it is held, or it is through.
    #[must_use]
    pub fn is_waiting(&self) -> bool {
        self.memory.content().progress.held || self.is_through()
    }

    /// Whether it wants nothing of any body, held or not, until an operator moves the curriculum on: it is stuck, or
    /// the curriculum is over and says to hold then, and no goal is pursued.
    #[must_use]
    pub fn is_through(&self) -> bool {
        let content = self.memory.content();
        stages::is_at_end(&content.progress, &self.curriculum)
            && !content.pursuit.as_deref().is_some_and(Pursuit::under_way)
    }

    /// Whether it wants nothing of `body` until an operator gives an order: it is held, or it is through with `body`.
    #[must_use]
    pub fn rests(&self, body: BodyId) -> bool {
        self.memory.content().progress.held || self.is_through_with(body)
    }

    /// Whether it wants nothing of `body`, held or not: as [`Learner::is_through`], but a goal keeps only the body
    /// awake that pursues it.
    #[must_use]
    pub fn is_through_with(&self, body: BodyId) -> bool {
        let content = self.memory.content();
        stages::is_at_end(&content.progress, &self.curriculum) && content.pursuit_of(body).is_none()
    }

    /// One step although an operator holds the learner: it is let go for this frame, and held again. Its effects begin
    /// with the one and end with the other, so that together they are one change: memory before it and memory after it
    /// are both held.
    pub fn single_step(&mut self, frame: &Frame) -> Step {
        let mut effects = self.set_held(false);
        let step = self.step(frame);
        effects.extend(step.effects);
        effects.extend(self.set_held(true));
        Step { effects, ..step }
    }

    /// Holds it, as an operator does, or lets it go on.
    pub fn set_held(&mut self, held: bool) -> Vec<Effect> {
        let mut draft = Draft::new(&mut self.memory);
        draft.emit(Effect::Stage(StageEffect::Held(held)));
        draft.effects()
    }

    /// Begins the curriculum for `body`, if it has not begun, and leaves it stuck for `reason`: the host found that the curriculum
    /// can't lead this body. Changes nothing if the curriculum leads another body, is over, or can't go on already.
    pub fn stick(&mut self, body: BodyId, reason: String) -> Vec<Effect> {
        let mut draft = Draft::new(&mut self.memory);
        stages::begin(&mut draft, &self.curriculum, body);
        let progress = &draft.memory().content().progress;
        if progress.student == Some(body) && !progress.finished && progress.stuck.is_none() {
            draft.emit(Effect::Stage(StageEffect::Stuck(reason)));
        }
        draft.effects()
    }

    /// Makes memory take in nothing new from here, because the host has no more room for it, or lets it grow again. While memory is
    /// full the learner still acts, and counts how often the schemas that it has succeed. No effect is returned if nothing changes.
    pub fn set_full(&mut self, full: bool) -> Vec<Effect> {
        if self.memory.content().full == full {
            return Vec::new();
        }
        let mut draft = Draft::new(&mut self.memory);
        draft.emit(Effect::Full(full));
        draft.effects()
    }

    /// Switches the mechanisms beyond the paper; those that need one that is off are off with it. No effect is returned if nothing changes.
    pub fn set_mechanisms(&mut self, mechanisms: Mechanisms) -> Vec<Effect> {
        let mechanisms = mechanisms.sound();
        if self.memory.content().mechanisms == mechanisms {
            return Vec::new();
        }
        let mut draft = Draft::new(&mut self.memory);
        draft.emit(Effect::Mechanisms(mechanisms));
        draft.effects()
    }

    /// One step of the cycle in `docs/LEARNING.md`. A frame of a body that was never declared is answered with
    /// [`Output::Hold`](crate::Output::Hold) and changes nothing.
    pub fn step(&mut self, frame: &Frame) -> Step {
        step::step(&mut self.memory, &self.curriculum, &mut self.caches, frame)
    }
}
