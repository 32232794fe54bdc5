//! Pursuing a goal: the plan is followed, made anew when it has to be, and ends with a reason; the curriculum
//! takes no notice.

// A test may stop at what cannot be.
#![allow(clippy::unwrap_used)]

mod common;

use common::{OBJECT, Table, exp1_s1, finger, free, object, touch};
use pschema_learner::curriculum::Curriculum;
use pschema_learner::decision::Reason;
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Memory;
use pschema_learner::notation::parse_goal;
use pschema_learner::observation::{Observation, Pattern};
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::StageCommand;
use pschema_learner::pursuit::GOAL_PATTERNS_MAX;
use pschema_learner::pursuit::{Ending, GOAL_ACTIONS_MAX, Goal, PlanCause, PursueError, Pursuit};
use pschema_learner::{ActionOutcome, Frame, Output, Step};

/// A blue block on a row of fields. Action `n` pushes it from one field to another, whatever `pushes[n]` says.
struct Row {
    table: Table,
    block: i64,
    pushes: Vec<(i64, i64)>,
    outcome: Option<ActionOutcome>,
    effects: Vec<Effect>,
}

impl Row {
    /// Learns all pushes by playing, the block put back to field 0 every now and then.
    fn new(pushes: &[(i64, i64)]) -> Self {
        let table = Table::new(5, pushes.len() as i64, 0, free(), Parameters::default());
        let mut row = Self { table, block: 0, pushes: pushes.to_vec(), outcome: None, effects: Vec::new() };
        for step in 0..60 * pushes.len() as i64 {
            row.step(|_, _| ActionOutcome::Done);
            if step % 5 == 4 {
                row.put((step / 5) % pushes.len() as i64);
            }
        }
        row.put(0);
        row
    }

    fn put(&mut self, field: i64) {
        (self.block, self.outcome) = (field, None);
    }

    /// One step; the outcome of what it asks for is as `happens` says, given the action and where the block is.
    fn step(&mut self, happens: impl FnOnce(usize, i64) -> ActionOutcome) -> Step {
        let observations = vec![object(1, self.block)];
        let frame = Frame { body: self.table.body, outcome: self.outcome.take(), observations };
        let step = self.table.learner.step(&frame);
        self.effects.extend(step.effects.clone());
        if let Output::Act(action) = step.output {
            let action = action.0 as usize;
            let outcome = happens(action, self.block);
            let (from, to) = self.pushes[action];
            if outcome == ActionOutcome::Done && self.block == from {
                self.block = to;
            }
            self.outcome = Some(outcome);
        }
        step
    }

    fn goal(&self, patterns: &[&str]) -> Vec<Pattern> {
        goal(&self.table, patterns)
    }

    fn pursue(&mut self, patterns: &[&str], actions_max: u32) {
        let goal = self.goal(patterns);
        let effects = self.table.learner.pursue(self.table.body, goal, actions_max).unwrap();
        self.effects.extend(effects);
    }

    /// Steps until the goal is pursued no more.
    fn until_ended(&mut self, mut happens: impl FnMut(usize, i64) -> ActionOutcome) -> Vec<Step> {
        let mut steps = Vec::new();
        while self.pursuit().under_way() {
            steps.push(self.step(&mut happens));
            assert!(steps.len() < 1000, "it never ends: {:?}", self.pursuit());
        }
        steps
    }

    fn pursuit(&self) -> &Pursuit {
        pursuit(&self.table)
    }
}

fn goal(table: &Table, patterns: &[&str]) -> Vec<Pattern> {
    let patterns: Vec<_> = patterns.iter().map(|text| (*text).to_owned()).collect();
    parse_goal(&table.learner.memory().content().vocabulary, &patterns).unwrap()
}

fn pursuit(table: &Table) -> &Pursuit {
    table.learner.memory().content().pursuit.as_ref().unwrap()
}

fn reasons(pursuit: &Pursuit) -> Vec<PlanCause> {
    pursuit.plans.iter().map(|plan| plan.because).collect()
}

fn done(_: usize, _: i64) -> ActionOutcome {
    ActionOutcome::Done
}

const SHELF: [(i64, i64); 3] = [(0, 1), (1, 2), (2, 3)];

