//! What people and programs read, compared with files in `tests/golden`.

use pschema_inspect::*;

use super::{claims, explanation, goals, schema, status, why_not};
use crate::golden::{check, check_json, check_text};
use crate::report::figures;
use crate::run::tests::{report, stage};
use crate::run::{Reading, Results, Unit};

fn observation(kind: &str, properties: &[(&str, ValueText)]) -> ObservationText {
    let properties = properties.iter().map(|(name, v)| ((*name).to_owned(), v.clone())).collect();
    ObservationText { kind: kind.to_owned(), properties }
}

fn symbol(name: &str) -> ValueText {
    ValueText::Symbol(name.to_owned())
}

fn variable(name: &str) -> ValueText {
    ValueText::variable(name)
}

fn blue_in(field: ValueText) -> ObservationText {
    observation("object", &[("colour", symbol("blue")), ("field", field)])
}

fn finger_in(field: ValueText) -> ObservationText {
    observation("finger", &[("field", field)])
}

fn condition(observation: ObservationText, occurrences: u32, trials: u32) -> Condition {
    let probability = f64::from(occurrences) / f64::from(trials);
    Condition { observation, absent: false, occurrences, trials, probability, low: 0.702, high: 0.988 }
}

pub(super) fn a_status() -> Status {
    Status {
        name: "robot-1".to_owned(),
        pid: 4711,
        uptime_s: 12.34,
        step: 345,
        durable_step: None,
        profile: "paper".to_owned(),
        curriculum: "exp1-s1".to_owned(),
        stage: "probe".to_owned(),
        stage_state: StageState::Acting,
        saturation: None,
        habituation: None,
        trial: Some(TrialStatus {
            trial: 12,
            trials_wanted: 97,
            open: true,
            actions: 1,
            actions_max: Some(5),
        }),
        schemas_total: 228,
        schemas_concrete: 227,
        schemas_generalised: 1,
        bodies: vec![BodyStatus {
            id: 1,
            name: "sim".to_owned(),
            kind: "simulated arm".to_owned(),
            pid: 4712,
            state: BodyState::Attached,
            frames: 700,
            frames_refused: 1,
            last_refusal: Some("observation 3 (object): property field = 912 is outside 0..=460".to_owned()),
            last_failure: Some(OrderFailure {
                outcome: FailedOutcome::Refused,
                reason: Some("the arm does not reach 0.1, 2.7".to_owned()),
                step: 344,
            }),
            episodes_ended: 12,
            episodes_cut: 1,
            warnings: vec![DeclarationWarning::ValuesNeverRepeat {
                sense: "force".to_owned(),
                observations: 500,
                repeated: 2,
            }],
        }],
        steps_per_s: 61.25,
        step_latency_us_p50: 55.4,
        step_latency_us_p99: 180.2,
        commit_latency_us_p50: 174.6,
        commit_latency_us_p99: 310.9,
        memory_bytes: 23 * 1024 * 1024,
        memory_max_bytes: Some(32 * 1024 * 1024),
        memory_full: true,
        growth: [(64, 31.0), (128, 36.5)]
            .map(|(schemas, step_latency_us_p50)| GrowthStatus {
                schemas,
                steps: u64::from(schemas) * 2,
                step_latency_us_p50,
                step_latency_us_p99: 3.0 * step_latency_us_p50,
                memory_bytes: 20 * 1024 * 1024 + u64::from(schemas) * 1024,
            })
            .to_vec(),
        memory_digest: Some("9b1f".repeat(16)),
        excitation_top: 1.75,
        world: vec!["object{colour=blue, field=17}".to_owned(), "finger{field=4}".to_owned()],
        goal: None,
        storage: None,
        refused: Vec::new(),
        log_lines_lost: 7,
    }
}

