//! The digest of a memory: equal digests are equal memories.

use crate::memory::chunks::ChunkDigest;
use crate::memory::content::Content;
use crate::memory::evidence::{
    Beginnings, Found, FoundClaim, FoundClaims, FoundEach, FoundFacet, FoundPlace, FoundTrial, OwnEffect,
    Recollection,
};
use crate::nouns::claim::{Change, Condition, Expression, Reference, Sketch};
use crate::nouns::execution::{ChainLink, Execution};
use crate::nouns::experience::{Experience, Recalled};
use crate::nouns::item::{Item, Items, Update};
use crate::nouns::mechanisms::Mechanisms;
use crate::nouns::observation::{Observation, Pattern, Substitution, Term, Value};
use crate::nouns::policy::Policy;
use crate::nouns::probability::Count;
use crate::nouns::pursuit::{Ending, Goal, PlanCause};
use crate::nouns::schema::{Form, ObservationId, PostCondition, Schema, SchemaId};
use crate::nouns::vocabulary::Parameter;

/// Version of what is digested and how; part of the digest.
const VERSION: u32 = 2;

/// The blake3 digest of everything that decides what the learner does next, in hexadecimal.
#[must_use]
pub fn digest(content: &Content) -> String {
    let mut sink = Sink(blake3::Hasher::new());
    sink.number(u64::from(VERSION));
    vocabulary(&mut sink, content);
    schemas_and_observations(&mut sink, content);
    content.attempts.iter().for_each(|attempts| count(&mut sink, *attempts));
    sink.number(content.random.state());
    sink.number(content.step);
    for pending in &content.pending {
        sink.list(usize::from(pending.is_some()));
        if let Some(pending) = pending {
            execution(&mut sink, pending);
        }
    }
    progress(&mut sink, content);
    pursuit(&mut sink, content);
    // A memory that has room has the digest that it had before there was a limit.
    if content.full {
        sink.flag(true);
    }
    // A memory that does nothing beyond the paper has the digest that it had before it could.
    if content.mechanisms != Mechanisms::PAPER || !content.evidence.is_empty() {
        for (name, on) in content.mechanisms.named() {
            sink.text(name);
            sink.flag(on);
        }
        for (pool, one) in content.evidence.kept() {
            sink.number(pool.map_or(0, |action| action as u64 + 1));
            experience(&mut sink, one);
        }
        for (body, recollections) in content.evidence.recollections() {
            sink.number(u64::from(body.0));
            sink.number(recollections.noted());
            for Recollection { shown, noted, there } in recollections.all() {
                observation(&mut sink, &shown);
                sink.number(noted);
                sink.each(&there, observation);
            }
        }
        for (body, Beginnings { is_next, learnable: (all, count) }) in content.evidence.beginnings() {
            sink.number(u64::from(body.0));
            sink.flag(*is_next);
            [all, count].iter().for_each(|number| sink.number(number.to_bits()));
        }
    }
    // And one that supposes nothing the one that it had before it could.
    if !content.items.is_empty() {
        items(&mut sink, &content.items);
    }
    sink.0.finalize().to_hex().to_string()
}

/// The digests of what was found of the experiences that are kept, pool by pool.
#[must_use]
pub fn claims(content: &Content) -> Vec<String> {
    content.evidence.found().map(|(_, one)| found(&one)).collect()
}

/// The blake3 digest of what was found of the experiences of a pool, in hexadecimal. It is no part of the digest of memory: claims follow
/// from the experiences, and a memory that was written without them has the same one.
#[must_use]
pub fn found(found: &Found) -> String {
    let mut sink = Sink(blake3::Hasher::new());
    sink.number(u64::from(VERSION));
    sink.each(&found.effects, |sink, OwnEffect { primitive, brought, doubtful }| {
        sink.number(u64::from(primitive.0));
        sink.flag(brought.is_some());
        if let Some((effect, tries)) = brought {
            sink.each(effect, observation);
            sink.list(*tries);
        }
        sink.flag(*doubtful);
    });
    sink.number(found.key.map_or(0, |key| u64::from(key.0) + 1));
    sink.each(&found.facets, facet);
    sink.0.finalize().to_hex().to_string()
}

