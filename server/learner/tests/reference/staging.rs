//! Step 8 of the cycle: developmental control (II-F, II-G).

use pschema_learner::curriculum::{
    Absence, Afterwards, Argument, Lift, NamedObservation, SceneCommand, Stage,
};
use pschema_learner::effect::Effect;
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::progress::{StageCommand, StageCommandError, StageEffect};
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::BodyId;
use pschema_learner::world_state::WorldState;
use pschema_learner::{ActionOutcome, Frame};

use super::learner::Reference;
use super::learning::Made;
use super::schema::Schema;

/// What the curriculum asks for.
pub(crate) enum Demand {
    Act,
    Arrange(Vec<SceneCommand>),
    Hold,
}

impl Reference {
    pub(crate) fn stage(&self) -> &Stage {
        &self.memory.curriculum.stages[self.memory.standing.stage]
    }

    pub(crate) fn lifted(&self, kind: TypeId) -> bool {
        let known = self.memory.types.get(usize::from(kind.0));
        known.is_some_and(|declared| match &self.stage().lift {
            Lift::All => true,
            Lift::Types(names) => names.contains(&declared.name),
        })
    }

    /// Whether every property and symbol of an observation was declared or met.
    fn declared(&self, observation: &Observation) -> bool {
        observation.properties().iter().all(|(property, value)| {
            let symbol = match value {
                Value::Symbol(symbol) => self.memory.symbols.get(symbol.0 as usize).is_some(),
                _ => true,
            };
            symbol && self.memory.properties.get(usize::from(property.0)).is_some()
        })
    }

    pub(crate) fn world(&self, frame: &Frame) -> WorldState {
        let perceived = frame.observations.iter().filter(|o| self.lifted(o.kind()) && self.declared(o));
        WorldState::new(perceived.cloned())
    }

    fn staged(&mut self, effect: StageEffect) {
        self.emit(Effect::Stage(effect));
    }

    /// Takes note that the surroundings could not be arranged.
    pub(crate) fn arranged(&mut self, outcome: Option<ActionOutcome>) {
        if self.memory.standing.trial_open && outcome.is_some_and(|o| o != ActionOutcome::Done) {
            self.staged(StageEffect::Stuck(String::new()));
        }
    }

    pub(crate) fn begin(&mut self, student: BodyId) {
        let idle = self.memory.bodies[usize::from(student.0)].1.is_empty();
        if self.memory.standing.begun || idle {
            return;
        }
        let mut random = self.memory.random;
        let mut pools = Vec::new();
        for pool in &self.memory.curriculum.pools {
            let mut numbers: Vec<i64> = (pool.from..=pool.to).collect();
            for at in (1..numbers.len()).rev() {
                numbers.swap(at, random.below(at + 1));
            }
            pools.push(numbers);
        }
        self.staged(StageEffect::Begun { student, pools, random: random.state() });
        if !self.memory.standing.entered {
            self.enter(0);
        }
    }

    fn enter(&mut self, stage: usize) {
        let name = self.memory.curriculum.stages[stage].name.clone();
        self.staged(StageEffect::Entered { stage, name });
    }

    /// Ends the present stage and enters the next, if there is one.
    fn advance(&mut self) {
        self.staged(StageEffect::Ended);
        let next = self.memory.standing.stage + 1;
        if next < self.memory.curriculum.stages.len() {
            self.enter(next);
        } else {
            self.staged(StageEffect::Finished);
        }
    }

    /// What an action of the student means for the trial under way.
    pub(crate) fn acted(&mut self, made: Made, frame: &Frame) {
        let world = self.world(frame).observations().to_vec();
        let absent =
            self.stage().until_absent.as_ref().is_some_and(|a| !self.observed(&a.observation, &world));
        self.staged(StageEffect::Acted {
            concrete_new: made.concrete,
            generalised_new: made.generalised,
            counter_examples_new: made.counter_examples,
            absent,
        });
        let most = self.stage().trial_actions_max;
        let long = |a: &Absence| self.memory.standing.absent_actions >= a.actions;
        let met = self.stage().until.as_ref().is_some_and(|until| self.observed(until, &world))
            || self.stage().until_absent.as_ref().is_some_and(long);
        let used_up = most > 0 && self.memory.standing.trial_actions >= most;
        if self.memory.standing.trial_open && (met || used_up) {
            self.end_trial(met);
        }
    }

