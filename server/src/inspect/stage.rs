//! How near the present stage is to its end: saturation (paper, II-F), habituation (II-G) and trials.

use pschema_inspect::{HabituationStatus, SaturationStatus, TrialStatus};
use pschema_learner::curriculum::{Habituation, Stage};
use pschema_learner::schema::Schema;
use pschema_learner::world_state::WorldState;

use crate::view::View;

/// The present stage; none once the curriculum is over.
fn present(view: &View) -> Option<&Stage> {
    let progress = &view.content.progress;
    view.setup.curriculum.stages.get(progress.stage).filter(|_| !progress.finished)
}

/// How near the stage is to saturation; none if it does not end so.
pub(super) fn saturation(view: &View) -> Option<SaturationStatus> {
    let rule = present(view)?.saturation.as_ref()?;
    Some(SaturationStatus {
        quiet_actions: view.content.progress.quiet_actions,
        quiet_actions_wanted: rule.actions,
        saturation_below: rule.excitation_below,
    })
}

/// The habituation that the stage asks for; none if it asks for none. It begins only after saturation.
pub(super) fn habituation(view: &View) -> Option<HabituationStatus> {
    let stage = present(view)?;
    let rule = stage.habituation.as_ref().filter(|_| stage.saturation.is_some())?;
    let left = view.content.progress.habituating.then(|| left(view, rule)).flatten();
    Some(HabituationStatus {
        habituation_left: left,
        executions_min: rule.executions_min,
        interval_max: rule.interval_max,
    })
}

/// The number of schemas of the stage that the student can execute here and that are not yet known well enough.
fn left(view: &View, rule: &Habituation) -> Option<u32> {
    let content = &view.content;
    let (body, perceived) = view.perceived()?;
    let known = content.vocabulary.bodies().get(usize::from(body.0))?;
    let first_step = content.progress.report()?.first_step;
    if content.progress.student != Some(body) {
        return None;
    }
    let world = WorldState::new(perceived.iter().cloned());
    let executable = |schema: &Schema| {
        schema.concrete().is_some_and(|concrete| {
            known.repertoire.contains(&concrete.action)
                && world.satisfies(concrete.pre.iter().map(|id| content.observation(*id)))
        })
    };
    let wanting = |schema: &&Schema| {
        schema.created_step >= first_step && rule.wants(schema.executions) && executable(schema)
    };
    u32::try_from(content.schemas.iter().filter(wanting).count()).ok()
}

/// The present trial, or the last one; none if the stage has no trials.
pub(super) fn trial(view: &View) -> Option<TrialStatus> {
    let stage = present(view).filter(|stage| stage.trials > 0)?;
    let progress = &view.content.progress;
    let trial = progress.report().map_or(0, |report| report.trials);
    Some(TrialStatus {
        trial,
        trials_wanted: stage.trials,
        open: progress.trial_open,
        actions: if trial == 0 { 0 } else { progress.trial_actions },
        actions_max: (stage.trial_actions_max > 0).then_some(stage.trial_actions_max),
    })
}