fn facet(sink: &mut Sink, facet: &FoundFacet) {
    let FoundFacet { kinds, changes, surprise, grown, places, each, trial } = facet;
    sink.each(kinds, |sink, kind| sink.number(u64::from(kind.0)));
    sink.each(changes, |sink, Change { becomes, vanishes, appears }| {
        for sketches in [becomes, vanishes, appears] {
            sink.each(sketches, sketch);
        }
    });
    sink.each(surprise, |sink, number| sink.number(number.to_bits()));
    sink.each(grown, |sink, FoundClaims { primitive, scores, examples, exceptional, unforetold, claims }| {
        sink.number(primitive.map_or(0, |primitive| u64::from(primitive.0) + 1));
        sink.each(scores.as_slice(), |sink, scores| {
            sink.each(scores, |sink, score| sink.number(score.to_bits()));
        });
        for count in [examples, exceptional, unforetold] {
            sink.list(*count);
        }
        sink.each(claims, |sink, FoundClaim { depth, condition: asked, gain, outcomes, trials }| {
            sink.list(*depth);
            sink.each(asked.as_slice(), condition);
            sink.number(gain.to_bits());
            sink.each(outcomes, |sink, (change, count)| {
                sink.list(*change);
                sink.number(u64::from(*count));
            });
            sink.number(u64::from(*trials));
        });
    });
    sink.each(places, |sink, place| {
        sink.each(place.as_slice(), |sink, FoundPlace { claim, change }| {
            sink.list(*claim);
            sink.each(change.as_slice(), |sink, change| sink.list(*change));
        });
    });
    sink.each(each.as_slice(), of_each);
    sink.each(trial.as_slice(), |sink, FoundTrial { each, scores }| {
        of_each(sink, each);
        sink.each(scores, |sink, score| sink.number(score.to_bits()));
    });
}

fn of_each(sink: &mut Sink, FoundEach { from, known, facet: found }: &FoundEach) {
    sink.list(*from);
    sink.each(known, observation);
    facet(sink, found);
}

fn condition(sink: &mut Sink, condition: &Condition) {
    match condition {
        Condition::Observed(observed) => {
            sink.number(0);
            sketch(sink, observed);
        }
        Condition::Is(anchor, is) => {
            sink.number(1);
            reference(sink, (*anchor).into());
            value(sink, *is);
        }
        Condition::AtLeast(anchor, least) => {
            sink.number(2);
            reference(sink, (*anchor).into());
            sink.number(least.cast_unsigned());
        }
        Condition::Recalled(recalled) => {
            sink.number(3);
            sketch(sink, recalled);
        }
    }
}

fn sketch(sink: &mut Sink, sketch: &Sketch) {
    sink.number(u64::from(sketch.kind.0));
    sink.each(&sketch.properties, |sink, (property, expression)| {
        sink.number(u64::from(property.0));
        match expression {
            Expression::Constant(constant) => value(sink, *constant),
            Expression::Named(named, more) => {
                sink.number(4);
                reference(sink, *named);
                sink.number(more.cast_unsigned());
            }
        }
    });
}

fn reference(sink: &mut Sink, reference: Reference) {
    let (tag, [kind, property]) = match reference {
        Reference::Parameter(at) => (0, [0, u64::from(at)]),
        Reference::Effect(kind, property) => (1, [u64::from(kind.0), u64::from(property.0)]),
        Reference::Only(kind, property) => (2, [u64::from(kind.0), u64::from(property.0)]),
        Reference::Itself(property) => (4, [0, u64::from(property.0)]),
        Reference::Recalled(kind, property) => (5, [u64::from(kind.0), u64::from(property.0)]),
        Reference::Age => (6, [0, 0]),
        Reference::Tied { from, kind, at, to } => {
            sink.number(3);
            self::reference(sink, from.into());
            (u64::from(kind.0), [u64::from(at.0), u64::from(to.0)])
        }
    };
    [tag, kind, property].into_iter().for_each(|number| sink.number(number));
}