fn a_list() -> SchemaList {
    let summary = |id: u32, kind: SchemaKind, pre: &[&str], action: &str, post: &[&str]| SchemaSummary {
        id,
        kind,
        pre: pre.iter().map(|text| (*text).to_owned()).collect(),
        action: action.to_owned(),
        post: post.iter().map(|text| (*text).to_owned()).collect(),
        // The two outcomes of one of them exclude each other.
        post_shares: if id == 4 { vec![Some(0.6), Some(0.4)] } else { vec![Some(1.0); post.len()] },
        executions: 15,
        successes: 14,
        probability: 14.0 / 15.0,
        low: 0.702,
        high: 0.988,
    };
    let blue = "object{colour=blue, field=17}";
    SchemaList {
        matching: 228,
        schemas: vec![
            summary(
                4,
                SchemaKind::Concrete,
                &[],
                "move(j1=0.43, j2=0.84)",
                &["finger{field=4}", "finger{field=5}"],
            ),
            summary(
                224,
                SchemaKind::CounterExample,
                &[blue],
                "move(j1=0.5, j2=0.9)",
                &["finger{field=17}", blue],
            ),
            summary(
                226,
                SchemaKind::Generalised,
                &["object{colour=$a, field=$b}"],
                "achieve finger{field=$b}",
                &["finger{field=$b}", "object{colour=$a, field=$b}", "touch{}"],
            ),
        ],
    }
}

fn a_schema() -> SchemaDetail {
    let b = || variable("b");
    let pre = observation("object", &[("colour", variable("a")), ("field", b())]);
    let mut lost = condition(blue_in(b()), 1, 15);
    lost.absent = true;
    SchemaDetail {
        id: 226,
        kind: SchemaKind::Generalised,
        action: "finger{field=$b}".to_owned(),
        target: vec![finger_in(b())],
        pre: vec![pre.clone()],
        post: vec![
            condition(finger_in(b()), 15, 15),
            condition(pre, 15, 15),
            condition(observation("touch", &[]), 14, 15),
            lost,
        ],
        associated: vec![condition(observation("word", &[("text", symbol("touch"))]), 3, 15)],
        executions: 15,
        successes: 14,
        probability: 14.0 / 15.0,
        low: 0.702,
        high: 0.988,
        parent: Some(17),
        contradicts: None,
        examples: vec![224, 225],
        counter_examples: vec![227],
        created_step: 231,
        claims: Vec::new(),
    }
}

fn expected(observation: ObservationText) -> Expectation {
    Expectation { observation, absent: false, share: Some(1.0) }
}

fn binding(field: i64) -> NamedValues {
    NamedValues(vec![("a".to_owned(), symbol("blue")), ("b".to_owned(), ValueText::Integer(field))])
}

/// The law that the finger touches what is in the field that it is brought to.
fn touching_form() -> SchemaForm {
    SchemaForm {
        pre: vec![observation("object", &[("colour", variable("a")), ("field", variable("b"))])],
        action: "achieve finger{field=$b}".to_owned(),
        target: vec![finger_in(variable("b"))],
        post: vec![expected(observation("touch", &[]))],
    }
}

fn an_explanation() -> Explanation {
    let term =
        |remembered: Option<ObservationText>, role: TermRole, shared: u32, attention: u32, value: f64| {
            let seen = remembered.is_some().then(|| blue_in(ValueText::Integer(17)));
            ExcitationTerm {
                observation: remembered,
                seen,
                role,
                shared,
                attention,
                probability: 1.0,
                weight: 1.0,
                value,
            }
        };
    let reaching = Candidate {
        schema: Some(17),
        text: "∅ / move(j1=0.43, j2=0.84) / finger{field=17}".to_owned(),
        form: SchemaForm {
            action: "move(j1=0.43, j2=0.84)".to_owned(),
            post: vec![expected(finger_in(ValueText::Integer(17)))],
            ..SchemaForm::default()
        },
        binding: NamedValues::default(),
        together: Vec::new(),
        distance: 1,
        excitation: 0.5,
        terms: vec![term(Some(finger_in(ValueText::Integer(17))), TermRole::PostCondition, 1, 1, 0.5)],
    };
    let touching = Candidate {
        schema: Some(226),
        text: "object{colour=$a, field=$b} / achieve finger{field=$b} / touch{}".to_owned(),
        form: touching_form(),
        binding: binding(17),
        together: Vec::new(),
        distance: 2,
        excitation: 1.25,
        terms: vec![
            term(Some(blue_in(ValueText::Integer(17))), TermRole::PreCondition, 2, 0, 2.0),
            term(Some(finger_in(ValueText::Integer(17))), TermRole::PostCondition, 1, 1, 0.5),
        ],
    };
    Explanation {
        step: 231,
        body: "sim".to_owned(),
        world: vec![blue_in(ValueText::Integer(17))],
        chosen: 0,
        action: "move(j1=0.43, j2=0.84)".to_owned(),
        reason: Reason::Excitation,
        ties: 1,
        candidates_total: 224,
        candidates: vec![touching, reaching],
        goal: None,
        claims: Vec::new(),
    }
}

