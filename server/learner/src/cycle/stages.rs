//! Developmental control (paper, II-F): lift a constraint, act, saturate (LCAS). Follows a curriculum; all
//! that it remembers is in [`crate::nouns::progress::Progress`].

use std::sync::Arc;

use crate::memory::draft::Draft;
use crate::memory::{Content, Memory};
use crate::nouns::curriculum::{
    Afterwards, Argument, Curriculum, Lift, NamedObservation, SceneCommand, Stage, Utterance,
};
use crate::nouns::effect::Effect;
use crate::nouns::observation::{Observation, TypeId, Value};
use crate::nouns::progress::{Progress, StageCommand, StageCommandError, StageEffect};
use crate::nouns::vocabulary::{BodyId, Vocabulary};
use crate::nouns::world_state::WorldState;

/// How many schemas of each kind were made in one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Novelty {
    pub(crate) concrete: u32,
    pub(crate) generalised: u32,
    pub(crate) counter_examples: u32,
}

/// The present stage; the last one after the end.
pub(crate) fn present<'a>(memory: &Memory, curriculum: &'a Curriculum) -> &'a Stage {
    let at = memory.content().progress.stage.min(curriculum.stages.len().saturating_sub(1));
    &curriculum.stages[at]
}

/// Whether only an operator can move the curriculum on: it is stuck, or over and says to hold then.
pub(crate) fn is_at_end(progress: &Progress, curriculum: &Curriculum) -> bool {
    progress.stuck.is_some() || (progress.finished && curriculum.afterwards == Afterwards::Hold)
}

/// For each observation type, whether the stage lifts it.
pub(crate) fn lifted(content: &Content, stage: &Stage) -> Vec<bool> {
    let lifts = |name: &String| match &stage.lift {
        Lift::All => true,
        Lift::Types(names) => names.contains(name),
    };
    let types = content.vocabulary.types().iter();
    let mut lifted: Vec<_> = types.map(|kind| lifts(&kind.declared.name)).collect();
    // What is supposed is no sense, and is withheld by none.
    for item in content.items.all.iter() {
        lifted.get_mut(usize::from(item.kind.0)).into_iter().for_each(|lifted| *lifted = true);
    }
    lifted
}

/// Whether `kind` is lifted, by the table of [`lifted`].
pub(crate) fn is_lifted(lifted: &[bool], kind: TypeId) -> bool {
    lifted.get(usize::from(kind.0)).copied().unwrap_or(false)
}

/// Begins the curriculum for `body` if it has not begun.
pub(crate) fn begin(draft: &mut Draft<'_>, curriculum: &Curriculum, body: BodyId) {
    let content = draft.memory().content();
    let known = content.vocabulary.bodies().get(usize::from(body.0));
    // A body that can do nothing has nothing to be led through; it must not keep the place of one that can.
    if content.progress.begun || known.is_none_or(|known| known.repertoire.is_empty()) {
        return;
    }
    let mut random = draft.memory().content().random;
    let pools = curriculum
        .pools
        .iter()
        .map(|pool| {
            // Fisher and Yates; drawn from the end.
            let mut numbers: Vec<i64> = (pool.from..=pool.to).collect();
            for at in (1..numbers.len()).rev() {
                numbers.swap(at, random.below(at + 1));
            }
            numbers
        })
        .collect();
    draft.emit(Effect::Stage(StageEffect::Begun { student: body, pools, random: random.state() }));
    // An operator may have entered a stage before the first frame came.
    if draft.memory().content().progress.reports.is_empty() {
        enter(draft, curriculum, 0);
    }
}

fn enter(draft: &mut Draft<'_>, curriculum: &Curriculum, stage: usize) {
    let name = curriculum.stages[stage].name.clone();
    draft.emit(Effect::Stage(StageEffect::Entered { stage, name }));
}

fn leave(draft: &mut Draft<'_>, curriculum: &Curriculum) {
    draft.emit(Effect::Stage(StageEffect::Ended));
    let next = draft.memory().content().progress.stage.saturating_add(1);
    if next < curriculum.stages.len() {
        enter(draft, curriculum, next);
    } else {
        draft.emit(Effect::Stage(StageEffect::Finished));
    }
}

