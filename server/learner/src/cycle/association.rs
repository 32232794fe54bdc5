//! Associated observations (paper, II-B): "seen to occur frequently alongside a schema but neither
//! required for the schema to be executed, nor directly effected by the action taken".

use crate::memory::Memory;
use crate::memory::index::standing;
use crate::memory::instance::Instance;
use crate::nouns::effect::Effect;
use crate::nouns::observation::Observation;
use crate::nouns::probability::Count;
use crate::nouns::schema::{ASSOCIATIONS_MAX, Association, SchemaId};
use crate::nouns::world_state::WorldState;

/// Whether an association of `schema` counts as an associated observation. What is there frequently does; else every
/// bystander would be given attention, which II-C rules out. An event does at once, for one example of a word is
/// enough (VI-B), but only for the schema that it happened alongside most often (of equals the first), and only as long as that is at
/// least half of the times: a word that calls the robot back to one thing must not come to mean whatever it
/// interrupts, nor chatter what it once coincided with. (Chatter that is acted upon still can: what is done about a word
/// confirms it.)
pub(crate) fn is_associated(memory: &Memory, schema: SchemaId, association: &Association) -> bool {
    let Association { observation, count, since_step } = association;
    is_strong(memory, schema, memory.content().observation(*observation), *count, *since_step)
}

fn is_strong(memory: &Memory, schema: SchemaId, observation: &Observation, count: Count, since: u64) -> bool {
    if count.interval().0 >= memory.parameters().association_low_min {
        return true;
    }
    if !memory.rules().of(observation.kind()).transient {
        return false;
    }
    let id = memory.index().id(observation);
    let happened = id.and_then(|id| memory.content().happened.get(id.index())).copied().unwrap_or(0);
    let Some(known) = memory.content().schema(schema) else { return false };
    if count.occurrences.saturating_mul(2) < happened {
        return false;
    }
    let ours = standing(schema, known, count.occurrences, since);
    let other = id.and_then(|event| memory.index().leader_beside(event, schema));
    other.is_none_or(|other| ours < *other)
}

/// The effect that counts the events around an execution; none when there were none.
pub(crate) fn happened(memory: &Memory, before: &WorldState, after: &WorldState) -> Option<Effect> {
    let rules = memory.rules();
    let all = before.observations().iter().chain(after.observations());
    let content = memory.content();
    let counted = |event: &Observation| {
        let id = memory.index().id(event);
        id.and_then(|id| content.happened.get(id.index())).is_some_and(|times| *times > 0)
    };
    let room = |event: &Observation| !content.full || counted(event);
    let events = all.filter(|o| rules.of(o.kind()).transient && !rules.of(o.kind()).own && room(o));
    let events = WorldState::new(events.cloned());
    (!events.observations().is_empty()).then(|| Effect::Happened(events.observations().to_vec()))
}

/// Effects that associate with `schema` what was there for the first time in `around`, before or after its execution.
/// `explained` are the schemas whose conditions account for what was seen.
pub(crate) fn associate(
    memory: &Memory,
    schema: SchemaId,
    explained: &[Option<Instance>],
    around: &WorldState,
) -> Vec<Effect> {
    let content = memory.content();
    if content.full {
        return Vec::new();
    }
    let Some(known) = content.schema(schema).map(|s| &s.associations) else { return Vec::new() };
    let stands = |a: &Association| {
        let strong = is_associated(memory, schema, a);
        (strong, a.count.occurrences, content.observation(a.observation).clone())
    };
    // Mostly nothing is there for the first time, and nobody need know how those that are known stand.
    let mut standing: Option<Vec<(bool, u32, Observation)>> = None;
    let mut effects = Vec::new();
    for observation in around.observations() {
        let is_known = match &standing {
            Some(standing) => standing.iter().any(|(_, _, known)| known == observation),
            None => known.iter().any(|a| content.observation(a.observation) == observation),
        };
        let candidate = !memory.rules().of(observation.kind()).own
            && !explained.iter().flatten().any(|bound| bound.mentions(observation))
            && !is_known;
        if !candidate {
            continue;
        }
        let standing = standing.get_or_insert_with(|| known.iter().map(stands).collect());
        let replaces = (standing.len() >= ASSOCIATIONS_MAX).then(|| weakest(standing)).flatten();
        if let Some(at) = replaces {
            standing.remove(at);
        }
        let strong = is_strong(memory, schema, observation, Count::ONCE, content.step);
        standing.push((strong, 1, observation.clone()));
        effects.push(Effect::Associated { schema, observation: observation.clone(), replaces });
    }
    effects
}

/// The association that makes room: a weak one before a strong one, the rarest, the oldest.
fn weakest(standing: &[(bool, u32, Observation)]) -> Option<usize> {
    (0..standing.len()).min_by_key(|at| (standing[*at].0, standing[*at].1, *at))
}

/// The observations by which `schema` is known, which reads as `bound`: conditions wanted and associated.
pub(crate) fn references<'a>(
    memory: &'a Memory,
    schema: SchemaId,
    bound: &'a Instance,
) -> impl Iterator<Item = &'a Observation> {
    let content = memory.content();
    let associated = content.schema(schema).map_or(&[][..], |s| &s.associations);
    let associated = associated.iter().filter(move |a| is_associated(memory, schema, a));
    let post = bound.post.iter().filter(|p| !p.absent).map(|p| &p.what);
    bound.pre.iter().chain(post).chain(associated.map(|a| content.observation(a.observation)))
}