/// Of the explained step, why schema 42 was not executed.
fn a_why_not(verdict: Verdict) -> WhyNot {
    let explained = an_explanation();
    let chosen = explained.candidates[0].clone();
    let excited = matches!(verdict, Verdict::LessExciting { .. });
    let candidate =
        Candidate { schema: Some(42), distance: 2, excitation: 0.25, ..explained.candidates[1].clone() };
    WhyNot {
        step: explained.step,
        body: explained.body,
        world: explained.world,
        schema: 42,
        kind: SchemaKind::Concrete,
        text: "object{colour=blue, field=4} / move(j1=0.10, j2=0.20) / touch{}".to_owned(),
        form: SchemaForm {
            pre: vec![blue_in(ValueText::Integer(4))],
            action: "move(j1=0.10, j2=0.20)".to_owned(),
            target: Vec::new(),
            post: vec![expected(observation("touch", &[]))],
        },
        verdict,
        binding: NamedValues::default(),
        bindings: 0,
        candidate: excited.then_some(candidate),
        chain: if excited { vec![in_use(17, SchemaKind::Concrete, 4)] } else { Vec::new() },
        attempts: 9,
        carried_out: 8,
        habituated: excited.then_some(true),
        search_truncated: false,
        chosen,
        action: explained.action,
        reason: explained.reason,
        ties: 1,
    }
}

#[test]
fn why_not_as_text_and_json() {
    let wanted = blue_in(ValueText::Integer(4));
    let differs = vec!["field".to_owned()];
    let nearest = Some(blue_in(ValueText::Integer(17)));
    let unseen = UnmetCondition {
        wanted: finger_in(ValueText::Integer(4)),
        nearest: None,
        differs: Vec::new(),
        constrained: true,
    };
    let lacking = vec![UnmetCondition { wanted, nearest, differs, constrained: false }, unseen];
    let missing = a_why_not(Verdict::PreConditions { lacking });
    check_text("why-not-lacking.txt", &why_not::why_not(&missing));
    check_json("why-not-lacking.json", &missing);
    let duller = a_why_not(Verdict::LessExciting { by: 1.0 });
    check_text("why-not-duller.txt", &why_not::why_not(&duller));
    check_json("why-not-duller.json", &duller);
    let says = |verdict: Verdict, text: &str| {
        let told = why_not::why_not(&a_why_not(verdict)).replace('\n', " ");
        assert!(told.contains(text), "{told}");
    };
    says(Verdict::Chosen, "Schema 42 is what was chosen in step 231");
    says(Verdict::ExecutedFor { schema: 226 }, "for the sake of schema 226");
    says(Verdict::Retired, "It failed too often");
    says(Verdict::NotInRepertoire, "sim can't do its action");
    says(Verdict::NotExciting, "its excitation is 0");
    let claims = claims_foretold();
    says(
        Verdict::OtherClaims { claims },
        "in force for its action here, because object{field=effect(finger).field}.",
    );
    says(Verdict::OtherClaims { claims: Vec::new() }, "none of the conditions that it needs");
    says(Verdict::LotFellOnAnother, "the lot fell on schema 226");
    says(Verdict::StoodInFor { by: 9, kind: SchemaKind::CounterExample }, "schema 9, a counter-example");
    says(
        Verdict::TargetNotAchievable { target: vec![finger_in(variable("b"))] },
        "achieves its target finger{field=$b}",
    );
    says(Verdict::NotWeighed, "a chain begun before was being followed");
}

