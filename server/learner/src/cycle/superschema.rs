//! Superschemas (Guerin & McKenzie 2008): what no single schema achieves is achieved by several, one after another, each of which achieves
//! a part of it and undoes none. They may be of different classes of actions: one reaches, then another grasps. So a law that was learnt
//! of an action that does both at once serves a body that has no such action.

use crate::cycle::carrier::numbered;
use crate::cycle::chaining::{Access, Achievement, Reach, achieve};
use crate::cycle::search::make;
use crate::memory::Memory;
use crate::nouns::execution::ChainLink;
use crate::nouns::observation::{Observation, Substitution};
use crate::nouns::schema::{Concrete, ObservationId, SchemaId};
use crate::nouns::vocabulary::BodyId;
use crate::nouns::world_state::WorldState;

/// Observations of a target that several schemas may achieve, at most.
const PARTS_MAX: usize = 4;
/// Schemas that are looked at for one part of a target: the oldest, which mostly are the simplest.
const LOOKED_MAX: usize = 32;
/// Schemas that are tried in one search, one after another.
const TRIED_MAX: usize = 1_024;

/// Schemas that achieve a target together; mostly it is a single one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Superschema {
    /// Those before the last, in order; none if the last one achieves all of it.
    pub(crate) before: Vec<SchemaId>,
    /// The last one, with the way to where all of them have been executed but it.
    pub(crate) last: Achievement,
    /// The observations of the target that are there by then: those before the last have achieved them, or they were there from the first.
    pub(crate) held: Vec<Observation>,
}

/// The schemas tried so far, and what they lead to.
#[derive(Clone, Debug)]
struct Course {
    access: Access,
    links: Vec<SchemaId>,
    /// The context that they lead to.
    context: Vec<ObservationId>,
    /// What they have achieved of the target.
    held: Vec<ObservationId>,
    /// What the last one achieved of it.
    newly: Vec<ObservationId>,
    rest: Vec<ObservationId>,
    /// How surely, and how surely all but the last have.
    sure: f64,
    sure_before: f64,
}

impl Superschema {
    /// All of its schemas in order, if there are several; else none.
    pub(crate) fn together(&self) -> Vec<SchemaId> {
        if self.before.is_empty() {
            return Vec::new();
        }
        self.before.iter().copied().chain([self.last.carrier]).collect()
    }

    /// The schemas to be executed before the last one, in order.
    pub(crate) fn chain(&self, reach: &Reach) -> Vec<ChainLink> {
        let mut chain = reach.chain(self.last.access);
        chain.extend(links(&self.before));
        chain
    }
}

/// How a target is achieved in `world`, from where `reach` was searched: by a single schema; or by one that achieves what is not there yet; or
/// else by several.
pub(crate) fn achieved(
    memory: &Memory,
    reach: &Reach,
    body: BodyId,
    target: &[Observation],
    world: &WorldState,
) -> Option<Superschema> {
    if let Some(last) = achieve(memory, reach, body, target) {
        return Some(Superschema { before: Vec::new(), last, held: Vec::new() });
    }
    if !memory.content().mechanisms.superschemas || !(2..=PARTS_MAX).contains(&target.len()) {
        return None;
    }
    rest(memory, reach, body, target, world).or_else(|| superschema(memory, reach, body, target))
}

/// The schema that achieves of a target what is not there yet, and undoes nothing of the rest.
fn rest(
    memory: &Memory,
    reach: &Reach,
    body: BodyId,
    target: &[Observation],
    world: &WorldState,
) -> Option<Superschema> {
    let (held, rest): (Vec<_>, Vec<_>) = target.iter().cloned().partition(|wanted| world.contains(wanted));
    if held.is_empty() || rest.is_empty() {
        return None;
    }
    let last = achieve(memory, reach, body, &rest)?;
    let concrete = memory.content().concrete(last.carrier)?;
    let is_kept = !undoes(memory, concrete, &numbered(memory, &held)?, &numbered(memory, &rest)?);
    is_kept.then_some(Superschema { before: Vec::new(), last, held })
}

/// The surest way to achieve a target by several schemas from where `reach` was searched; of equals the shortest, then that of the
/// oldest schemas. None for a target of one observation.
fn superschema(memory: &Memory, reach: &Reach, body: BodyId, target: &[Observation]) -> Option<Superschema> {
    let parts = numbered(memory, target)?;
    let mut search = Search { memory, reach, body, parts: &parts, tried: 0, best: None };
    search.begin();
    let Course { access, mut links, held, newly, sure_before, .. } = search.best?;
    let carrier = links.pop()?;
    let access = access.after(links.len(), sure_before);
    let held = held.into_iter().filter(|id| !newly.contains(id));
    let held = held.map(|id| memory.content().observation(id).clone()).collect();
    Some(Superschema { before: links, last: Achievement { carrier, access }, held })
}

