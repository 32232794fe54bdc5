//! Steps 2 to 6 of the cycle: score, surprise, create, associate, attend.

use pschema_learner::effect::{Effect, Score};
use pschema_learner::execution::Execution;
use pschema_learner::observation::{Observation, Substitution};
use pschema_learner::probability::Count;
use pschema_learner::schema::{ASSOCIATIONS_MAX, SchemaId};
use pschema_learner::world_state::WorldState;

use super::learner::Reference;
use super::schema::{Schema, put_in};

/// What was not expected.
#[derive(Default)]
pub(crate) struct Surprise {
    pub(crate) appeared: Vec<Observation>,
    pub(crate) vanished: Vec<Observation>,
    pub(crate) missing: bool,
}

/// What one step added to memory, as the curriculum counts it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Made {
    pub(crate) concrete: u32,
    pub(crate) generalised: u32,
    pub(crate) counter_examples: u32,
}

impl Reference {
    /// Steps 2 to 7, after an execution that was carried out.
    pub(crate) fn learn(&mut self, execution: &Execution, after: &WorldState) -> Made {
        let before = &execution.before;
        let context = self.context(before);
        let same = |r: &Self| {
            let mut concrete = r.memory.schemas.iter().filter(|s| s.action == Some(execution.action));
            concrete.find(|s| s.pre(&Substitution::new()) == context).map(|s| s.id)
        };
        let exact = same(self);
        let executed: Vec<(SchemaId, Substitution)> = execution
            .schema
            .map(|s| (s, execution.binding.clone()))
            .into_iter()
            .chain(execution.carrier.map(|r| (r, Substitution::new())))
            .collect();
        let surprise = executed.first().map(|(s, binding)| self.surprise(*s, binding, before, after));
        let exact_surprise = exact.map(|x| self.surprise(x, &Substitution::new(), before, after));
        for (schema, binding) in &executed {
            self.score(*schema, binding, before, after);
        }

        let mut made = Made::default();
        let mut touched = executed.clone();
        let generalised = execution.schema.filter(|s| self.memory.schema(*s).action.is_none());
        let fails = generalised.is_some() && surprise.as_ref().is_some_and(|s| s.missing);
        let unsurprising =
            surprise.as_ref().is_some_and(|s| s.appeared.is_empty() && s.vanished.is_empty() && !fails);
        let mut created = None;
        match (exact, exact_surprise) {
            _ if unsurprising => {}
            (Some(exact), Some(surprise)) => {
                if executed.iter().all(|(schema, _)| *schema != exact) {
                    self.score(exact, &Substitution::new(), before, after);
                    touched.push((exact, Substitution::new()));
                }
                let room = !self.memory.full;
                for observation in surprise.appeared.into_iter().filter(|_| room) {
                    self.emit(Effect::OutcomeAdded { schema: exact, observation, absent: false });
                }
                for observation in surprise.vanished.into_iter().filter(|_| room) {
                    self.emit(Effect::OutcomeAdded { schema: exact, observation, absent: true });
                }
            }
            _ if self.memory.full => {}
            _ => {
                let seen = after.observations().iter().filter(|o| {
                    execution.schema.is_some()
                        || context.contains(o)
                        || !before.contains(o)
                        || self.rules(o.kind()).transient
                });
                let gone = context.iter().filter(|o| !after.contains(o));
                let post = self.post_conditions(seen.cloned().collect(), gone.cloned().collect());
                let contradicts = generalised.filter(|_| fails);
                let id = SchemaId(u32::try_from(self.memory.schemas.len()).unwrap());
                self.emit(Effect::Created {
                    pre: context.clone(),
                    action: execution.action,
                    post,
                    parent: execution.schema,
                    contradicts,
                });
                made.concrete = 1;
                made.counter_examples = u32::from(contradicts.is_some());
                touched.push((id, Substitution::new()));
                created = Some(id);
            }
        }
        let event = |o: &Observation| self.rules(o.kind()).transient && !self.rules(o.kind()).own;
        let counted = |o: &Observation| self.memory.happened.iter().any(|(known, _)| known == o);
        let room = |o: &Observation| !self.memory.full || counted(o);
        let events: Vec<_> = both(before, after).into_iter().filter(event).filter(room).collect();
        if !events.is_empty() {
            self.emit(Effect::Happened(events));
        }
        if !self.memory.full {
            self.associate(&touched, before, after);
        }
        let attending = if executed.is_empty() { &touched } else { &executed };
        self.attend(attending, before, after);
        if let Some(created) = created
            && self.memory.parameters.generalisation
        {
            made.generalised = self.generalise(created);
        }
        if let Some(generalised) = generalised {
            let schema = self.memory.schema(generalised);
            let share_min = self.memory.parameters.generalisation_share_min;
            let examples = u32::try_from(schema.examples.len()).unwrap();
            let Count { occurrences, trials } = schema.executions;
            let rate = Count { occurrences: occurrences + examples, trials: trials + examples };
            if !schema.retired && rate.interval().1 < share_min {
                self.emit(Effect::Retired { generalised });
            }
        }
        made
    }

    fn score(&mut self, id: SchemaId, binding: &Substitution, before: &WorldState, after: &WorldState) {
        let schema = self.memory.schema(id);
        let mut success = true;
        let mut post = Vec::new();
        for condition in &schema.post {
            let what = put_in(&condition.what, binding);
            let seen = if !self.lifted(what.kind()) {
                Score::Constrained
            } else if after.contains(&what) != condition.absent {
                Score::Held
            } else {
                Score::Missed
            };
            let predicted = schema.predicts(condition.count, self.memory.parameters.prediction_ratio_min);
            success &= !(predicted && seen == Score::Missed);
            post.push(seen);
        }
        let associations = schema.associations.iter().map(|(observation, ..)| {
            if !self.lifted(observation.kind()) {
                Score::Constrained
            } else if before.contains(observation) || after.contains(observation) {
                Score::Held
            } else {
                Score::Missed
            }
        });
        let associations = associations.collect();
        self.emit(Effect::Executed { schema: id, success, post, associations });
    }

