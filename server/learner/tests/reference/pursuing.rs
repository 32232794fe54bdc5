//! Pursuing goals: every way there is weighed, by what it relies on, in every step that needs a plan.

use std::collections::BTreeMap;

use pschema_learner::ActionOutcome;
use pschema_learner::effect::Effect;
use pschema_learner::execution::{ChainLink, Execution};
use pschema_learner::observation::{Observation, Pattern, Substitution, Term, Value, Variable};
use pschema_learner::plan::CHAINS_WEIGHED_MAX;
use pschema_learner::probability::Count;
use pschema_learner::pursuit::{Ending, Goal, PlanCause, PlanRecord, PursuitEffect};
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::{BodyId, PrimitiveId};
use pschema_learner::world_state::WorldState;

use super::chains::{BINDINGS_MAX, Reached};
use super::learner::Reference;
use super::memory::Memory;
use super::schema::{Schema, put_in};

/// A goal that is pursued, or was the last to be.
#[derive(Clone, Debug)]
pub(crate) struct Pursuit {
    pub(crate) body: BodyId,
    pub(crate) goal: Goal,
    pub(crate) actions_max: u32,
    pub(crate) actions: u32,
    pub(crate) plans_made: u32,
    pub(crate) over: bool,
}

impl Memory {
    pub(crate) fn pursued(&mut self, effect: &PursuitEffect) {
        if let PursuitEffect::Begun { body, goal, actions_max } = effect {
            let (body, goal, actions_max) = (*body, goal.clone(), *actions_max);
            self.pursuit = Some(Pursuit { body, goal, actions_max, actions: 0, plans_made: 0, over: false });
        }
        let pursuit = self.pursuit.as_mut().unwrap();
        match effect {
            PursuitEffect::Begun { .. } => {}
            PursuitEffect::Planned(_) => pursuit.plans_made += 1,
            PursuitEffect::Acted => pursuit.actions += 1,
            // Policies are beyond the paper.
            PursuitEffect::Revised(_) | PursuitEffect::Came(_) => panic!("{effect:?}"),
            PursuitEffect::Ended(_) => pursuit.over = true,
        }
        if matches!(effect, PursuitEffect::Begun { .. } | PursuitEffect::Ended(_))
            && let Some(execution) = &mut self.pending[usize::from(pursuit.body.0)]
        {
            execution.chain.clear();
        }
    }
}

/// Values of variables that make the pattern match, added to those given.
fn matched(
    pattern: &Pattern,
    observation: &Observation,
    mut values: BTreeMap<Variable, Value>,
) -> Option<BTreeMap<Variable, Value>> {
    if pattern.kind() != observation.kind() {
        return None;
    }
    for (property, term) in pattern.terms() {
        let (_, seen) = observation.properties().iter().find(|(known, _)| known == property)?;
        let wanted = match term {
            Term::Constant(value) => *value,
            Term::Variable(variable) => *values.entry(*variable).or_insert(*seen),
        };
        if wanted != *seen {
            return None;
        }
    }
    Some(values)
}

fn fits(goal: &[Pattern], observation: &Observation) -> bool {
    goal.iter().any(|pattern| matched(pattern, observation, BTreeMap::new()).is_some())
}

/// One option for each pattern, so that variables agree: the most probable choice, of equals the first.
fn choose(goal: &[Pattern], options: &[(Observation, f64)]) -> Option<(f64, Vec<usize>)> {
    let mut choices = vec![(Vec::new(), BTreeMap::new())];
    for pattern in goal {
        let mut longer: Vec<(Vec<usize>, _)> = Vec::new();
        for (taken, values) in &choices {
            for (at, (observation, _)) in options.iter().enumerate() {
                if let Some(values) = matched(pattern, observation, values.clone()) {
                    longer.push(([taken.as_slice(), &[at]].concat(), values));
                }
            }
        }
        choices = longer;
    }
    let mut best: Option<(f64, Vec<usize>)> = None;
    for (taken, _) in choices {
        let mut probability = 1.0;
        for (place, at) in taken.iter().enumerate() {
            if !taken[..place].contains(at) {
                probability *= options[*at].1;
            }
        }
        if probability > best.as_ref().map_or(0.0, |(known, _)| *known) {
            best = Some((probability, taken));
        }
    }
    best
}

