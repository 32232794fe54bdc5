//! Predicting, planning and pursuing goals, as tools ask for it: in one process, and over shared memory.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use common::{Row, ask, curriculum, free, problem, setup};
use pschema_inspect::{
    AchieveOrder, Condition, ExplanationQuery, Plan, PlanCause, PlanQuery, PlanState, Prediction,
    PredictionQuery, Pursuit, PursuitQuery, PursuitState, Reason, ReportQuery, StageOrder, StageState,
    Status, StatusQuery, ValueText,
};
use pschema_learner::progress::StageCommand;
use pschema_protocol::body::RunOptions;
use pschema_protocol::client::Client;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_server::in_process::{InProcess, RunState};
use pschema_server::inspect::Inspect;
use pschema_server::serve;

/// A learner that has touched blocks on a row, generalised, and is through with its curriculum.
fn finished(seed: u64) -> InProcess<Row> {
    let mut run = InProcess::new(Row::new("row"), setup(seed, curriculum())).unwrap();
    while run.advance().unwrap() == RunState::Running {}
    run
}

fn order(goal: &[String]) -> AchieveOrder {
    AchieveOrder { goal: goal.to_vec(), actions_max: 5, ..AchieveOrder::default() }
}

fn patterns(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| (*text).to_owned()).collect()
}

fn predict(run: &InProcess<Row>, action: &str) -> Prediction {
    run.ask(&PredictionQuery { action: action.to_owned() }).unwrap()
}

fn plan(run: &InProcess<Row>, goal: &[&str]) -> Plan {
    run.ask(&PlanQuery { goal: patterns(goal), ..PlanQuery::default() }).unwrap()
}

fn pursuit(run: &InProcess<Row>) -> Pursuit {
    run.ask(&PursuitQuery {}).unwrap()
}

fn refused<Q: Inspect>(run: &InProcess<Row>, question: &Q) -> String {
    run.ask(question).err().unwrap().0
}