fn items(sink: &mut Sink, items: &Items) {
    sink.each(&items.all, |sink, item| {
        let Item { kind, property, primitive, kinds, updates, dropped } = item;
        sink.number(u64::from(kind.0));
        sink.number(u64::from(property.0));
        sink.number(u64::from(primitive.0));
        sink.each(kinds, |sink, kind| sink.number(u64::from(kind.0)));
        sink.each(updates, |sink, (event, update)| {
            sink.number(u64::from(event.primitive.0));
            sink.each(&event.after, observation);
            sink.number(match update {
                Update::On => 0,
                Update::Off => 1,
                Update::Turn => 2,
            });
        });
        sink.flag(*dropped);
    });
    sink.each(&items.lines, |sink, line| {
        sink.each(&line.on, |sink, on| sink.flag(*on));
        sink.list(line.recent.len());
        line.recent.iter().for_each(|one| experience(sink, one));
        sink.number(line.taken);
    });
}

/// Claims follow from the experiences, in their order.
fn experience(sink: &mut Sink, experience: &Experience) {
    sink.number(u64::from(experience.primitive.0));
    sink.each(&experience.parameters, |sink, parameter| {
        sink.flag(parameter.is_some());
        parameter.iter().for_each(|known| value(sink, *known));
    });
    sink.each(&experience.before, observation);
    sink.each(&experience.after, observation);
    sink.each(&experience.sensed, |sink, kind| sink.number(u64::from(kind.0)));
    sink.number(u64::from(experience.body.0));
    sink.each(experience.recalled.as_slice(), |sink, Recalled { observations, age }| {
        sink.each(observations, observation);
        sink.number(u64::from(*age));
    });
}

/// The lists that grow: the digests of their chunks, which they remember, so that this costs what changed.
fn schemas_and_observations(sink: &mut Sink, content: &Content) {
    let Content { schemas, observations, attention, happened, .. } = content;
    sink.list(schemas.len());
    let one = |sink: &mut Sink, schema: &Schema| self::schema(sink, content, schema);
    schemas.digests(|chunk| chunk_digest(chunk, one)).for_each(|digest| sink.bytes(&digest));
    sink.list(observations.len());
    observations.digests(|chunk| chunk_digest(chunk, observation)).for_each(|digest| sink.bytes(&digest));
    for counts in [attention, happened] {
        let one = |sink: &mut Sink, count: &u32| sink.number(u64::from(*count));
        counts.digests(|chunk| chunk_digest(chunk, one)).for_each(|digest| sink.bytes(&digest));
    }
}

fn chunk_digest<T>(chunk: &[T], one: impl Fn(&mut Sink, &T)) -> ChunkDigest {
    let mut sink = Sink(blake3::Hasher::new());
    sink.list(chunk.len());
    chunk.iter().for_each(|item| one(&mut sink, item));
    *sink.0.finalize().as_bytes()
}

struct Sink(blake3::Hasher);

impl Sink {
    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }
    fn number(&mut self, number: u64) {
        self.bytes(&number.to_le_bytes());
    }
    fn list(&mut self, len: usize) {
        self.number(len as u64);
    }
    /// A list: how many items it has, then each of them.
    fn each<'a, T: 'a>(&mut self, items: &'a [T], one: impl Fn(&mut Self, &'a T)) {
        self.list(items.len());
        items.iter().for_each(|item| one(self, item));
    }
    fn text(&mut self, text: &str) {
        self.list(text.len());
        self.bytes(text.as_bytes());
    }
    fn flag(&mut self, flag: bool) {
        self.number(u64::from(flag));
    }
    fn id(&mut self, id: Option<SchemaId>) {
        self.number(id.map_or(0, |id| u64::from(id.0) + 1));
    }
}