fn a_report() -> Report {
    let mut babbling = stage("motor babbling", true, &[], &[]);
    (babbling.actions, babbling.schemas_new, babbling.saturated) = (229, 224, true);
    let mut beyond = stage("out of reach", true, &[false], &[1]);
    beyond.counter_examples_new = 1;
    let probe = stage("probe", false, &[true, true, false], &[1, 1, 1]);
    report(vec![babbling, stage("first touches", true, &[true, true], &[0, 1]), beyond, probe])
}

fn a_run(seed: u64) -> Results {
    let mut report = a_report();
    report.seed = seed;
    crate::run::tests::results("wide", &report)
}

#[test]
fn status_as_table_and_json() {
    check_text("status.txt", &status::status(&a_status()));
    check_json("status.json", &a_status());
    let mut alone = a_status();
    alone.bodies.clear();
    assert!(status::status(&alone).contains("pschema sim"), "says how to get a body");
}

/// Motor babbling, after so many quiet actions of five, with so many schemas left to habituate to.
fn babbling(quiet_actions: u32, habituation_left: Option<u32>) -> Status {
    let state = if habituation_left.is_some() { StageState::Habituating } else { StageState::Acting };
    Status {
        stage: "motor babbling".to_owned(),
        stage_state: state,
        saturation: Some(SaturationStatus { quiet_actions, quiet_actions_wanted: 5, saturation_below: 1.0 }),
        habituation: Some(HabituationStatus { habituation_left, executions_min: 40, interval_max: 0.2 }),
        trial: None,
        ..a_status()
    }
}

#[test]
fn saturation_and_habituation_as_table_and_json() {
    check_text("status-acting.txt", &status::status(&babbling(3, None)));
    check_json("status-acting.json", &babbling(3, None));
    check_text("status-habituating.txt", &status::status(&babbling(5, Some(112))));
    check_json("status-habituating.json", &babbling(5, Some(112)));
    let mut once = babbling(5, Some(1));
    once.habituation =
        Some(HabituationStatus { habituation_left: Some(1), executions_min: 1, interval_max: 0.0 });
    once.trial = Some(TrialStatus { trial: 0, trials_wanted: 2, open: false, actions: 0, actions_max: None });
    let told = status::status(&once);
    assert!(told.contains("1 schema of this stage left to be executed once\n"), "{told}");
    assert!(told.contains("none yet of 2"), "{told}");
    once.trial = Some(TrialStatus { trial: 2, trials_wanted: 2, open: false, actions: 3, actions_max: None });
    let told = status::status(&once);
    assert!(told.contains("2 of 2, over after 3 actions\n"), "{told}");
}

#[test]
fn schemas_as_table_and_json() {
    check_text("schemas.txt", &schema::list(&a_list(), 0));
    check_json("schemas.json", &a_list());
    assert_eq!(schema::list(&SchemaList { matching: 0, schemas: Vec::new() }, 0), "No schema fits.\n");
}

#[test]
fn one_schema_as_text_and_json() {
    check_text("show.txt", &schema::detail(&a_schema()));
    check_json("show.json", &a_schema());
    let resting = SchemaDetail { claims: claims_foretold(), ..a_schema() };
    check_text("show-claims.txt", &schema::detail(&resting));
}