/// Where the block is, as the learner saw it last.
fn block(run: &InProcess<Row>) -> i64 {
    let plan = plan(run, &["touch{}"]);
    let block = plan.world.iter().find(|seen| seen.kind == "object").unwrap();
    match block.properties.get("field") {
        Some(ValueText::Integer(field)) => *field,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_an_action_would_do_is_told_with_counts_and_the_schema_that_says_so() {
    let run = finished(1);
    let field = block(&run);
    // Two decimals, as it prints, or as many as it takes to tell it apart.
    let move_to = |field: i64| {
        let reach = format!("{:.3}", (field % 8) as f64 / 8.0);
        format!("move(reach={})", reach.strip_suffix('0').unwrap_or(&reach))
    };
    let action = move_to(field);
    let touching = predict(&run, &action);
    let schema = touching.schema.as_ref().unwrap();
    assert_eq!(schema.action.split('(').next(), Some("move"));
    let touch = touching.outcomes.iter().find(|outcome| outcome.observation.kind == "touch").unwrap();
    assert!(touch.trials > 0 && touch.occurrences <= touch.trials && touch.low < touch.high, "{touch:?}");
    assert!(touching.attempts > 0 && touching.carried_out == touching.attempts);

    // Elsewhere only the babbled schema holds: the finger is there, and nothing is felt.
    let other = predict(&run, &move_to(field + 1));
    assert!(other.outcomes.iter().all(|outcome| outcome.observation.kind != "touch"), "{other:?}");
    assert!(other.outcomes.iter().any(|outcome| outcome.observation.kind == "finger"));

    let step = run.learner().memory().content().step;
    assert_eq!(run.report().step, step, "asking changes nothing");
}

#[test]
fn an_action_that_the_body_does_not_have_is_answered_with_those_that_are_near() {
    let run = finished(1);
    let mistakes = [
        ("move(reach=0.41)", "move(reach=0.38)"),
        ("fly(reach=0.41)", "it has move"),
        ("move", "write it as it prints, such as move(reach=0"),
        ("", "write it as it prints, such as move(reach=0"),
    ];
    for (action, hint) in mistakes {
        let problem = refused(&run, &PredictionQuery { action: action.to_owned() });
        assert!(problem.contains(hint), "{action:?}: {problem}");
    }
    // Spaces are nobody's mistake.
    assert!(predict(&run, " move( reach = 0.38 ) ").schema.is_some());
}

#[test]
fn a_plan_says_what_it_relies_on_and_how_surely() {
    let run = finished(2);
    let field = block(&run);
    let found = plan(&run, &["object{field=$x}", "finger{field=$x}", "touch{}"]);
    assert_eq!((found.state, found.steps.len(), found.search_truncated), (PlanState::Found, 1, false));
    let step = &found.steps[0];
    let kinds: Vec<_> = step.relies_on.iter().map(|c| c.observation.kind.as_str()).collect();
    assert!(kinds.contains(&"finger") && kinds.contains(&"touch"), "{kinds:?}");
    let likely = |c: &Condition| if c.absent { 1.0 - c.probability } else { c.probability };
    let relied: f64 = step.through.iter().chain(&step.relies_on).map(likely).product();
    assert!((step.probability - step.reliability * relied).abs() < 1e-9, "{step:?}");
    let carrier = step.schema.as_ref().and_then(|schema| schema.carrier);
    assert_eq!(step.through.len(), usize::from(carrier.is_some()));
    assert!((found.probability.unwrap() - step.probability).abs() < 1e-9);

    let here = plan(&run, &[&format!("object{{field={field}}}")]);
    assert_eq!((here.state, here.probability, here.steps.len()), (PlanState::HoldsAlready, Some(1.0), 0));
    let nowhere = plan(&run, &[&format!("object{{field={}}}", (field + 1) % 8)]);
    assert_eq!((nowhere.state, nowhere.probability), (PlanState::NothingLeadsThere, None));
    for (goal, hint) in
        [(vec![], "1 to 8"), (vec!["cat{}"], "no observation type"), (vec!["touch"], "pattern")]
    {
        let problem = refused(&run, &PlanQuery { goal: patterns(&goal), ..PlanQuery::default() });
        assert!(problem.contains(hint), "{goal:?}: {problem}");
    }
}

#[test]
fn a_goal_wakes_a_learner_that_is_through_and_lets_it_rest_again() {
    for seed in 1..=5 {
        let mut run = finished(seed);
        assert_eq!(run.advance().unwrap(), RunState::Waiting);
        assert!(refused(&run, &PursuitQuery {}).contains("no goal"));
        let before = run.report();
        // Away from the block first, so that the touch is a new one.
        let away = (block(&run) + 3) % 8;
        for goal in [format!("finger{{field={away}}}"), "touch{}".to_owned()] {
            run.achieve(&order(std::slice::from_ref(&goal))).unwrap();
            while run.advance().unwrap() == RunState::Running {}
            let end = pursuit(&run);
            assert_eq!((end.state, end.actions, end.plans_made), (PursuitState::Achieved, 1, 1), "{end:?}");
            assert_eq!((end.wanted.goal, end.plans[0].because), (vec![goal], PlanCause::First));
        }
        let after = run.report();
        assert!(after.finished && after.step > before.step);
        assert_eq!(after.stages, before.stages, "the curriculum took no notice");
        let why = run.ask(&ExplanationQuery { step: None, candidates_max: 5 }).unwrap();
        assert_eq!(why.reason, Reason::Goal);
        let goal = why.goal.unwrap();
        assert_eq!((goal.wanted.goal, goal.at, goal.chain.len()), (patterns(&["touch{}"]), 0, 1));
    }
}

#[test]
fn the_seed_and_the_goals_decide_everything() {
    let digest = || {
        let mut run = finished(4);
        run.achieve(&order(&patterns(&["finger{field=0}"]))).unwrap();
        while run.advance().unwrap() == RunState::Running {}
        run.report().memory_digest
    };
    assert_eq!(digest(), digest());
    assert_ne!(digest(), finished(4).report().memory_digest);
}

#[test]
fn goals_that_cannot_be_pursued_are_refused() {
    let mut run = finished(1);
    run.achieve(&order(&patterns(&["object{field=7}", "object{field=6}"]))).unwrap();
    let busy = run.achieve(&order(&patterns(&["touch{}"]))).unwrap_err().to_string();
    assert!(busy.contains("goal 1") && busy.contains("object{field=7} & object{field=6}"), "{busy}");
    assert!(run.cancel(7).is_err());
    run.cancel(1).unwrap();
    assert_eq!(pursuit(&run).state, PursuitState::Cancelled);
    run.cancel(1).unwrap();
    run.stage(&StageCommand::Hold).unwrap();
    let held = run.achieve(&order(&patterns(&["touch{}"]))).unwrap_err().to_string();
    assert!(held.contains("stage resume"), "{held}");
    for (goal, hint) in [("cat{}", "object"), ("object{size=1}", "colour"), ("object{colour=blue", "pattern")]
    {
        let problem = run.achieve(&order(&patterns(&[goal]))).unwrap_err().to_string();
        assert!(problem.contains(hint), "{goal}: {problem}");
    }
}

/// The longest that any wait of these tests may take; a machine under load takes its time.
const PATIENCE: Duration = Duration::from_secs(60);

fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(seen) = look() {
            return seen;
        }
        assert!(start.elapsed() < PATIENCE, "{what}");
        std::thread::yield_now();
    }
}