fn vocabulary(sink: &mut Sink, content: &Content) {
    let vocabulary = &content.vocabulary;
    sink.each(vocabulary.types(), |sink, kind| {
        sink.text(&kind.declared.name);
        for flag in [kind.declared.own, kind.declared.transient, kind.declared.heard] {
            sink.flag(flag);
        }
        // A type that is no value has the digest that it had before there were any.
        if kind.declared.value {
            sink.flag(true);
        }
        sink.each(&kind.properties, |sink, property| sink.number(u64::from(property.0)));
    });
    for names in [vocabulary.properties(), vocabulary.symbols()] {
        sink.each(names, |sink, name| sink.text(name));
    }
    sink.each(vocabulary.primitives(), |sink, primitive| {
        sink.text(&vocabulary.actions()[primitive.action].name);
        for parameter in &primitive.parameters {
            match parameter {
                Parameter::Integer(value) => sink.number(value.cast_unsigned()),
                Parameter::Symbol(symbol) => sink.text(symbol),
                Parameter::Boolean(value) => sink.flag(*value),
                Parameter::Real(value) => sink.number(value.to_bits()),
            }
        }
    });
    for body in vocabulary.bodies() {
        sink.text(&body.name);
        sink.each(&body.repertoire, |sink, primitive| sink.number(u64::from(primitive.0)));
    }
}

fn value(sink: &mut Sink, value: Value) {
    let (tag, bits) = match value {
        Value::Integer(value) => (0, value.cast_unsigned()),
        Value::Symbol(symbol) => (1, u64::from(symbol.0)),
        Value::Boolean(value) => (2, u64::from(value)),
        Value::Bin(bin) => (3, bin.cast_unsigned()),
    };
    sink.number(tag);
    sink.number(bits);
}

fn observation(sink: &mut Sink, observation: &Observation) {
    sink.number(u64::from(observation.kind().0));
    sink.each(observation.properties(), |sink, (property, seen)| {
        sink.number(u64::from(property.0));
        value(sink, *seen);
    });
}

fn pattern(sink: &mut Sink, pattern: &Pattern) {
    sink.number(u64::from(pattern.kind().0));
    sink.each(pattern.terms(), |sink, (property, term)| {
        sink.number(u64::from(property.0));
        match term {
            Term::Constant(constant) => value(sink, *constant),
            Term::Variable(variable) => {
                sink.number(4);
                sink.number(u64::from(variable.0));
            }
        }
    });
}

fn count(sink: &mut Sink, count: Count) {
    sink.number(u64::from(count.occurrences));
    sink.number(u64::from(count.trials));
}

fn schema(sink: &mut Sink, content: &Content, schema: &Schema) {
    match &schema.form {
        Form::Concrete(concrete) => {
            sink.number(0);
            let known = |sink: &mut Sink, id: &ObservationId| observation(sink, content.observation(*id));
            sink.each(&concrete.pre, known);
            sink.number(u64::from(concrete.action.0));
            sink.each(&concrete.post, |sink, post| post_condition(sink, post, known));
            sink.id(concrete.contradicts);
        }
        Form::Generalised(generalised) => {
            sink.number(1);
            sink.each(&generalised.pre, pattern);
            sink.each(&generalised.target, pattern);
            sink.each(&generalised.post, |sink, post| post_condition(sink, post, pattern));
            for ids in [&generalised.examples, &generalised.counter_examples] {
                sink.each(ids, |sink, id| sink.id(Some(*id)));
            }
            sink.flag(generalised.retired);
        }
    }
    count(sink, schema.executions);
    sink.each(&schema.associations, |sink, association| {
        observation(sink, content.observation(association.observation));
        count(sink, association.count);
        sink.number(association.since_step);
    });
    sink.id(schema.parent);
    sink.number(schema.created_step);
}

fn post_condition<T>(sink: &mut Sink, post: &PostCondition<T>, what: impl Fn(&mut Sink, &T)) {
    what(sink, &post.what);
    sink.flag(post.absent);
    count(sink, post.count);
}

fn substitution(sink: &mut Sink, substitution: &Substitution) {
    sink.each(substitution.bindings(), |sink, (variable, bound)| {
        sink.number(u64::from(variable.0));
        value(sink, *bound);
    });
}

fn execution(sink: &mut Sink, execution: &Execution) {
    sink.id(execution.schema);
    substitution(sink, &execution.binding);
    sink.id(execution.carrier);
    sink.number(u64::from(execution.action.0));
    sink.each(execution.before.observations(), observation);
    sink.each(&execution.chain, link);
    sink.flag(execution.for_goal);
}

fn link(sink: &mut Sink, link: &ChainLink) {
    sink.id(Some(link.schema));
    substitution(sink, &link.binding);
    sink.id(link.carrier);
}