#[test]
fn a_chain_of_three_is_followed_to_the_goal_and_explained() {
    let mut row = Row::new(&SHELF);
    row.pursue(&["object{colour=blue, field=3}"], 10);
    let steps = row.until_ended(done);
    let pursuit = row.pursuit();
    assert_eq!((pursuit.ended, pursuit.actions), (Some(Ending::Achieved), 3));
    assert_eq!(reasons(pursuit), [PlanCause::First]);
    let acted: Vec<_> = steps[..3].iter().map(|step| step.output.clone()).collect();
    assert!(acted.iter().zip(0..).all(|(output, at)| matches!(output, Output::Act(p) if p.0 == at)));
    for (at, step) in steps[..3].iter().enumerate() {
        let decision = step.decision.as_ref().unwrap();
        let goal = decision.goal.as_ref().expect("the goal is the reason");
        assert_eq!((decision.reason, goal.at, goal.chain.len()), (Reason::Goal, at, 3));
        assert!(goal.probability > 0.5 && goal.probability <= 1.0);
    }
    assert_ne!(steps[3].decision.as_ref().map(|d| d.reason), Some(Reason::Goal), "afterwards it plays");
}

#[test]
fn a_step_whose_outcome_does_not_allow_the_next_leads_to_a_new_plan() {
    let mut row = Row::new(&SHELF);
    row.pursue(&["object{field=3}"], 10);
    // Someone puts the block back after the first push.
    let first = row.step(done);
    assert!(matches!(first.output, Output::Act(_)));
    row.block = 0;
    row.until_ended(done);
    let pursuit = row.pursuit();
    assert_eq!((pursuit.ended, pursuit.actions), (Some(Ending::Achieved), 4));
    assert_eq!(reasons(pursuit), [PlanCause::First, PlanCause::NextNotAllowed]);
    assert_eq!(pursuit.plans[1].after_actions, 1);
}

#[test]
fn an_action_that_is_not_carried_out_leads_to_a_new_plan() {
    let mut row = Row::new(&SHELF);
    row.pursue(&["object{field=2}"], 10);
    let mut refusals = 1;
    row.until_ended(|action, _| {
        if action == 1 && refusals > 0 {
            refusals -= 1;
            return ActionOutcome::Refused;
        }
        ActionOutcome::Done
    });
    let pursuit = row.pursuit();
    assert_eq!((pursuit.ended, pursuit.actions), (Some(Ending::Achieved), 3));
    assert_eq!(reasons(pursuit), [PlanCause::First, PlanCause::NotCarriedOut]);
}

#[test]
fn evidence_against_the_first_way_leads_to_another() {
    // Two actions push the block from 0 to 1; then the surer one breaks.
    let mut row = Row::new(&[(0, 1), (0, 1)]);
    row.pursue(&["object{field=1}"], 1000);
    let first = match row.step(|_, _| ActionOutcome::Refused).output {
        Output::Act(action) => action.0 as usize,
        other => panic!("{other:?}"),
    };
    let mut taken = Vec::new();
    row.until_ended(|action, _| {
        taken.push(action);
        if action == first { ActionOutcome::Refused } else { ActionOutcome::Done }
    });
    assert_eq!(row.pursuit().ended, Some(Ending::Achieved));
    assert_eq!(row.pursuit().actions, 2, "one refusal makes the other the surer: {taken:?}");
    assert_ne!(taken.first(), Some(&first));
}

#[test]
fn a_goal_is_given_up_when_nothing_leads_there_or_its_actions_are_used_up() {
    let mut row = Row::new(&SHELF);
    row.pursue(&["object{field=77}"], 10);
    let steps = row.until_ended(done);
    assert_eq!((row.pursuit().ended, row.pursuit().actions), (Some(Ending::NothingLeadsThere), 0));
    assert!(matches!(steps[0].output, Output::Act(_)), "in the same step it goes on as ever");

    row.put(2);
    row.pursue(&["object{field=3}"], 4);
    // The block is stuck.
    while row.pursuit().under_way() {
        row.step(done);
        row.block = 2;
    }
    let pursuit = row.pursuit();
    assert_eq!((pursuit.number, pursuit.ended, pursuit.actions), (2, Some(Ending::ActionsUsedUp), 4));
    assert_eq!(reasons(pursuit)[..2], [PlanCause::First, PlanCause::NotReached]);
}

#[test]
fn a_goal_that_holds_already_needs_no_action() {
    let mut row = Row::new(&SHELF);
    row.pursue(&["object{field=0}"], 10);
    row.step(done);
    assert_eq!((row.pursuit().ended, row.pursuit().actions), (Some(Ending::Achieved), 0));
    assert!(row.pursuit().plans.is_empty());
}