#[test]
fn an_explanation_as_text_and_json() {
    check_text("explain.txt", &explanation::explanation(&an_explanation()));
    check_json("explain.json", &an_explanation());
    let foretold = Explanation { claims: claims_foretold(), ..an_explanation() };
    let told = explanation::explanation(&foretold);
    assert!(told.contains("What claims foretold of move(j1=0.43, j2=0.84):"), "{told}");
    let mut other = an_explanation();
    other.chosen = 9;
    assert!(
        explanation::explanation(&other).contains("did not say why"),
        "an index out of range is survived"
    );
}

#[test]
fn a_curriculum_as_table() {
    check_text("stage.txt", &status::report(&a_report()));
}

#[test]
fn a_run_as_table_and_json() {
    check_text("experiment.txt", &figures::one(&a_run(7)));
    check_json("experiment.json", &a_run(7));
    check_text("experiments.txt", &figures::several(&[&a_run(1), &a_run(2)]));
}

/// Experiment 2 once printed 0 for all that it had not measured, and none of its own measures.
#[test]
fn runs_are_told_with_their_own_measures_and_no_others() {
    let run = |seed, touching| {
        let measured = |name: &str, value| Reading {
            name: name.to_owned(),
            value,
            published: Some("more".to_owned()),
            unit: Unit::Share,
            why: None,
        };
        let measures = vec![measured("decisions for touching", Some(touching)), measured("met", None)];
        Results { placements: None, probe: None, published: None, measures, ..a_run(seed) }
    };
    let text = figures::several(&[&run(1, 0.25), &run(2, 0.35), &run(3, 0.3)]);
    let line = |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap_or_default();
    for missing in ["PLACEMENTS", "TRIED", "TOUCHED"] {
        assert!(!text.contains(missing), "{missing}: {text}");
    }
    assert!(line("decisions for touching").contains("30 % (25-35)"), "{text}");
    assert!(
        line("met").split_whitespace().eq(["met", "-", "more"]),
        "what was not measured is not 0: {text}"
    );
}

/// After some thousand steps every excitation was 0.000.
#[test]
fn small_figures_are_told_with_the_digits_that_say_something() {
    let mut small = an_explanation();
    for candidate in &mut small.candidates {
        candidate.excitation *= 1e-4;
        candidate.terms.iter_mut().for_each(|term| term.value *= 1e-4);
    }
    let text = explanation::explanation(&small);
    assert!(!text.contains(" 0.000 ") && !text.contains(" 0.000\n"), "{text}");
    let mut status = a_status();
    status.excitation_top = 0.000_123;
    assert!(status::status(&status).contains("excitation  0.00012 at the last decision"));
}

fn in_use(id: u32, kind: SchemaKind, field: i64) -> SchemaInUse {
    SchemaInUse {
        id,
        kind,
        text: "object{colour=$a, field=$b} / achieve finger{field=$b} / touch{}".to_owned(),
        binding: binding(field),
        action: "move(j1=0.43, j2=0.84)".to_owned(),
        carrier: Some(4),
    }
}

#[test]
fn an_explanation_tells_which_schemas_achieve_a_target_together() {
    let mut told = an_explanation();
    assert!(!explanation::in_a_sentence(&told).contains("together"));
    told.candidates[0].together = vec![
        in_use(8, SchemaKind::Concrete, 3),
        SchemaInUse { action: "close()".to_owned(), ..in_use(11, SchemaKind::Concrete, 3) },
    ];
    let sentence = explanation::in_a_sentence(&told);
    let wanted = "(no single schema achieves its target; schema 8 (move(j1=0.43, j2=0.84)), then schema 11 (close()) do together)";
    assert!(sentence.contains(wanted), "{sentence}");
    assert!(serde_json::to_string(&told).unwrap().contains("\"together\":[{\"id\":8,"));
}

fn a_prediction() -> Prediction {
    let gone = Condition { absent: true, ..condition(blue_in(ValueText::Integer(17)), 2, 15) };
    Prediction {
        body: "arm".to_owned(),
        action: "move(j1=0.43, j2=0.84)".to_owned(),
        world: vec![blue_in(ValueText::Integer(17))],
        attempts: 16,
        carried_out: 15,
        schema: Some(in_use(226, SchemaKind::Generalised, 17)),
        outcomes: vec![condition(observation("touch", &[]), 14, 15), gone],
        claims: Vec::new(),
    }
}