    /// What is to be done now, after ending the stage if it is over.
    pub(crate) fn demand(&mut self, student: bool) -> Demand {
        loop {
            let standing = self.memory.standing.clone();
            let over = standing.finished && self.memory.curriculum.afterwards == Afterwards::Hold;
            if standing.held || standing.stuck || over {
                return Demand::Hold;
            }
            if !student || standing.finished || standing.trial_open {
                return Demand::Act;
            }
            if standing.trials < self.stage().trials {
                return self.begin_trial();
            }
            if self.stage().trials == 0 || self.stage().saturation.is_some() {
                return Demand::Act;
            }
            self.advance();
        }
    }

    pub(crate) fn end_trial(&mut self, met: bool) {
        let generalised = self.memory.schemas.iter().filter(|s| s.action.is_none()).count();
        self.staged(StageEffect::TrialEnded { met, generalised: u32::try_from(generalised).unwrap() });
    }

    /// What the teacher says in a frame of the student.
    pub(crate) fn spoken(&mut self, frame: &Frame) -> Vec<Observation> {
        let standing = self.memory.standing.clone();
        let say = self.stage().say.clone();
        if say.is_empty() || standing.held || standing.finished || standing.stuck || !standing.trial_open {
            return Vec::new();
        }
        let mut random = self.memory.random;
        let (mut utterances, mut words) = (Vec::new(), Vec::new());
        for (at, utterance) in say.iter().enumerate() {
            let times = standing.said.iter().filter(|said| **said == at).count();
            let occasion = match &utterance.when {
                Some(when) => self.observed(when, &frame.observations),
                None => standing.fresh,
            };
            let hushed =
                utterance.unless.as_ref().is_some_and(|unless| self.observed(unless, &frame.observations));
            if !occasion || hushed || times >= utterance.times_max as usize {
                continue;
            }
            if random.happens(utterance.probability) {
                utterances.push(at);
                words.push(utterance.heard[random.below(utterance.heard.len())].clone());
            }
        }
        for (_, value) in words.iter().flat_map(|words| &words.properties) {
            if let Argument::Symbol(symbol) = value
                && !self.memory.symbols.contains(symbol)
            {
                self.emit(Effect::SymbolsMet(vec![symbol.clone()]));
            }
        }
        self.staged(StageEffect::Spoken { utterances, random: random.state() });
        let position = |names: &[String], name: &str| names.iter().position(|known| known == name);
        let hear = |words: &NamedObservation| {
            let kind = self.memory.types.iter().position(|known| known.name == words.kind)?;
            let mut properties = Vec::new();
            for (name, value) in &words.properties {
                let value = match value {
                    Argument::Integer(value) => Value::Integer(*value),
                    Argument::Symbol(symbol) => {
                        let at = position(&self.memory.symbols, symbol)?;
                        Value::Symbol(SymbolId(u32::try_from(at).unwrap()))
                    }
                    Argument::Draw(_) => return None,
                };
                let property = position(&self.memory.properties, name)?;
                properties.push((PropertyId(u16::try_from(property).unwrap()), value));
            }
            Some(Observation::new(TypeId(u16::try_from(kind).unwrap()), properties))
        };
        words.iter().filter_map(hear).collect()
    }

    fn observed(&self, until: &NamedObservation, observations: &[Observation]) -> bool {
        observations.iter().any(|o| {
            usize::from(o.kind().0) < self.memory.types.len()
                && self.memory.types[usize::from(o.kind().0)].name == until.kind
                && until.properties.iter().all(|(name, value)| {
                    let value = match value {
                        Argument::Integer(value) => Some(Value::Integer(*value)),
                        Argument::Symbol(symbol) => {
                            let at = self.memory.symbols.iter().position(|known| known == symbol);
                            at.map(|at| Value::Symbol(SymbolId(u32::try_from(at).unwrap())))
                        }
                        Argument::Draw(_) => None,
                    };
                    let property = |at: u16| &self.memory.properties[usize::from(at)];
                    o.properties().iter().any(|(p, v)| property(p.0) == name && Some(*v) == value)
                })
        })
    }