/// The observations of its target that the carrier of a generalised schema does not bring about: others have by then. None where nothing is
/// known of either.
pub(crate) fn held(memory: &Memory, link: &ChainLink) -> Vec<Observation> {
    let content = memory.content();
    let law = content.generalised(link.schema).filter(|_| content.mechanisms.superschemas);
    let target = law.and_then(|law| law.target_under(&link.binding)).unwrap_or_default();
    let Some(carrier) = link.carrier.and_then(|id| content.concrete(id)) else { return Vec::new() };
    let knows = |wanted: &Observation| {
        carrier.post.iter().any(|post| !post.absent && content.observation(post.what) == wanted)
    };
    target.into_iter().filter(|wanted| !knows(wanted)).collect()
}

/// Whether all of a target that others than its carrier bring about is there.
pub(crate) fn is_held(memory: &Memory, link: &ChainLink, world: &WorldState) -> bool {
    held(memory, link).iter().all(|wanted| world.contains(wanted))
}

/// The links of a chain that executes the schemas before the last.
pub(crate) fn links(before: &[SchemaId]) -> impl Iterator<Item = ChainLink> + '_ {
    before.iter().map(|schema| ChainLink { schema: *schema, binding: Substitution::new(), carrier: None })
}

struct Search<'a> {
    memory: &'a Memory,
    reach: &'a Reach,
    body: BodyId,
    parts: &'a [ObservationId],
    tried: usize,
    best: Option<Course>,
}

impl<'a> Search<'a> {
    fn begin(&mut self) {
        for wanted in self.parts {
            for id in self.causing(*wanted) {
                let way = self.memory.index().outline(id).and_then(|outline| self.reach.way(outline.group));
                let Some(access) = way else { continue };
                let begun = Course {
                    access,
                    links: Vec::new(),
                    context: self.reach.ids(access).to_vec(),
                    held: Vec::new(),
                    newly: Vec::new(),
                    rest: self.parts.to_vec(),
                    sure: 1.0,
                    sure_before: 1.0,
                };
                self.go_on(&begun, id);
            }
        }
    }

    fn causing(&self, wanted: ObservationId) -> impl Iterator<Item = SchemaId> + use<'a> {
        self.memory.index().causing(wanted).iter().take(LOOKED_MAX).copied()
    }

    /// Executes one more schema, if it achieves more of the target where the others lead and undoes nothing of it.
    fn go_on(&mut self, course: &Course, id: SchemaId) {
        let content = self.memory.content();
        let (Some(concrete), Some(outline)) = (content.concrete(id), self.memory.index().outline(id)) else {
            return;
        };
        if self.tried == TRIED_MAX || !content.vocabulary.can_do(self.body, concrete.action) {
            return;
        }
        self.tried += 1;
        let holds = |pre: &ObservationId| course.context.binary_search(pre).is_ok();
        if !concrete.pre.iter().all(holds) || undoes(self.memory, concrete, &course.held, self.parts) {
            return;
        }
        let mut next = Course { sure_before: course.sure, newly: Vec::new(), ..course.clone() };
        next.sure *= content.reliability(concrete.action);
        for post in concrete.post.iter().filter(|post| !post.absent) {
            if course.rest.contains(&post.what) && self.memory.parameters().predicts(post.count) {
                next.sure *= post.count.interval().0;
                next.newly.push(post.what);
            }
        }
        if next.newly.is_empty() {
            return;
        }
        next.held.extend(&next.newly);
        next.rest.retain(|wanted| !next.newly.contains(wanted));
        next.links.push(id);
        outline.changes().for_each(|change| make(&course.context, &mut next.context, change));
        next.context.sort_unstable();
        next.context.dedup();
        if next.rest.is_empty() {
            // One that achieves all of it is no superschema.
            if next.links.len() > 1 && self.best.as_ref().is_none_or(|best| next.beats(best)) {
                self.best = Some(next);
            }
            return;
        }
        for wanted in next.rest.clone() {
            self.causing(wanted).for_each(|id| self.go_on(&next, id));
        }
    }
}

/// Whether a schema undoes something that is `held`: it makes it vanish, or brings about another observation of its type, which may take its
/// place and is not `wanted` as well.
fn undoes(memory: &Memory, concrete: &Concrete, held: &[ObservationId], wanted: &[ObservationId]) -> bool {
    let kind = |id: ObservationId| memory.content().observation(id).kind();
    let replaces = |what: ObservationId| {
        !held.contains(&what) && !wanted.contains(&what) && held.iter().any(|held| kind(*held) == kind(what))
    };
    let mut predicted = concrete.post.iter().filter(|post| memory.parameters().predicts(post.count));
    predicted.any(|post| if post.absent { held.contains(&post.what) } else { replaces(post.what) })
}

impl Course {
    fn beats(&self, other: &Self) -> bool {
        let sure = |one: &Self| one.sure * one.access.probability;
        let shape = |one: &Self| (one.links.len() as u32 + one.access.preceding, one.links.clone());
        match sure(self).total_cmp(&sure(other)) {
            std::cmp::Ordering::Equal => shape(self) < shape(other),
            order => order.is_gt(),
        }
    }
}