fn pursuit(sink: &mut Sink, content: &Content) {
    sink.flag(content.pursuit.is_some());
    let Some(pursuit) = &content.pursuit else { return };
    sink.number(pursuit.number);
    sink.number(u64::from(pursuit.body.0));
    sink.each(pursuit.goal.patterns(), pattern);
    // A goal that is to be observed has the digest that it had before there were others.
    match &pursuit.goal {
        Goal::Observed(_) => (),
        Goal::Again(_) => sink.flag(true),
        Goal::Most(kind) => {
            sink.number(u64::from(kind.0));
            sink.number(pursuit.came.to_bits());
        }
    }
    for number in [pursuit.actions_max, pursuit.actions, pursuit.plans_made] {
        sink.number(u64::from(number));
    }
    sink.each(&pursuit.plans, |sink, plan| {
        sink.number(u64::from(plan.after_actions));
        sink.number(match plan.because {
            PlanCause::First => 0,
            PlanCause::NotReached => 1,
            PlanCause::NextNotAllowed => 2,
            PlanCause::NotCarriedOut => 3,
            PlanCause::Interrupted => 4,
        });
        sink.each(&plan.chain, link);
        sink.number(plan.probability.to_bits());
        sink.flag(plan.truncated);
        // A plan that is none has the digest that it had before there were any.
        if let Some(found) = &plan.policy {
            policy(sink, found);
        }
    });
    sink.number(match pursuit.ended {
        None => 0,
        Some(Ending::Achieved) => 1,
        Some(Ending::NothingLeadsThere) => 2,
        Some(Ending::ActionsUsedUp) => 3,
        Some(Ending::Constrained) => 4,
        Some(Ending::Cancelled) => 5,
        Some(Ending::FurtherThanLooked) => 6,
        Some(Ending::NothingBringsAny) => 7,
    });
}

fn policy(sink: &mut Sink, policy: &Policy) {
    for kinds in [&policy.kinds, &policy.chance] {
        sink.each(kinds, |sink, kind| sink.number(u64::from(kind.0)));
    }
    sink.each(&policy.circumstances, observation);
    sink.each(&policy.rows, |sink, row| {
        sink.each(&row.context, observation);
        sink.number(u64::from(row.action.0));
        sink.number(row.probability.to_bits());
        sink.each(&row.leads, |sink, lead| {
            sink.number(lead.to.map_or(0, |to| u64::from(to) + 1));
            sink.number(lead.probability.to_bits());
        });
    });
    for one in &policy.yields {
        [one.worth, one.brings].iter().for_each(|number| sink.number(number.to_bits()));
    }
    sink.number(policy.actions.to_bits());
    sink.number(u64::from(policy.after_actions));
}

fn progress(sink: &mut Sink, content: &Content) {
    let progress = &content.progress;
    sink.number(progress.student.map_or(0, |body| u64::from(body.0) + 1));
    let drawn = |sink: &mut Sink, number: &i64| sink.number(number.cast_unsigned());
    let counted = |sink: &mut Sink, number: &u32| sink.number(u64::from(*number));
    sink.each(&progress.pools, |sink, pool| sink.each(pool, drawn));
    sink.list(progress.stage);
    for flag in [progress.begun, progress.finished, progress.held, progress.trial_open, progress.habituating]
    {
        sink.flag(flag);
    }
    sink.flag(progress.trial_fresh);
    sink.number(u64::from(progress.absent_actions));
    sink.each(&progress.said, counted);
    sink.text(progress.stuck.as_deref().unwrap_or(""));
    sink.number(u64::from(progress.trial_actions));
    sink.number(u64::from(progress.quiet_actions));
    sink.each(&progress.reports, |sink, report| {
        sink.text(&report.name);
        sink.number(report.first_step);
        sink.number(report.actions);
        for number in [
            report.concrete_new,
            report.generalised_new,
            report.counter_examples_new,
            report.trials,
            report.trials_met,
            report.trials_met_first,
        ] {
            sink.number(u64::from(number));
        }
        sink.each(&report.generalised_after_trial, counted);
        sink.each(&report.actions_of_trial, counted);
        sink.each(&report.drawn, drawn);
        sink.flag(report.saturated);
        sink.flag(report.ended);
    });
}