fn status(client: &mut Client) -> Status {
    ask(client, StatusQuery {}).unwrap()
}

#[test]
fn tools_plan_and_give_goals_to_a_daemon() {
    let directory = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
    let runtime = RuntimeDir::at(&directory.path().join("run")).unwrap();
    let place = Place::new(runtime, LearnerName::new("goals").unwrap());
    let stop = Arc::new(AtomicBool::new(false));
    let daemon = {
        let (place, stop) = (place.clone(), stop.clone());
        std::thread::spawn(move || serve(place, setup(3, curriculum()), &stop))
    };
    let mut client = until("the daemon answers", || {
        let mut client = Client::connect(&place, PATIENCE).ok()?;
        ask(&mut client, ReportQuery {}).ok()?;
        Some(client)
    });
    let touch = patterns(&["touch{}"]);
    let achieve = order(&touch);
    let look = PlanQuery { goal: touch, ..PlanQuery::default() };
    assert!(problem(&mut client, achieve.clone()).contains("no body"));
    assert!(problem(&mut client, look.clone()).contains("no body"));
    let options = RunOptions::new(place.clone()).exit_when_daemon_gone(true).stop(stop.clone());
    let body = std::thread::spawn(move || pschema_protocol::body::run(Row::new("row"), &options));
    until("the curriculum is over", || {
        (status(&mut client).stage_state == StageState::Finished).then_some(())
    });

    let plan = ask(&mut client, look).unwrap();
    assert_eq!((plan.state, plan.body.as_str()), (PlanState::Found, "row"));
    let begun = ask(&mut client, achieve.clone()).unwrap();
    assert_eq!(begun.number, 1);
    let end = until("the goal is over", || {
        let now = ask(&mut client, PursuitQuery {}).unwrap();
        (now.state != PursuitState::Pursued).then_some(now)
    });
    assert_eq!((end.state, end.achieved, end.actions), (PursuitState::Achieved, true, 1));
    assert_eq!(Some(end.plans[0].chain[0].id), plan.steps[0].schema.as_ref().map(|s| s.id));
    assert_eq!(status(&mut client).goal, None);

    ask(&mut client, StageOrder::Hold).unwrap();
    let held = problem(&mut client, achieve);
    assert!(held.contains("holds"), "{held}");
    ask(&mut client, StageOrder::Resume).unwrap();

    drop(client);
    stop.store(true, Ordering::Relaxed);
    daemon.join().unwrap().unwrap();
    body.join().unwrap().unwrap();
}

#[test]
fn in_free_play_a_goal_interrupts_and_play_goes_on() {
    let mut run = InProcess::new(Row::new("row"), setup(1, free())).unwrap();
    for _ in 0..40 {
        run.advance().unwrap();
    }
    run.achieve(&order(&patterns(&["finger{field=5}"]))).unwrap();
    let status = run.ask(&StatusQuery {}).unwrap();
    assert_eq!(
        status.goal.map(|goal| (goal.number, goal.wanted.goal)),
        Some((1, patterns(&["finger{field=5}"])))
    );
    while pursuit(&run).state == PursuitState::Pursued {
        run.advance().unwrap();
    }
    assert_eq!(pursuit(&run).state, PursuitState::Achieved);
    let step = run.report().step;
    run.advance().unwrap();
    assert!(run.report().step > step);
}