    fn begin_trial(&mut self) -> Demand {
        let pools = &self.memory.curriculum.pools;
        let mut left = self.memory.standing.pools.clone();
        let mut drawn = Vec::new();
        let mut commands = self.stage().arrange.clone();
        for (_, argument) in commands.iter_mut().flat_map(|command| &mut command.arguments) {
            if let Argument::Draw(name) = argument {
                let at = pools.iter().position(|pool| pool.name == *name).unwrap();
                let Some(number) = left[at].pop() else {
                    self.staged(StageEffect::Stuck(String::new()));
                    return Demand::Hold;
                };
                drawn.push((at, number));
                *argument = Argument::Integer(number);
            }
        }
        self.staged(StageEffect::TrialBegun { drawn });
        if commands.is_empty() { Demand::Act } else { Demand::Arrange(commands) }
    }

    /// Schemas made in this stage that can be executed here and are not known well enough.
    pub(crate) fn unhabituated(&self, world: &WorldState, body: BodyId) -> Vec<SchemaId> {
        let Some(rule) = &self.stage().habituation else { return Vec::new() };
        let repertoire = &self.memory.bodies[usize::from(body.0)].1;
        let made = self.executable(world).into_iter().filter(|s| {
            s.created_step >= self.memory.standing.first_step
                && s.action.is_some_and(|action| repertoire.contains(&action))
        });
        let enough = |s: &&Schema| {
            let (low, high) = s.executions.interval();
            s.executions.trials >= rule.executions_min || high - low <= rule.interval_max
        };
        made.filter(|s| !enough(s)).map(|s| s.id).collect()
    }

    /// Counts quiet actions, and ends the trial or stage when it is saturated and habituated to. Returns
    /// whether that alters the choice.
    pub(crate) fn saturate(&mut self, world: &WorldState, body: BodyId, quiet: bool) -> bool {
        let Some(rule) = self.stage().saturation.clone() else { return false };
        let stage = self.stage();
        let ends_otherwise =
            stage.until.is_some() || stage.until_absent.is_some() || stage.trial_actions_max > 0;
        if self.memory.standing.trial_open && ends_otherwise {
            return false;
        }
        let habituating = self.memory.standing.habituating;
        if !habituating {
            self.staged(StageEffect::Quiet(quiet));
            if self.memory.standing.quiet_actions < rule.actions {
                return false;
            }
            self.staged(StageEffect::Saturated);
        }
        if !self.unhabituated(world, body).is_empty() {
            return !habituating;
        }
        if self.memory.standing.trial_open {
            self.end_trial(false);
        }
        if self.memory.standing.trials >= self.stage().trials {
            self.advance();
        }
        true
    }

    /// Obeys an operator.
    pub(crate) fn command(&mut self, command: &StageCommand) -> Result<Vec<Effect>, StageCommandError> {
        self.effects.clear();
        let stages = &self.memory.curriculum.stages;
        match command {
            StageCommand::Hold => self.staged(StageEffect::Held(true)),
            StageCommand::Resume => self.staged(StageEffect::Held(false)),
            StageCommand::Next => {
                let next = self.memory.standing.stage + 1;
                if next >= stages.len() {
                    let name = self.stage().name.clone();
                    return Err(StageCommandError::Last { name });
                }
                self.staged(StageEffect::Ended);
                self.enter(next);
            }
            StageCommand::Set(name) => {
                let Some(at) = stages.iter().position(|stage| stage.name == *name) else {
                    let known = String::new();
                    return Err(StageCommandError::Unknown { name: name.clone(), known });
                };
                self.enter(at);
            }
        }
        Ok(std::mem::take(&mut self.effects))
    }
}