/// What a schema does to an observation, as far as it was ever seen to do anything: the probability that it
/// holds afterwards.
fn fate(schema: &Schema, binding: &Substitution, observation: &Observation) -> Option<f64> {
    let of = |absent| schema.outcomes(binding, absent).into_iter().find(|(o, _)| o == observation);
    let ratio = |(_, count): (Observation, Count)| count.ratio();
    of(false).map(ratio).or_else(|| of(true).map(|gone| 1.0 - ratio(gone)))
}

impl Reference {
    fn goal_of(&self, body: BodyId) -> Option<Pursuit> {
        self.memory.pursuit.clone().filter(|pursuit| !pursuit.over && pursuit.body == body)
    }

    pub(crate) fn pursues(&self, body: BodyId) -> bool {
        self.goal_of(body).is_some()
    }

    /// Takes a goal up, or calls off what is pursued when there is none; nothing if that can't be.
    pub(crate) fn order(&mut self, order: Option<(BodyId, Goal, u32)>) -> Option<Vec<Effect>> {
        self.effects.clear();
        let busy = self.memory.pursuit.as_ref().is_some_and(|pursuit| !pursuit.over);
        let effect = match order {
            Some((body, goal, actions_max)) => {
                let able = self.memory.bodies.get(usize::from(body.0)).is_some_and(|(_, r)| !r.is_empty());
                let seen = goal.kinds().all(|kind| self.lifted(kind));
                if goal.patterns().is_empty() || !able || busy || self.memory.standing.held || !seen {
                    return None;
                }
                PursuitEffect::Begun { body, goal, actions_max }
            }
            None if busy => PursuitEffect::Ended(Ending::Cancelled),
            None => return None,
        };
        self.emit(Effect::Pursuit(effect));
        Some(std::mem::take(&mut self.effects))
    }

    /// Ends the goal if it holds, or if it is to be given up without trying on.
    pub(crate) fn look(&mut self, body: BodyId, world: &WorldState, decided_in: Option<&WorldState>) {
        let Some(pursuit) = self.goal_of(body) else { return };
        let wanted = pursuit.goal.patterns();
        let brought = match decided_in {
            None => !pursuit.goal.is_again() && self.lasts_in(wanted, world),
            Some(before) => {
                let all: Vec<_> = world.observations().iter().map(|o| (o.clone(), 1.0)).collect();
                choose(wanted, &all).is_some() && !(pursuit.goal.is_again() && self.lasts_in(wanted, before))
            }
        };
        let ending = if !pursuit.goal.kinds().all(|kind| self.lifted(kind)) {
            Ending::Constrained
        } else if brought {
            Ending::Achieved
        } else if pursuit.actions >= pursuit.actions_max {
            Ending::ActionsUsedUp
        } else {
            return;
        };
        self.emit(Effect::Pursuit(PursuitEffect::Ended(ending)));
    }

    /// Whether all of this holds, events left out.
    fn lasts_in(&self, wanted: &[Pattern], world: &WorldState) -> bool {
        let lasting = world.observations().iter().filter(|o| !self.rules(o.kind()).transient);
        let lasting: Vec<_> = lasting.map(|o| (o.clone(), 1.0)).collect();
        choose(wanted, &lasting).is_some()
    }

