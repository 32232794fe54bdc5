//! Learning once more from what bodies sent: it must change memory as the journal says it did.

use pschema_learner::decision::Decision;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Memory;
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::{StageCommand, StageEffect};
use pschema_learner::{Frame, Learner};

use super::entry;
use super::guarded;
use crate::format::v1::{self, Input};
use crate::recovery::Replay;

/// What came of it.
pub(super) struct Again {
    /// Memory after it.
    pub(super) replay: Replay,
    /// What was decided.
    pub(super) decision: Option<Decision>,
}

/// Puts one frame through a learner that has the memory of `replay`, words that the journal says were met with it first.
/// The error says in what it differs from `journalled`, or what can't be done.
pub(super) fn again(replay: Replay, input: Input, journalled: &[v1::Effect]) -> Result<Again, String> {
    let (_, curriculum) = replay.setting.clone().live().map_err(|error| error.to_string())?;
    let parameters = replay.memory.parameters().clone();
    replay.with_memory(parameters, |memory| {
        guarded(|| {
            let mut learner = Learner::resume(memory, curriculum).map_err(|error| error.to_string())?;
            let decision = step(&mut learner, input, journalled)?;
            Ok((learner.into_memory(), decision))
        })
    })
}

/// One frame through `learner`.
pub(super) fn step(
    learner: &mut Learner,
    input: Input,
    journalled: &[v1::Effect],
) -> Result<Option<Decision>, String> {
    let mut effects = Vec::new();
    // One step that an operator asked for while the learner was held: it went on for this frame alone.
    let single = is_held(journalled.first(), false) && is_held(journalled.last(), true);
    if single {
        effects.extend(learner.stage(&StageCommand::Resume).map_err(|error| error.to_string())?);
    }
    for effect in journalled.iter().skip(usize::from(single)) {
        // Words that were heard for the first time are met before the step.
        let v1::Effect::SymbolsMet(symbols) = effect else { break };
        for symbol in symbols {
            effects.extend(learner.symbol(symbol).1);
        }
    }
    let step = learner.step(&Frame::from(input));
    effects.extend(step.effects);
    if single {
        effects.extend(learner.stage(&StageCommand::Hold).map_err(|error| error.to_string())?);
    }
    let written: Vec<_> = effects.iter().map(v1::Effect::from).collect();
    match difference(&written, journalled) {
        None => Ok(step.decision),
        Some(difference) => {
            Err(format!("learning it again does not give what was learnt then: {difference}"))
        }
    }
}

fn is_held(effect: Option<&v1::Effect>, held: bool) -> bool {
    let live = effect.cloned().and_then(|effect| Effect::try_from(effect).ok());
    live == Some(Effect::Stage(StageEffect::Held(held)))
}

/// The first thing in which two lists of effects differ.
fn difference(now: &[v1::Effect], then: &[v1::Effect]) -> Option<String> {
    let at = now.iter().zip(then).position(|(now, then)| now != then);
    let at = at.or((now.len() != then.len()).then_some(now.len().min(then.len())))?;
    let kind = |effects: &[v1::Effect]| match effects.get(at).cloned().map(Effect::try_from) {
        Some(Ok(effect)) => entry::kind(&effect),
        Some(Err(_)) => "impossible",
        None => "nothing",
    };
    Some(format!("effect {} is {} now and was {} then", at + 1, kind(now), kind(then)))
}

impl Replay {
    /// Has `work` change the memory.
    fn with_memory(
        mut self,
        parameters: Parameters,
        work: impl FnOnce(Memory) -> Result<(Memory, Option<Decision>), String>,
    ) -> Result<Again, String> {
        let memory = std::mem::replace(&mut self.memory, Memory::new(0, parameters));
        let (memory, decision) = work(memory)?;
        self.memory = memory;
        Ok(Again { replay: self, decision })
    }
}