/// "Achieve it again": what holds is left, and brought about once more. Without it there would be nothing to do.
#[test]
fn a_goal_that_holds_can_be_wanted_again() {
    let round = [(0, 1), (1, 2), (2, 0)];
    let mut row = Row::new(&round);
    let again = Goal::Again(row.goal(&["object{field=0}"]));
    let memory = row.table.learner.memory();
    let world = pschema_learner::world_state::WorldState::new(vec![object(1, 0)]);
    let found = pschema_learner::plan::plan(memory, row.table.body, &world, &again).plan.unwrap();
    assert_eq!(found.steps.len(), 3, "{found:?}");
    let effects = row.table.learner.pursue(row.table.body, again, 10).unwrap();
    row.effects.extend(effects);
    row.until_ended(done);
    assert_eq!((row.pursuit().ended, row.pursuit().actions), (Some(Ending::Achieved), 3));
    // Where it does not hold it is as any other goal; and where nothing leads back, there is nothing to do.
    let again = |row: &mut Row, field: i64| {
        let wanted = row.goal(&[&format!("object{{field={field}}}")]);
        row.table.learner.pursue(row.table.body, Goal::Again(wanted), 10).unwrap();
        row.until_ended(done);
        (row.pursuit().ended, row.pursuit().actions)
    };
    let mut row = Row::new(&SHELF);
    assert_eq!(again(&mut row, 2), (Some(Ending::Achieved), 2));
    row.put(2);
    assert_eq!(again(&mut row, 2), (Some(Ending::NothingLeadsThere), 0));
}

/// A table on which touching has been generalised, with a block at a place that was never touched.
fn toucher(curriculum: Curriculum) -> Table {
    let mut table = Table::new(1, 8, 8, curriculum, Parameters::default());
    while table.step() && table.steps.len() < 500 {}
    table
}

#[test]
fn what_only_a_generalised_schema_knows_is_achieved_after_the_curriculum_is_over() {
    let mut table = toucher(exp1_s1(6, 2));
    let before = table.learner.memory().content().progress.clone();
    assert!(before.finished);
    assert!(!table.step(), "it waits");
    (table.blocks, table.touching, table.finger) = (vec![(2, 5)], false, None);
    let wanted = goal(&table, &["touch{}"]);
    table.learner.pursue(table.body, wanted, 10).unwrap();
    assert!(table.step(), "an operator's goal wakes it");
    let chosen = table.learner.memory().content().pending[0].clone().unwrap();
    let schema = table.learner.memory().content().schema(chosen.schema.unwrap()).unwrap();
    assert!(schema.generalised().is_some() && chosen.for_goal);
    assert!(!table.step(), "once it is achieved, it waits again");
    assert_eq!((pursuit(&table).ended, pursuit(&table).actions), (Some(Ending::Achieved), 1));
    assert_eq!(table.learner.memory().content().progress, before, "the curriculum took no notice");
}

#[test]
fn a_goal_in_a_trial_leaves_the_trial_as_it_was() {
    let mut table = Table::new(1, 8, 8, exp1_s1(6, 2), Parameters::default());
    let progress = |table: &Table| table.learner.memory().content().progress.clone();
    while !progress(&table).trial_open {
        table.step();
    }
    // The trial waits for a touch; the finger is sent to the block for another reason.
    let before = progress(&table);
    let place = format!("finger{{field={}}}", table.blocks[0].1);
    let wanted = goal(&table, &[&place]);
    table.learner.pursue(table.body, wanted, 5).unwrap();
    table.step();
    assert!(table.touching && pursuit(&table).under_way());
    table.step();
    assert_eq!(pursuit(&table).ended, Some(Ending::Achieved));
    assert_eq!(progress(&table), before, "the touch was the goal's and not the trial's");
    while table.step() && table.steps.len() < 500 {}
    let reports = progress(&table).reports.clone();
    let touches = reports.iter().find(|report| report.name == "first touches").unwrap();
    assert_eq!((touches.trials, touches.trials_met), (2, 2), "and it went on from there");
}