/// That the block is where the finger will be, with what followed there and elsewhere.
fn a_condition() -> ClaimEvidence {
    let reference = Reference::Effect { kind: "finger".to_owned(), property: "field".to_owned() };
    let named = ValueText::Named { named: Box::new(NamedValue { reference, more: 0.0 }) };
    let touched = Change { appears: vec![observation("touch", &[])], ..Change::default() };
    ClaimEvidence {
        condition: ClaimCondition::Observed(observation("object", &[("field", named)])),
        gain_bits: 18.25,
        trials_with: 15,
        trials_without: 45,
        outcomes: vec![
            OutcomeEvidence { change: Change::default(), with: 0, without: 45 },
            OutcomeEvidence { change: touched, with: 14, without: 0 },
        ],
    }
}

fn claims_foretold() -> Vec<Foretold> {
    let outcome = |appears: &[ObservationText], occurrences, (low, high)| JointOutcome {
        observed: appears.to_vec(),
        appears: appears.to_vec(),
        vanishes: Vec::new(),
        occurrences,
        probability: f64::from(occurrences) / 15.0,
        low,
        high,
    };
    let touched = Foretold {
        types: vec!["touch".to_owned()],
        each: false,
        view: ClaimView::General,
        because: vec![a_condition()],
        attributed: true,
        outcomes: vec![outcome(&[observation("touch", &[])], 14, (0.7, 0.99))],
        trials: 15,
    };
    let lamp = Foretold {
        types: vec!["lamp".to_owned()],
        each: false,
        view: ClaimView::Context,
        because: Vec::new(),
        attributed: false,
        outcomes: vec![outcome(&[observation("lamp", &[])], 9, (0.36, 0.8)), outcome(&[], 6, (0.2, 0.64))],
        trials: 15,
    };
    vec![touched, lamp]
}

#[test]
fn what_claims_foretell_as_text_and_json() {
    let prediction = Prediction { claims: claims_foretold(), ..a_prediction() };
    check_text("predict-claims.txt", &goals::prediction(&prediction));
    check_json("predict-claims.json", &prediction);
}

#[test]
fn claims_as_text_and_json() {
    let touched = Change { appears: vec![observation("touch", &[])], ..Change::default() };
    let tree = ClaimTree {
        action: Some("move".to_owned()),
        types: vec!["touch".to_owned()],
        each: false,
        claim: Claim {
            because: None,
            outcomes: vec![ClaimOutcome { change: Change::default(), occurrences: 45 }],
            trials: 45,
            exceptions: vec![Claim {
                because: Some(a_condition()),
                outcomes: vec![ClaimOutcome { change: touched, occurrences: 14 }],
                trials: 15,
                exceptions: Vec::new(),
            }],
        },
    };
    let event = |update, after| ItemEvent { action: "move(posture=3)".to_owned(), after, update };
    let item = SyntheticItem {
        name: "item-1".to_owned(),
        action: "move(posture=3)".to_owned(),
        types: vec!["touch".to_owned()],
        supposed_by: vec!["arm".to_owned()],
        events: vec![
            event(ItemUpdate::Off, Vec::new()),
            event(ItemUpdate::On, vec![observation("touch", &[])]),
        ],
    };
    let list = ClaimList { matching: 3, claims: vec![tree], items: vec![item] };
    check_text("claims.txt", &claims::list(&list, 1));
    check_json("claims.json", &list);
    let none = ClaimList { matching: 0, claims: Vec::new(), items: Vec::new() };
    assert_eq!(claims::list(&none, 0), "There are no claims yet: they come of experiences.\n");
}

fn wanted(goal: &[&str]) -> Wanted {
    Wanted { goal: goal.iter().map(|pattern| (*pattern).to_owned()).collect(), ..Wanted::default() }
}