    fn surprise(
        &self,
        id: SchemaId,
        binding: &Substitution,
        before: &WorldState,
        after: &WorldState,
    ) -> Surprise {
        let schema = self.memory.schema(id);
        let ratio_min = self.memory.parameters.prediction_ratio_min;
        let known = |o: &Observation, absent| schema.outcomes(binding, absent).iter().any(|(k, _)| k == o);
        let appeared = after.observations().iter().filter(|o| {
            let rule = self.rules(o.kind());
            rule.post && (rule.transient || !before.contains(o)) && !known(o, false)
        });
        let vanished =
            self.context(before).into_iter().filter(|o| !after.contains(o) && !known(o, true)).collect();
        let failed = |absent| {
            let predicted = schema.predicted(binding, absent, ratio_min);
            predicted.iter().any(|(o, _)| self.lifted(o.kind()) && after.contains(o) == absent)
        };
        Surprise { appeared: appeared.cloned().collect(), vanished, missing: failed(false) || failed(true) }
    }

    /// Both lists as post-conditions, in canonical order, without what may not be one.
    fn post_conditions(&self, seen: Vec<Observation>, gone: Vec<Observation>) -> Vec<(Observation, bool)> {
        let mut post: Vec<_> =
            seen.into_iter().map(|o| (o, false)).chain(gone.into_iter().map(|o| (o, true))).collect();
        post.retain(|(o, absent)| *absent || self.rules(o.kind()).post);
        post.sort();
        post
    }

    fn associate(&mut self, touched: &[(SchemaId, Substitution)], before: &WorldState, after: &WorldState) {
        let mut conditions = Vec::new();
        for (id, binding) in touched {
            let schema = self.memory.schema(*id);
            conditions.extend(schema.pre(binding));
            conditions.extend(schema.outcomes(binding, false).into_iter().map(|(o, _)| o));
            conditions.extend(schema.outcomes(binding, true).into_iter().map(|(o, _)| o));
        }
        for (id, _) in touched {
            for observation in both(before, after) {
                let known = self.memory.schema(*id).associations.iter().any(|(o, ..)| *o == observation);
                if self.rules(observation.kind()).own || conditions.contains(&observation) || known {
                    continue;
                }
                let replaces = self.room(*id);
                self.emit(Effect::Associated { schema: *id, observation, replaces });
            }
        }
    }

    /// Which association makes room for another, if one must.
    fn room(&self, id: SchemaId) -> Option<usize> {
        let associations = &self.memory.schema(id).associations;
        if associations.len() < ASSOCIATIONS_MAX {
            return None;
        }
        (0..associations.len()).min_by_key(|at| {
            let (observation, count, since) = &associations[*at];
            (self.strong(id, observation, *count, *since), count.occurrences, *at)
        })
    }

    /// Whether an association counts: seen alongside often enough, or an event that came with no schema more often,
    /// nor as often and earlier (of those of one step: a generalised schema first, then by number).
    pub(crate) fn strong(&self, id: SchemaId, observation: &Observation, count: Count, since: u64) -> bool {
        let known = self.memory.happened.iter().find(|(known, _)| known == observation);
        let all = known.map_or(0, |(_, n)| *n);
        let often = 2 * count.occurrences >= all;
        let others = self.memory.schemas.iter().filter(|other| other.id != id);
        let firmer = |other: &Schema| {
            other.associations.iter().any(|(o, n, s)| {
                let rank = |n: Count, since, schema: &Schema| {
                    (std::cmp::Reverse(n.occurrences), since, schema.action.is_some(), schema.id)
                };
                o == observation && rank(*n, *s, other) < rank(count, since, self.memory.schema(id))
            })
        };
        count.interval().0 >= self.memory.parameters.association_low_min
            || self.rules(observation.kind()).transient && often && !others.into_iter().any(firmer)
    }

    fn attend(&mut self, referring: &[(SchemaId, Substitution)], before: &WorldState, after: &WorldState) {
        let refers = |observation: &Observation| {
            referring.iter().any(|(id, binding)| {
                let schema = self.memory.schema(*id);
                schema.pre(binding).contains(observation)
                    || schema.outcomes(binding, false).iter().any(|(o, _)| o == observation)
                    || schema
                        .associations
                        .iter()
                        .any(|(o, n, s)| o == observation && self.strong(*id, o, *n, *s))
            })
        };
        let decays = |o: &Observation| self.memory.parameters.heard_decays || !self.rules(o.kind()).heard;
        let perceived = |o: &Observation| after.contains(o) || !self.rules(o.kind()).transient;
        let perceived = |o: &Observation| perceived(o) && decays(o);
        let room = |o: &Observation| !self.memory.full || self.memory.n(o) > 0;
        let attended: Vec<_> =
            both(before, after).into_iter().filter(|o| perceived(o) && refers(o) && room(o)).collect();
        if !attended.is_empty() && self.memory.parameters.attention {
            self.emit(Effect::Attended(attended));
        }
    }
}

/// W0 ∪ W1 in canonical order.
fn both(before: &WorldState, after: &WorldState) -> Vec<Observation> {
    let all = before.observations().iter().chain(after.observations()).cloned();
    WorldState::new(all).observations().to_vec()
}
