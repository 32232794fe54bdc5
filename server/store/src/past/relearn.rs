//! Learning again from the frames of the journal: it must change memory as the journal says it did.

use pschema_learner::decision::Decision;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Memory;
use pschema_learner::progress::StageEffect;
use pschema_learner::{Frame, Learner};

use super::entry;
use crate::extent::Extent;
use crate::format::mirror::{Mirror, list};
use crate::format::v1::{self, Input};
use crate::recovery::Replay;

/// A learner with the memory and under the setting of `replay`, which has no memory until it is given this one back.
pub(super) fn lend(replay: &mut Replay) -> Result<Learner, String> {
    let (parameters, curriculum) = replay.setting.checked().map_err(|error| error.to_string())?;
    let memory = std::mem::replace(&mut replay.memory, Memory::new(0, parameters));
    Learner::resume(memory, curriculum).map_err(|error| error.to_string())
}

/// Has `learner` take one step again. The error says in what the effects differ from `journalled`, or why the step can't be
/// taken.
pub(super) fn step(
    learner: &mut Learner,
    input: Input,
    journalled: &[v1::Effect],
) -> Result<Option<Decision>, String> {
    // An operator may ask for one step while the learner is held: then the learner goes on for this frame alone.
    let single = is_held(journalled.first(), false) && is_held(journalled.last(), true);
    let mut met = Vec::new();
    for effect in journalled.iter().skip(usize::from(single)) {
        // Words that were heard for the first time are met before the step.
        let v1::Effect::SymbolsMet(symbols) = effect else { break };
        for symbol in symbols {
            met.extend(learner.symbol(symbol).1);
        }
    }
    let frame: Frame = input.live();
    Extent::of(learner.memory().content()).frame(&frame).map_err(|error| error.to_string())?;
    let mut step = if single { learner.single_step(&frame) } else { learner.step(&frame) };
    step.effects.splice(usize::from(single)..usize::from(single), met);
    match difference(&list(&step.effects), journalled) {
        None => Ok(step.decision),
        Some(difference) => {
            Err(format!("learning it again does not give what was learnt then: {difference}"))
        }
    }
}

fn is_held(effect: Option<&v1::Effect>, held: bool) -> bool {
    effect.cloned().map(Mirror::live) == Some(Effect::Stage(StageEffect::Held(held)))
}

/// The first difference between two lists of effects; none when they are equal.
fn difference(now: &[v1::Effect], then: &[v1::Effect]) -> Option<String> {
    let at = now.iter().zip(then).position(|(now, then)| now != then);
    let at = at.or((now.len() != then.len()).then_some(now.len().min(then.len())))?;
    let kind = |effects: &[v1::Effect]| {
        effects.get(at).map_or("nothing", |effect| entry::kind(&effect.clone().live()))
    };
    Some(format!("effect {} is {} now and was {} then", at + 1, kind(now), kind(then)))
}