#[test]
fn a_goal_of_the_bodys_own_observations_is_neither_empty_nor_already_reached() {
    let mut table = toucher(exp1_s1(6, 2));
    table.blocks = vec![(1, 2)];
    table.finger = Some(5);
    let wanted = goal(&table, &["finger{field=4}"]);
    table.learner.pursue(table.body, wanted, 3).unwrap();
    assert!(table.step());
    assert_eq!(pursuit(&table).ended, None);
    table.step();
    assert_eq!((pursuit(&table).ended, pursuit(&table).actions), (Some(Ending::Achieved), 1));
    assert_eq!(table.finger, Some(4));
    let wanted = goal(&table, &["finger{field=4}"]);
    table.learner.pursue(table.body, wanted, 3).unwrap();
    table.step();
    assert_eq!((pursuit(&table).ended, pursuit(&table).actions), (Some(Ending::Achieved), 0));
}

#[test]
fn a_variable_is_the_same_in_all_of_a_goal() {
    let mut table = toucher(exp1_s1(6, 2));
    // A blue block out of reach, and the finger somewhere else.
    (table.blocks, table.finger, table.touching) = (vec![(1, 7)], Some(3), false);
    let wanted = goal(&table, &["object{colour=blue, field=$x}", "finger{field=$x}"]);
    table.learner.pursue(table.body, wanted, 3).unwrap();
    while pursuit(&table).under_way() {
        table.step();
    }
    assert_eq!((pursuit(&table).ended, table.finger), (Some(Ending::Achieved), Some(7)), "it points");
}

#[test]
fn an_event_before_anything_was_done_is_no_success() {
    let mut table = toucher(exp1_s1(6, 2));
    (table.blocks, table.finger, table.touching, table.outcome) = (vec![(1, 2)], Some(2), true, None);
    let wanted = goal(&table, &["touch{}"]);
    table.learner.pursue(table.body, wanted, 3).unwrap();
    assert!(table.step());
    assert_eq!((pursuit(&table).ended, pursuit(&table).actions), (None, 1));
    table.step();
    assert_eq!(pursuit(&table).ended, Some(Ending::Achieved));
}

#[test]
fn an_operator_holds_a_pursuit_and_lets_it_go_on() {
    let mut row = Row::new(&SHELF);
    row.pursue(&["object{field=3}"], 10);
    row.step(done);
    row.table.learner.stage(&StageCommand::Hold).unwrap();
    assert_eq!(row.step(done).output, Output::Hold);
    assert!(row.pursuit().under_way());
    row.table.learner.stage(&StageCommand::Resume).unwrap();
    row.until_ended(done);
    assert_eq!((row.pursuit().ended, row.pursuit().actions), (Some(Ending::Achieved), 3));
    assert_eq!(reasons(row.pursuit()), [PlanCause::First, PlanCause::Interrupted]);
}

#[test]
fn what_cannot_be_pursued_is_refused_with_the_reason_and_changes_nothing() {
    let mut table = toucher(exp1_s1(6, 2));
    let body = table.body;
    let one = goal(&table, &["touch{}"]);
    let before = digest(table.learner.memory().content());
    let learner = &mut table.learner;
    assert_eq!(learner.pursue(body, Vec::new(), 1), Err(PursueError::Empty));
    assert_eq!(learner.pursue(body, Goal::Again(Vec::new()), 1), Err(PursueError::Empty));
    let many = vec![one[0].clone(); GOAL_PATTERNS_MAX + 1];
    assert_eq!(learner.pursue(body, many, 1), Err(PursueError::Long { given: GOAL_PATTERNS_MAX + 1 }));
    for given in [0, GOAL_ACTIONS_MAX + 1] {
        assert_eq!(learner.pursue(body, one.clone(), given), Err(PursueError::Actions { given }));
    }
    let nobody = pschema_learner::vocabulary::BodyId(9);
    assert_eq!(learner.pursue(nobody, one.clone(), 1), Err(PursueError::Body));
    let word = Pattern::new(common::WORD, []);
    let constrained = learner.pursue(body, vec![word], 1).unwrap_err().to_string();
    assert!(constrained.contains("probe") && constrained.contains("word"), "{constrained}");
    assert_eq!(learner.cancel_goal(), Err(PursueError::Nothing));
    assert_eq!(digest(learner.memory().content()), before);
    learner.stage(&StageCommand::Hold).unwrap();
    assert_eq!(learner.pursue(body, one.clone(), 1), Err(PursueError::Held));
    learner.stage(&StageCommand::Resume).unwrap();

    learner.pursue(body, one.clone(), 1).unwrap();
    let busy = learner.pursue(body, one, 1).unwrap_err().to_string();
    assert!(busy.contains("goal 1") && busy.contains("touch{}"), "{busy}");
    learner.cancel_goal().unwrap();
    assert_eq!(pursuit(&table).ended, Some(Ending::Cancelled));
}

