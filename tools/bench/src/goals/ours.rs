//! The learner in an environment: a life of its own choices, and episodes with a goal.

use pschema_exact::World;
use pschema_exact::declaration::Observation;
use pschema_exact::tables::Table;
use pschema_learner::ActionOutcome;
use pschema_learner::mechanisms::Mechanisms;
use pschema_tools::kit::Failure;

use super::walk::Walk;
use crate::tasks::student::Student;

/// The learner after a life of so many actions.
pub(crate) fn live(
    table: &Table,
    seed: u64,
    actions: usize,
    mechanisms: Mechanisms,
) -> Result<Student, Failure> {
    let mut student = Student::new(&table.declaration(), seed, false, mechanisms)?;
    let mut walk = Walk::begin(table, seed);
    let mut outcome = None;
    for _ in 0..actions {
        let world = student.lexicon.world_state(&table.percept(&walk.state));
        let chosen = student.perceive(&world, outcome);
        let Some(action) = chosen.and_then(|number| student.lexicon.primitive(number)) else {
            return Err(Failure::Failed(format!("{}: the learner holds still", table.source)));
        };
        walk.act(action.action);
        outcome = Some(ActionOutcome::Done);
        if walk.is_over() {
            // It sees where that led. What it does there is not carried out: the next episode begins.
            let world = student.lexicon.world_state(&table.percept(&walk.state));
            student.perceive(&world, outcome);
            walk.again();
            outcome = Some(ActionOutcome::EpisodeEnded);
        }
    }
    Ok(student)
}

/// Has a copy of the learner pursue `goal`; the number of actions, if the episode succeeds in at most so many.
pub(crate) fn pursue(
    student: &Student,
    walk: &mut Walk<'_>,
    goal: &Observation,
    most: usize,
) -> Result<Option<usize>, Failure> {
    let table = walk.table;
    let mut student = student.twin()?;
    student.pursue(goal, most)?;
    let mut carried_out = false;
    for taken in 1..=most {
        let world = student.lexicon.world_state(&table.percept(&walk.state));
        let chosen = student.step(&world, carried_out);
        if !student.pursues() {
            return Ok(None);
        }
        let Some(action) = chosen.and_then(|number| student.lexicon.primitive(number)) else {
            return Ok(None);
        };
        walk.act(action.action);
        carried_out = true;
        if walk.is_over() {
            return Ok(table.succeeds(walk.state).then_some(taken));
        }
    }
    Ok(None)
}