/// The words of a teacher in this frame of the student, as observations: heard in the very frame that gives the occasion.
pub(crate) fn spoken(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    observations: &[Observation],
) -> Vec<Observation> {
    let progress = &draft.memory().content().progress;
    let stage = present(draft.memory(), curriculum);
    let silent = progress.held || progress.finished || progress.stuck.is_some() || !progress.trial_open;
    if stage.say.is_empty() || silent {
        return Vec::new();
    }
    let mut random = draft.memory().content().random;
    let mut utterances = Vec::new();
    let mut said = Vec::new();
    for (at, utterance) in stage.say.iter().enumerate() {
        let times = progress.said.get(at).copied().unwrap_or(0);
        let vocabulary = &draft.memory().content().vocabulary;
        let occasion = is_occasion(vocabulary, utterance, progress.trial_fresh, observations);
        if occasion && times < utterance.times_max && random.happens(utterance.probability) {
            utterances.push(at);
            said.extend(utterance.heard.get(random.below(utterance.heard.len())));
        }
    }
    let unknown = said.iter().flat_map(|words| &words.properties).filter_map(|(_, value)| match value {
        Argument::Symbol(symbol) => Some(symbol),
        _ => None,
    });
    unknown.for_each(|symbol| draft.meet_symbol(symbol));
    draft.emit(Effect::Stage(StageEffect::Spoken { utterances, random: random.state() }));
    let vocabulary = &draft.memory().content().vocabulary;
    said.into_iter().filter_map(|heard| as_observation(vocabulary, heard)).collect()
}

fn is_occasion(
    vocabulary: &Vocabulary,
    utterance: &Utterance,
    fresh: bool,
    observations: &[Observation],
) -> bool {
    let observed = |what: &NamedObservation| observed(vocabulary, what, observations);
    utterance.when.as_ref().map_or(fresh, observed) && !utterance.unless.as_ref().is_some_and(observed)
}

/// The words heard, if the body has a sense that hears them.
fn as_observation(vocabulary: &Vocabulary, heard: &NamedObservation) -> Option<Observation> {
    let kind = vocabulary.type_named(&heard.kind)?;
    let properties: Option<Vec<_>> = heard
        .properties
        .iter()
        .map(|(name, argument)| Some((vocabulary.property_named(name)?, value(vocabulary, argument)?)))
        .collect();
    Some(Observation::new(kind, properties?))
}

/// The value that an argument is; none of a symbol that was never met, and of a number that is still to be drawn.
fn value(vocabulary: &Vocabulary, argument: &Argument) -> Option<Value> {
    match argument {
        Argument::Integer(number) => Some(Value::Integer(*number)),
        Argument::Symbol(symbol) => vocabulary.symbol_named(symbol).map(Value::Symbol),
        Argument::Draw(_) => None,
    }
}

/// Counts an action of the student and ends the trial if it is over.
pub(crate) fn acted(draft: &mut Draft<'_>, curriculum: &Curriculum, novelty: Novelty, world: &WorldState) {
    let vocabulary = &draft.memory().content().vocabulary;
    let absence = present(draft.memory(), curriculum).until_absent.as_ref();
    let absent = absence.is_some_and(|a| !observed(vocabulary, &a.observation, world.observations()));
    draft.emit(Effect::Stage(StageEffect::Acted {
        concrete_new: novelty.concrete,
        generalised_new: novelty.generalised,
        counter_examples_new: novelty.counter_examples,
        absent,
    }));
    let content = draft.memory().content();
    let (progress, stage) = (&content.progress, present(draft.memory(), curriculum));
    if !progress.trial_open {
        return;
    }
    let met =
        stage.until.as_ref().is_some_and(|until| observed(&content.vocabulary, until, world.observations()));
    let met = met || stage.until_absent.as_ref().is_some_and(|a| progress.absent_actions >= a.actions);
    let used_up = stage.trial_actions_max > 0 && progress.trial_actions >= stage.trial_actions_max;
    if met || used_up {
        let generalised = content.generalised_count;
        draft.emit(Effect::Stage(StageEffect::TrialEnded { met, generalised }));
    }
}

/// The order of the curriculum before anything is chosen.
pub(crate) enum Demand {
    /// Choose freely.
    Free,
    /// Ask the surroundings for this first.
    Arrange(Vec<SceneCommand>),
    /// Wait.
    Hold,
}

/// Moves on from stages that are over, and gives the order to be carried out before choosing.
pub(crate) fn demand(draft: &mut Draft<'_>, curriculum: &Curriculum, student: bool) -> Demand {
    // Each turn ends a stage or returns, so there are no more turns than stages.
    for _ in 0..=curriculum.stages.len() {
        let progress = &draft.memory().content().progress;
        if progress.held || is_at_end(progress, curriculum) {
            return Demand::Hold;
        }
        if !student || progress.finished || progress.trial_open {
            return Demand::Free;
        }
        let stage = present(draft.memory(), curriculum);
        let trials = progress.report().map_or(0, |report| report.trials);
        if trials < stage.trials {
            match arrange(draft, curriculum, stage) {
                // Nothing to arrange: the trial goes on from here.
                Demand::Arrange(commands) if commands.is_empty() => return Demand::Free,
                demand => return demand,
            }
        }
        // With trials that end by saturation, the last one's end is the stage's end.
        let by_trials = stage.trials > 0 && (stage.saturation.is_none() || stage.ends_by_saturation());
        if !by_trials {
            return Demand::Free;
        }
        leave(draft, curriculum);
    }
    Demand::Hold
}