#[test]
fn a_goal_that_the_stage_no_longer_lets_be_seen_ends() {
    let mut table = toucher(exp1_s1(6, 2));
    let wanted = goal(&table, &["touch{}"]);
    table.learner.pursue(table.body, wanted, 5).unwrap();
    table.learner.stage(&StageCommand::Set("motor babbling".into())).unwrap();
    table.step();
    assert_eq!(pursuit(&table).ended, Some(Ending::Constrained));
}

#[test]
fn a_cancelled_goal_leaves_its_chain_and_learning_goes_on() {
    let mut row = Row::new(&SHELF);
    row.pursue(&["object{field=3}"], 10);
    row.step(done);
    let effects = row.table.learner.cancel_goal().unwrap();
    row.effects.extend(effects);
    let pending = row.table.learner.memory().content().pending[0].clone().unwrap();
    assert!(pending.chain.is_empty() && pending.for_goal);
    let step = row.step(done);
    assert!(step.effects.iter().any(|effect| matches!(effect, Effect::Executed { .. })), "{step:?}");
    assert!(step.decision.unwrap().goal.is_none());
}

#[test]
fn pursuits_are_replayed_and_survive_in_content() {
    let mut row = Row::new(&SHELF);
    let start = row.table.learner.memory().content().clone();
    row.effects.clear();
    row.pursue(&["object{field=3}"], 10);
    row.step(done);
    let halfway = digest(row.table.learner.memory().content());
    let restored = Memory::restore(row.table.learner.memory().content().clone(), Parameters::default());
    assert_eq!(digest(restored.content()), halfway);
    assert_eq!(restored.content().pursuit, row.table.learner.memory().content().pursuit);
    row.until_ended(done);
    let mut memory = Memory::restore(start, Parameters::default());
    for effect in &row.effects {
        memory.apply(effect).unwrap();
    }
    assert_eq!(digest(memory.content()), digest(row.table.learner.memory().content()));
    assert_ne!(digest(memory.content()), halfway);
    // Effects of a goal that is not pursued do not apply.
    let stray = row.effects.iter().rfind(|effect| matches!(effect, Effect::Pursuit(_))).unwrap();
    assert!(memory.apply(stray).is_err());
}

#[test]
fn of_two_ways_only_what_the_goal_relies_on_is_weighed_also_on_the_way() {
    // Moving the block from 0 to 1 makes a red ball fall two times in three; from 1 it is pushed on to 2.
    let mut table = Table::new(3, 2, 0, free(), Parameters::default());
    let start = [object(1, 0), object(2, 9)];
    let (mut state, mut outcome, mut pushes) = (start.to_vec(), None, 0);
    for step in 0..300 {
        let frame = Frame { body: table.body, outcome: outcome.take(), observations: state.clone() };
        let Output::Act(action) = table.learner.step(&frame).output else { panic!("it can act") };
        match action.0 {
            0 if state.contains(&object(1, 0)) => {
                pushes += 1;
                state.retain(|o| *o != object(1, 0) && (pushes % 3 == 0 || *o != object(2, 9)));
                state.push(object(1, 1));
            }
            1 if state.contains(&object(1, 1)) => {
                state.retain(|o| *o != object(1, 1));
                state.push(object(1, 2));
            }
            _ => (),
        }
        outcome = Some(ActionOutcome::Done);
        if step % 3 == 2 {
            (state, outcome) = (start.to_vec(), None);
        }
    }
    let memory = table.learner.memory();
    let world = pschema_learner::world_state::WorldState::new(start.to_vec());
    let far = goal(&table, &["object{colour=blue, field=2}"]);
    let plan = pschema_learner::plan::plan(memory, table.body, &world, &far.clone().into()).plan.unwrap();
    assert_eq!(plan.steps.len(), 2, "{plan:?}");
    assert!(plan.probability > 0.9, "the ball's fall on the way does not count: {plan:?}");
    let relied: Vec<&Observation> =
        plan.steps.iter().flat_map(|step| &step.relies_on).map(|post| &post.what).collect();
    assert!(relied.iter().all(|o| o.kind() == OBJECT && **o != object(2, 9)), "{relied:?}");
    assert!(!relied.contains(&&finger(0)) && !relied.contains(&&touch()));
}