fn a_plan() -> Plan {
    let stays = Condition { absent: true, ..condition(blue_in(ValueText::Integer(17)), 2, 15) };
    let step = PlanStep {
        action: in_use(226, SchemaKind::Generalised, 17).action,
        schema: Some(in_use(226, SchemaKind::Generalised, 17)),
        relies_on: vec![condition(observation("touch", &[]), 14, 15), stays],
        through: vec![condition(finger_in(ValueText::Integer(17)), 15, 15)],
        reliability: 0.94,
        probability: 0.76,
    };
    Plan {
        body: "arm".to_owned(),
        wanted: wanted(&["touch{}", "object{field=17}"]),
        world: vec![blue_in(ValueText::Integer(17))],
        state: PlanState::Found,
        probability: Some(0.76),
        expected: None,
        expected_actions: None,
        contexts: None,
        steps: vec![step],
        search_truncated: true,
    }
}

fn a_pursuit() -> Pursuit {
    let made = |after_actions, because| PursuitPlan {
        after_actions,
        because,
        probability: 0.76,
        expected: None,
        chain: vec![in_use(226, SchemaKind::Generalised, 17), in_use(12, SchemaKind::Concrete, 17)],
        course: Vec::new(),
        search_truncated: false,
    };
    Pursuit {
        number: 3,
        body: "arm".to_owned(),
        wanted: wanted(&["touch{}"]),
        state: PursuitState::Achieved,
        achieved: true,
        came: None,
        actions: 3,
        actions_max: 50,
        plans_made: 2,
        plans: vec![made(0, PlanCause::First), made(1, PlanCause::NextNotAllowed)],
    }
}

#[test]
fn a_prediction_as_text_and_json() {
    check_text("predict.txt", &goals::prediction(&a_prediction()));
    check_json("predict.json", &a_prediction());
    let unknown = Prediction { schema: None, outcomes: Vec::new(), attempts: 0, ..a_prediction() };
    let told = goals::prediction(&unknown);
    assert!(told.contains("Nothing that is known") && told.contains("never tried"), "{told}");
}

#[test]
fn a_plan_as_text_and_json() {
    check_text("plan.txt", &goals::plan(&a_plan()));
    check_json("plan.json", &a_plan());
    let none = Plan { probability: None, steps: Vec::new(), ..a_plan() };
    let told = goals::plan(&none);
    assert!(told.starts_with("Nothing known leads") && told.contains("budget"), "{told}");
    let holds = Plan { probability: Some(1.0), ..none };
    assert_eq!(goals::plan(&holds), "touch{} & object{field=17} holds already.\n");
}

#[test]
fn a_policy_as_text_and_json() {
    let chain = a_plan();
    let first = PlanStep {
        action: "grip()".to_owned(),
        schema: None,
        relies_on: vec![condition(observation("held", &[]), 8, 9)],
        through: Vec::new(),
        ..chain.steps[0].clone()
    };
    let second = PlanStep { through: Vec::new(), ..chain.steps[0].clone() };
    let policy = Plan {
        expected_actions: Some(2.4),
        contexts: Some(3),
        steps: vec![first, second],
        search_truncated: false,
        ..chain
    };
    check_text("policy.txt", &goals::plan(&policy));
    check_json("policy.json", &policy);
    let state = PlanState::FurtherThanLooked;
    let none = Plan { probability: None, state, steps: Vec::new(), search_truncated: true, ..a_plan() };
    assert!(goals::plan(&none).starts_with("Nothing leads from here to"), "{}", goals::plan(&none));
    let course = vec!["grip()".to_owned(), "move(posture=3)".to_owned()];
    let made = PursuitPlan { chain: Vec::new(), course: course.clone(), ..a_pursuit().plans[0].clone() };
    assert_eq!(goals::plan_made(&made), "Plan: grip(), then move(posture=3) (probability 0.76)");
    let (wanted, expected) = (wanted(&["touch{}"]), None);
    let followed = DecisionGoal { wanted, chain: Vec::new(), at: 0, course, probability: 0.76, expected };
    assert_eq!(
        goals::followed(&followed),
        "because it is what the policy says here for the goal touch{} (probability 0.76)"
    );
    assert!(goals::chain(&followed).contains("grip(), then move(posture=3)."));
}