    /// The next execution for the goal, if one is pursued and something leads there. `outcome` is that of the
    /// execution before, if that was for the goal; `chain` what was left of the plan.
    pub(crate) fn pursue(
        &mut self,
        body: BodyId,
        world: &WorldState,
        outcome: Option<ActionOutcome>,
        chain: &[ChainLink],
    ) -> Option<Execution> {
        let pursuit = self.goal_of(body).filter(|_| !self.memory.standing.held)?;
        let mut next = self.next_in_chain(chain, world);
        if next.is_none()
            && let Some((way, probability)) = self.best_plan(body, world, &pursuit.goal)
        {
            next = self.next_in_chain(&way, world);
            let because = match outcome {
                _ if pursuit.plans_made == 0 => PlanCause::First,
                None | Some(ActionOutcome::EpisodeEnded | ActionOutcome::EpisodeCut) => {
                    PlanCause::Interrupted
                }
                Some(ActionOutcome::Done) if chain.is_empty() => PlanCause::NotReached,
                Some(ActionOutcome::Done) => PlanCause::NextNotAllowed,
                Some(_) => PlanCause::NotCarriedOut,
            };
            let after_actions = pursuit.actions;
            let plan = PlanRecord {
                after_actions,
                because,
                chain: way,
                policy: None,
                probability,
                truncated: false,
            };
            self.emit(Effect::Pursuit(PursuitEffect::Planned(plan)));
        }
        let Some(next) = next else {
            self.emit(Effect::Pursuit(PursuitEffect::Ended(Ending::NothingLeadsThere)));
            return None;
        };
        self.emit(Effect::Pursuit(PursuitEffect::Acted));
        Some(Execution { for_goal: true, ..self.resolve(next, world) })
    }

    /// The most probable way; of equals the shortest, then the one that ends with the oldest schema, then the first.
    fn best_plan(&self, body: BodyId, world: &WorldState, wanted: &Goal) -> Option<(Vec<ChainLink>, f64)> {
        let goal = wanted.patterns();
        let repertoire = &self.memory.bodies[usize::from(body.0)].1;
        let start = self.context(world);
        let mut best: Option<(f64, usize, SchemaId, Vec<ChainLink>)> = None;
        let mut weighed = 0;
        for reached in self.search(repertoire, start.clone()) {
            let is_longer = |length: usize| reached.chain.len() + 1 > length;
            if best.as_ref().is_some_and(|(known, length, ..)| *known >= 1.0 && is_longer(*length)) {
                continue;
            }
            // What is so already is not brought about.
            let there = WorldState::new(reached.context.iter().cloned());
            let there = if reached.chain.is_empty() { world } else { &there };
            if wanted.is_again() && self.lasts_in(goal, there) {
                continue;
            }
            for last in self.lasts(repertoire, &reached, goal) {
                weighed += 1;
                if weighed > CHAINS_WEIGHED_MAX {
                    return best.map(|(probability, _, _, chain)| (chain, probability));
                }
                let id = last.schema;
                let mut chain = reached.chain.clone();
                chain.push(last);
                let Some(probability) = self.weigh(&start, &chain, goal) else { continue };
                let better = best.as_ref().is_none_or(|(known, length, oldest, _)| {
                    probability > *known || (probability == *known && (chain.len(), id) < (*length, *oldest))
                });
                if better {
                    best = Some((probability, chain.len(), id, chain));
                }
            }
        }
        best.map(|(probability, _, _, chain)| (chain, probability))
    }

    /// Schemas that can be executed in a context and have a part in the goal.
    fn lasts(&self, repertoire: &[PrimitiveId], reached: &Reached, goal: &[Pattern]) -> Vec<ChainLink> {
        let ratio_min = self.memory.parameters.prediction_ratio_min;
        let has_part = |schema: &Schema, binding: &Substitution| {
            schema.predicted(binding, false, ratio_min).iter().any(|(o, _)| fits(goal, o))
        };
        let none = Substitution::new();
        let mut found = Vec::new();
        for schema in &self.memory.schemas {
            if schema.action.is_some_and(|action| repertoire.contains(&action))
                && reached.holds(&schema.pre(&none))
                && has_part(schema, &none)
            {
                found.push(ChainLink { schema: schema.id, binding: none.clone(), carrier: None });
            }
        }
        let here = Reached { probability: 1.0, chain: Vec::new(), ..reached.clone() };
        for schema in self.memory.schemas.iter().filter(|s| s.action.is_none() && !s.retired) {
            for binding in schema.bindings(&reached.context, BINDINGS_MAX) {
                if !has_part(schema, &binding) {
                    continue;
                }
                let way = self.achieve(repertoire, schema, &binding, std::slice::from_ref(&here));
                let Some(way) = way else { continue };
                let same = |s: &&Schema| s.action == Some(way.action) && s.pre(&none) == schema.pre(&binding);
                if self.memory.schemas.iter().find(same).is_none() {
                    found.push(ChainLink { schema: schema.id, binding, carrier: Some(way.carrier) });
                }
            }
        }
        found
    }