fn arrange(draft: &mut Draft<'_>, curriculum: &Curriculum, stage: &Stage) -> Demand {
    let mut pools = draft.memory().content().progress.pools.clone();
    let mut drawn = Vec::new();
    let mut commands = Vec::new();
    for command in &stage.arrange {
        let mut arguments = Vec::new();
        for (name, argument) in &command.arguments {
            let given = match argument {
                Argument::Draw(pool) => {
                    let at = curriculum.pools.iter().position(|known| known.name == *pool);
                    let number = at.and_then(|at| Some((at, Arc::make_mut(pools.get_mut(at)?).pop()?)));
                    let Some(number) = number else {
                        let reason = format!("pool {pool:?} is used up: widen it, or ask for fewer trials");
                        draft.emit(Effect::Stage(StageEffect::Stuck(reason)));
                        return Demand::Hold;
                    };
                    drawn.push(number);
                    Argument::Integer(number.1)
                }
                given => given.clone(),
            };
            arguments.push((name.clone(), given));
        }
        commands.push(SceneCommand { command: command.command.clone(), arguments });
    }
    draft.emit(Effect::Stage(StageEffect::TrialBegun { drawn }));
    Demand::Arrange(commands)
}

/// Takes account of the top excitation after an action. True when a trial or the stage ended, so that
/// what was to be chosen no longer counts.
pub(crate) fn saturate(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    novelty: Novelty,
    top: impl FnOnce(&Memory) -> f64,
    unhabituated: impl FnOnce(&Memory) -> bool,
) -> bool {
    let progress = &draft.memory().content().progress;
    let stage = present(draft.memory(), curriculum);
    let Some(saturation) = &stage.saturation else { return false };
    if progress.finished || (progress.trial_open && !stage.ends_by_saturation()) {
        return false;
    }
    if !progress.habituating {
        let quiet = novelty == Novelty::default() && top(draft.memory()) < saturation.excitation_below;
        draft.emit(Effect::Stage(StageEffect::Quiet(quiet)));
        if draft.memory().content().progress.quiet_actions < saturation.actions {
            return false;
        }
        draft.emit(Effect::Stage(StageEffect::Saturated));
    }
    if unhabituated(draft.memory()) {
        return false;
    }
    if draft.memory().content().progress.trial_open {
        let generalised = draft.memory().content().generalised_count;
        draft.emit(Effect::Stage(StageEffect::TrialEnded { met: false, generalised }));
    } else {
        leave(draft, curriculum);
    }
    true
}

/// Whether `until` is observed: its type, with at least its properties.
fn observed(vocabulary: &Vocabulary, until: &NamedObservation, observations: &[Observation]) -> bool {
    let Some(kind) = vocabulary.type_named(&until.kind) else { return false };
    let has = |observation: &Observation| {
        until.properties.iter().all(|(name, argument)| {
            let wanted = vocabulary.property_named(name).zip(value(vocabulary, argument));
            wanted.is_some_and(|pair| observation.properties().contains(&pair))
        })
    };
    observations.iter().any(|observation| observation.kind() == kind && has(observation))
}

/// Obeys an operator.
pub(crate) fn command(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    command: &StageCommand,
) -> Result<(), StageCommandError> {
    match command {
        StageCommand::Hold => draft.emit(Effect::Stage(StageEffect::Held(true))),
        StageCommand::Resume => draft.emit(Effect::Stage(StageEffect::Held(false))),
        StageCommand::Next => {
            let progress = &draft.memory().content().progress;
            if progress.finished || progress.stage.saturating_add(1) >= curriculum.stages.len() {
                return Err(StageCommandError::Last {
                    name: present(draft.memory(), curriculum).name.clone(),
                });
            }
            leave(draft, curriculum);
        }
        StageCommand::Set(name) => {
            let Some(at) = curriculum.stages.iter().position(|stage| stage.name == *name) else {
                let known: Vec<_> =
                    curriculum.stages.iter().map(|stage| format!("{:?}", stage.name)).collect();
                return Err(StageCommandError::Unknown { name: name.clone(), known: known.join(", ") });
            };
            enter(draft, curriculum, at);
        }
    }
    Ok(())
}
