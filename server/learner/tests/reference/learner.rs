//! A learner written straight from `docs/LEARNING.md`: no indexes, no caches, everything searched anew in
//! every step. Slow, and plain enough to be checked by reading.

use std::sync::Arc;

use pschema_learner::curriculum::Curriculum;
use pschema_learner::effect::Effect;
use pschema_learner::execution::{ChainLink, Execution};
use pschema_learner::observation::{Observation, TypeId};
use pschema_learner::parameters::Parameters;
use pschema_learner::vocabulary::Declaration;
use pschema_learner::world_state::WorldState;
use pschema_learner::{ActionOutcome, Frame, Output};

use super::learning::Made;
use super::memory::Memory;
use super::staging::Demand;

/// What observations of a type may be.
#[derive(Clone, Copy)]
pub(crate) struct Rules {
    pub(crate) own: bool,
    pub(crate) transient: bool,
    pub(crate) heard: bool,
    pub(crate) pre: bool,
    pub(crate) post: bool,
}

/// The reference learner.
pub(crate) struct Reference {
    pub(crate) memory: Memory,
    pub(crate) effects: Vec<Effect>,
}

impl Reference {
    pub(crate) fn new(seed: u64, parameters: Parameters, curriculum: Curriculum) -> Self {
        Self { memory: Memory::new(seed, parameters, curriculum), effects: Vec::new() }
    }

    pub(crate) fn declare(&mut self, declaration: Declaration) {
        self.memory.apply(&Effect::Declared(Box::new(declaration)));
    }

    pub(crate) fn emit(&mut self, effect: Effect) {
        self.memory.apply(&effect);
        self.effects.push(effect);
    }

    pub(crate) fn rules(&self, kind: TypeId) -> Rules {
        let declared = &self.memory.types[usize::from(kind.0)];
        let given = self.memory.parameters.type_overrides.iter().find(|o| o.name == declared.name);
        let plain = !(declared.own || declared.transient || declared.heard);
        Rules {
            own: declared.own,
            transient: declared.transient,
            heard: declared.heard,
            pre: given.and_then(|o| o.precondition).unwrap_or(plain),
            post: given.and_then(|o| o.postcondition).unwrap_or(!declared.heard),
        }
    }

    pub(crate) fn context(&self, world: &WorldState) -> Vec<Observation> {
        world.observations().iter().filter(|o| self.rules(o.kind()).pre).cloned().collect()
    }

    pub(crate) fn step(&mut self, frame: &Frame) -> (Output, Vec<Effect>) {
        self.effects.clear();
        let body = frame.body;
        let Some(pending) = self.memory.pending.get(usize::from(body.0)).cloned() else {
            return (Output::Hold, Vec::new());
        };
        self.begin(body);
        let student = self.memory.standing.student == Some(body);
        let heard = if student && !self.pursues(body) { self.spoken(frame) } else { Vec::new() };
        let observations = frame.observations.iter().cloned().chain(heard).collect();
        let frame = &Frame { observations, ..frame.clone() };
        let world = self.world(frame);
        let mut chain = Vec::new();
        let (mut acted, mut decided_in) = (None, None);
        let for_goal = pending.as_ref().is_some_and(|execution| execution.for_goal);
        if pending.is_none() && student {
            self.arranged(frame.outcome);
        }
        // Of what another episode began with, nothing came of what was done.
        let ended = frame.outcome.filter(|outcome| !outcome.begins_episode());
        if let (Some(execution), Some(outcome)) = (pending, ended) {
            let carried_out = outcome == ActionOutcome::Done;
            let learning = self.stage().learning;
            if learning {
                self.emit(Effect::Attempted { primitive: execution.action, carried_out });
            }
            if carried_out {
                let made = if learning { self.learn(&execution, &world) } else { Made::default() };
                acted = Some(made);
                chain = execution.chain;
                decided_in = Some(execution.before);
            }
        }
        let acted = acted.filter(|_| !for_goal);
        if let Some(made) = acted.filter(|_| student) {
            self.acted(made, frame);
        }
        self.look(body, &world, decided_in.as_ref());
        let outcome = frame.outcome.filter(|_| for_goal);
        let (output, pending) = match self.pursue(body, &world, outcome, &chain) {
            Some(execution) => (Output::Act(execution.action), Some(Arc::new(execution))),
            None => self.decide(frame, student, acted, if for_goal { Vec::new() } else { chain }),
        };
        let random = self.memory.random.state();
        self.emit(Effect::StepEnded { body, random, pending });
        (output, std::mem::take(&mut self.effects))
    }

    fn decide(
        &mut self,
        frame: &Frame,
        student: bool,
        mut acted: Option<Made>,
        mut chain: Vec<ChainLink>,
    ) -> (Output, Option<Arc<Execution>>) {
        let repertoire = self.memory.bodies[usize::from(frame.body.0)].1.clone();
        let stage = (self.memory.standing.stage, self.memory.standing.finished);
        loop {
            match self.demand(student) {
                Demand::Hold => return (Output::Hold, None),
                Demand::Arrange(commands) => return (Output::Arrange(commands), None),
                Demand::Act => {}
            }
            if (self.memory.standing.stage, self.memory.standing.finished) != stage {
                chain.clear();
            }
            let world = self.world(frame);
            let next = self.next_in_chain(&chain, &world);
            let drive = if self.memory.standing.habituating {
                self.unhabituated(&world, frame.body)
            } else {
                Vec::new()
            };
            let candidates = self.candidates(&repertoire, &world, &drive);
            let top = candidates.iter().map(|c| c.excitation).fold(0.0, f64::max);
            if let Some(made) = acted.filter(|_| student && !self.memory.standing.finished)
                && let Some(rule) = self.stage().saturation.clone()
            {
                let quiet = made.concrete + made.generalised == 0 && top < rule.excitation_below;
                if self.saturate(&world, frame.body, quiet) {
                    acted = None;
                    continue;
                }
            }
            let Some(chosen) = next.or_else(|| self.choose(&candidates)) else { return (Output::Hold, None) };
            let execution = self.resolve(chosen, &world);
            return (Output::Act(execution.action), Some(Arc::new(execution)));
        }
    }
}
