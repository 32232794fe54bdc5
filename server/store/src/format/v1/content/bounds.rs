//! What numbers on disk may refer to.

use pschema_learner::memory::Content;
use pschema_learner::schema::ASSOCIATIONS_MAX;
use pschema_learner::vocabulary::limits::SYMBOLS_MAX;

use super::super::Effect;
use super::super::effect::{ChainLink, Execution};
use super::super::observation::{Observation, Pattern, Substitution, Term, Value};
use super::super::stage::{PursuitEffect, StageEffect};
use super::{Form, Schema};

/// How much there is of what numbers on disk refer to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(super) types: usize,
    pub(super) properties: usize,
    pub(super) symbols: usize,
    pub(super) primitives: usize,
    pub(super) bodies: usize,
    pub(super) observations: usize,
    pub(super) schemas: usize,
    pub(super) stages: usize,
}

impl Bounds {
    /// What `content` has: what an effect that changes it may refer to. The curriculum has so many stages.
    pub(crate) fn of(content: &Content, stages: usize) -> Self {
        let vocabulary = &content.vocabulary;
        Self {
            types: vocabulary.types().len(),
            properties: vocabulary.properties().len(),
            symbols: vocabulary.symbols().len(),
            primitives: vocabulary.primitives().len(),
            bodies: vocabulary.bodies().len(),
            observations: content.observations.len(),
            schemas: content.schemas.len(),
            stages,
        }
    }

    fn value(&self, value: Value) -> bool {
        !matches!(value, Value::Symbol(symbol) if symbol as usize >= self.symbols)
    }

    pub(super) fn observation(&self, observation: &Observation) -> bool {
        usize::from(observation.kind) < self.types
            && observation.properties.iter().all(|(p, v)| usize::from(*p) < self.properties && self.value(*v))
    }

    pub(super) fn pattern(&self, pattern: &Pattern) -> bool {
        let term = |term: &Term| match term {
            Term::Constant(value) => self.value(*value),
            Term::Variable(_) => true,
        };
        usize::from(pattern.kind) < self.types
            && pattern.terms.iter().all(|(p, t)| usize::from(*p) < self.properties && term(t))
    }

    fn schemas<'a>(&self, ids: impl IntoIterator<Item = &'a u32>) -> bool {
        ids.into_iter().all(|id| (*id as usize) < self.schemas)
    }

    fn interned<'a>(&self, ids: impl IntoIterator<Item = &'a u32>) -> bool {
        ids.into_iter().all(|id| (*id as usize) < self.observations)
    }

    fn substitution(&self, binding: &Substitution) -> bool {
        binding.0.iter().all(|(_, value)| self.value(*value))
    }

    pub(super) fn link(&self, link: &ChainLink) -> bool {
        self.schemas([&link.schema].into_iter().chain(&link.carrier)) && self.substitution(&link.binding)
    }

    pub(super) fn execution(&self, execution: &Execution) -> bool {
        (execution.action as usize) < self.primitives
            && self.schemas(execution.schema.iter().chain(&execution.carrier))
            && self.substitution(&execution.binding)
            && execution.chain.iter().all(|link| self.link(link))
            && execution.before.iter().all(|observation| self.observation(observation))
    }

    pub(super) fn goal(&self, body: u16, goal: &[Pattern]) -> bool {
        usize::from(body) < self.bodies && goal.iter().all(|pattern| self.pattern(pattern))
    }

    pub(super) fn schema(&self, schema: &Schema) -> bool {
        let form = match &schema.form {
            Form::Concrete { pre, action, post, contradicts } => {
                (*action as usize) < self.primitives
                    && self.interned(pre.iter().chain(post.iter().map(|p| &p.what)))
                    && self.schemas(contradicts)
            }
            Form::Generalised { pre, target, post, examples, counter_examples, retired: _ } => {
                let patterns = pre.iter().chain(target).chain(post.iter().map(|p| &p.what));
                patterns.into_iter().all(|pattern| self.pattern(pattern))
                    && self.schemas(examples.iter().chain(counter_examples))
            }
        };
        form && self.interned(schema.associations.iter().map(|a| &a.observation))
            && self.schemas(&schema.parent)
            && schema.associations.len() <= ASSOCIATIONS_MAX
    }
}

impl Effect {
    /// Whether all that the effect speaks of is there in memory as it is, beyond what
    /// [`pschema_learner::memory::Memory::apply`] checks.
    pub(crate) fn fits(&self, bounds: &Bounds) -> bool {
        let all = |list: &[Observation]| list.iter().all(|one| bounds.observation(one));
        match self {
            Self::OutcomeAdded { observation, .. } | Self::Associated { observation, .. } => {
                bounds.observation(observation)
            }
            Self::Created { pre, post, parent, .. } => {
                all(pre) && post.iter().all(|(one, _)| bounds.observation(one)) && bounds.schemas(parent)
            }
            Self::Generalised { pre, target, post, .. } => {
                let patterns = pre.iter().chain(target).chain(post.iter().map(|(pattern, _)| pattern));
                patterns.into_iter().all(|pattern| bounds.pattern(pattern))
            }
            Self::Happened(list) | Self::Attended(list) => all(list),
            Self::StepEnded { pending: Some(execution), .. } => bounds.execution(execution),
            Self::SymbolsMet(symbols) => bounds.symbols.saturating_add(symbols.len()) <= SYMBOLS_MAX,
            Self::Stage(StageEffect::Entered { stage, .. }) => *stage < bounds.stages as u64,
            Self::Stage(StageEffect::Begun { student, .. }) => usize::from(*student) < bounds.bodies,
            Self::Pursuit(PursuitEffect::Begun { body, goal, .. }) => bounds.goal(*body, goal),
            Self::Pursuit(PursuitEffect::Planned(plan)) => plan.chain().iter().all(|link| bounds.link(link)),
            _ => true,
        }
    }
}