#[test]
fn a_pursuit_as_talk_and_json() {
    let pursuit = a_pursuit();
    let talk: Vec<_> = pursuit.plans.iter().map(goals::plan_made).collect();
    check("achieve.talk", &(talk.join("\n") + "\n" + &goals::ending(&pursuit) + "\n"));
    check_json("achieve.json", &pursuit);
    for state in PursuitState::ALL.iter().copied() {
        let told = goals::ending(&Pursuit { state, ..a_pursuit() });
        assert!(told.contains("3 actions"), "{told}");
    }
}

#[test]
fn a_decision_for_a_goal_says_which_and_what_step_of_the_plan_it_is() {
    let goal = DecisionGoal {
        wanted: wanted(&["touch{}"]),
        chain: a_pursuit().plans[0].chain.clone(),
        at: 1,
        course: Vec::new(),
        probability: 0.76,
        expected: None,
    };
    let explained = Explanation { reason: Reason::Goal, goal: Some(goal), ..an_explanation() };
    check_text("explain-goal.txt", &explanation::explanation(&explained));
    let mut pursuing = a_status();
    pursuing.goal = Some(GoalSummary {
        number: 3,
        body: "arm".to_owned(),
        wanted: wanted(&["touch{}"]),
        actions: 1,
        actions_max: 50,
        came: None,
    });
    assert!(status::status(&pursuing).contains("3, pursued by arm: touch{}; 1 action of at most 50"));
}

#[test]
fn most_of_something_is_told_by_what_came_and_what_is_expected() {
    let most = || Wanted { most: Some("reward".to_owned()), ..Wanted::default() };
    let step =
        PlanStep { schema: None, through: Vec::new(), relies_on: Vec::new(), ..a_plan().steps[0].clone() };
    let (contexts, expected) = (Some(4), Some(12.345));
    let steps = vec![step];
    let plan = Plan { wanted: most(), probability: Some(0.0), expected, contexts, steps, ..a_plan() };
    check_text("most.txt", &goals::plan(&plan));
    check_json("most.json", &plan);
    let none = Plan { probability: None, state: PlanState::NothingBringsAny, steps: Vec::new(), ..plan };
    assert!(goals::plan(&none).starts_with("Nothing known from here brings any, of most reward."));
    let course = vec!["grip()".to_owned()];
    let made =
        PursuitPlan { chain: Vec::new(), course: course.clone(), expected, ..a_pursuit().plans[0].clone() };
    assert_eq!(goals::plan_made(&made), "Plan: grip() (12.35 expected)");
    let followed =
        DecisionGoal { wanted: most(), chain: Vec::new(), at: 0, course, probability: 0.0, expected };
    assert_eq!(
        goals::followed(&followed),
        "because it is what the policy says here for the goal most reward (12.35 expected)"
    );
    for state in PursuitState::ALL.iter().copied() {
        let pursuit = Pursuit { state, achieved: false, wanted: most(), came: Some(-3.5), ..a_pursuit() };
        let told = goals::ending(&pursuit);
        assert!(told.starts_with("most reward") && told.contains("-3.50 came in 3 actions"), "{told}");
    }
    let mut pursuing = a_status();
    pursuing.goal = Some(GoalSummary {
        number: 3,
        body: "arm".to_owned(),
        wanted: most(),
        actions: 1,
        actions_max: 50,
        came: Some(1.0),
    });
    let told = status::status(&pursuing).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(told.contains("most reward; 1 action of at most 50, in which 1.00 came"), "{told}");
    let again = Wanted { again: true, ..wanted(&["touch{}"]) };
    assert_eq!(goals::wanted(&again), "touch{} again");
}