    /// The probability that the chain brings the goal about.
    fn weigh(&self, start: &[Observation], chain: &[ChainLink], goal: &[Pattern]) -> Option<f64> {
        let ratio_min = self.memory.parameters.prediction_ratio_min;
        // Forwards: where each schema is executed.
        let mut contexts = vec![start.to_vec()];
        for link in &chain[..chain.len() - 1] {
            let schema = self.memory.schema(link.schema);
            let before = contexts.last().unwrap().clone();
            let mut after = before.clone();
            for post in &schema.post {
                let what = put_in(&post.what, &link.binding);
                let predicted = schema.predicts(post.count, ratio_min) && self.rules(what.kind()).pre;
                if predicted && post.absent && before.contains(&what) {
                    after.retain(|o| *o != what);
                } else if predicted && !post.absent && !before.contains(&what) {
                    after.push(what);
                }
            }
            after.sort();
            after.dedup();
            contexts.push(after);
        }
        // Backwards: what each must leave for those after it.
        let mut needed: Vec<Observation> = Vec::new();
        let mut probabilities = Vec::new();
        for (at, link) in chain.iter().enumerate().rev() {
            let schema = self.memory.schema(link.schema);
            let context = &contexts[at];
            let fate = |o: &Observation| fate(schema, &link.binding, o);
            let relied = if at + 1 == chain.len() {
                let caused: Vec<_> = schema
                    .predicted(&link.binding, false, ratio_min)
                    .into_iter()
                    .filter(|(o, _)| fits(goal, o))
                    .map(|(o, count)| (o, count.ratio()))
                    .collect();
                let there = context.iter().filter(|o| fits(goal, o) && !caused.iter().any(|(c, _)| c == *o));
                let there: Vec<_> = there.map(|o| (o.clone(), fate(o).unwrap_or(1.0))).collect();
                let options = [caused, there].concat();
                let mut chosen: Vec<_> =
                    choose(goal, &options)?.1.iter().map(|at| options[*at].0.clone()).collect();
                chosen.sort();
                chosen.dedup();
                needed = chosen.iter().filter(|o| context.contains(o)).cloned().collect();
                chosen
            } else {
                let relied = needed.clone();
                let made = |o: &Observation| {
                    schema.outcomes(&link.binding, false).iter().any(|(known, _)| known == o)
                        && !context.contains(o)
                };
                needed.retain(|o| !made(o));
                relied
            };
            let mut probability = self.carried_through(link);
            for o in &relied {
                probability *= fate(o).unwrap_or(1.0);
            }
            probabilities.push(probability);
            needed.extend(schema.pre(&link.binding));
            if let Some(carrier) = link.carrier {
                needed.extend(self.memory.schema(carrier).pre(&Substitution::new()));
            }
            needed.sort();
            needed.dedup();
        }
        let probability = probabilities.iter().rev().fold(1.0, |product, p| product * p);
        (probability > 0.0).then_some(probability)
    }

    /// The probability that the action is carried out, and that it achieves the target.
    fn carried_through(&self, link: &ChainLink) -> f64 {
        let schema = self.memory.schema(link.schema);
        let carrier = self.memory.schema(link.carrier.unwrap_or(link.schema));
        let mut probability = self.memory.reliability(carrier.action.unwrap());
        for pattern in &schema.target {
            let wanted = put_in(pattern, &link.binding);
            let outcomes = carrier.outcomes(&Substitution::new(), false);
            probability *= outcomes.iter().find(|(o, _)| *o == wanted).unwrap().1.ratio();
        }
        probability
    }
}
