//! A learner made up for the tests: what a daemon could have answered after the first touches.

use pschema_inspect::*;
use pschema_protocol::picture::FieldMark;

use super::super::WatchPage;
use super::super::state::{News, State};

pub(super) fn observation(kind: &str, properties: &[(&str, ValueText)]) -> ObservationText {
    let properties = properties.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    ObservationText { kind: kind.to_owned(), properties }
}

pub(super) fn colour(name: &str) -> (&'static str, ValueText) {
    ("colour", ValueText::Symbol(name.to_owned()))
}

pub(super) fn field(number: i64) -> (&'static str, ValueText) {
    ("field", ValueText::Integer(number))
}

fn perceived(observation: ObservationText, new: bool, attention: u32) -> WorldObservation {
    WorldObservation { observation, new, attention }
}

fn body(id: u64, name: &str, state: BodyState) -> BodyStatus {
    BodyStatus {
        id,
        name: name.to_owned(),
        kind: "arm with a finger under a camera".to_owned(),
        pid: 4242,
        state,
        frames: 1_290,
        frames_refused: 0,
        last_refusal: None,
        last_failure: None,
        episodes_ended: 0,
        episodes_cut: 0,
        warnings: Vec::new(),
    }
}

pub(super) fn schema(id: u32, kind: SchemaKind, executions: u32) -> SchemaSummary {
    let general = kind == SchemaKind::Generalised;
    let field = if general { "$b".to_owned() } else { id.to_string() };
    SchemaSummary {
        id,
        kind,
        pre: if general { vec![format!("object{{colour=$a, field={field}}}")] } else { Vec::new() },
        action: if general {
            format!("achieve finger{{field={field}}}")
        } else {
            "move(j1=0.43, j2=0.84)".to_owned()
        },
        post: if general {
            vec![format!("finger{{colour=green, field={field}}}"), "touch{}".to_owned()]
        } else {
            vec![format!("finger{{colour=green, field={field}}}")]
        },
        post_shares: vec![Some(1.0); if general { 2 } else { 1 }],
        executions,
        successes: executions,
        probability: 1.0,
        low: 0.34,
        high: 1.0,
    }
}

fn term(
    role: TermRole,
    remembered: ObservationText,
    seen: ObservationText,
    shared: u32,
    attention: u32,
) -> ExcitationTerm {
    let weight = if role == TermRole::Association { 0.8 } else { 1.0 };
    ExcitationTerm {
        observation: Some(remembered),
        seen: Some(seen),
        role,
        shared,
        attention,
        probability: 1.0,
        weight,
        value: f64::from(shared) * weight / f64::from(1 + attention),
    }
}

fn explanation() -> Explanation {
    let block = observation("object", &[colour("blue"), field(104)]);
    let pattern = observation("object", &[("colour", ValueText::variable("a"))]);
    let word = observation("word", &[("text", ValueText::Symbol("touch".to_owned()))]);
    let finger = observation("finger", &[colour("green"), field(104)]);
    let terms = vec![
        term(TermRole::PreCondition, block.clone(), block.clone(), 2, 0),
        term(TermRole::Association, word.clone(), word, 1, 1),
    ];
    let sum: f64 = terms.iter().map(|term| term.value).sum();
    let touching = Candidate {
        schema: Some(226),
        text: "object{colour=$a, field=$b} / achieve finger{field=$b} / finger{field=$b} & touch{}"
            .to_owned(),
        form: SchemaForm::default(),
        binding: NamedValues(vec![("a".to_owned(), colour("blue").1), ("b".to_owned(), field(104).1)]),
        together: Vec::new(),
        distance: 1,
        excitation: sum,
        terms,
    };
    let drive = ExcitationTerm {
        observation: None,
        seen: None,
        role: TermRole::Babbling,
        shared: 1,
        attention: 0,
        probability: 1.0,
        weight: 0.5,
        value: 0.5,
    };
    let reaching = Candidate {
        schema: Some(17),
        text: "move(j1=0.43, j2=0.84) / finger{colour=green, field=104}".to_owned(),
        form: SchemaForm::default(),
        binding: NamedValues::default(),
        together: Vec::new(),
        distance: 2,
        excitation: 0.25,
        terms: vec![term(TermRole::PostCondition, finger, block.clone(), 1, 3), drive],
    };
    Explanation {
        step: 1_234,
        body: "sim-1".to_owned(),
        world: vec![block, pattern],
        chosen: 0,
        action: "move(j1=0.43, j2=0.84)".to_owned(),
        reason: Reason::Excitation,
        ties: 1,
        candidates_total: 229,
        candidates: vec![touching, reaching],
        goal: None,
        claims: Vec::new(),
    }
}

/// A step of the life: a word now and then, a touch after it, and excitation that wears off.
fn record(number: u64) -> TraceRecord {
    let phase = number % 40;
    let touching = (1..6).contains(&phase);
    let excitation_top = 2.5 / (1.0 + phase as f64 / 4.0);
    let touched = if touching { vec![observation("touch", &[])] } else { Vec::new() };
    TraceRecord {
        step: number + 1,
        stage: 1,
        trial: 1,
        drawn: if number % 80 == 20 { vec![7] } else { Vec::new() },
        trial_met: (phase == 5).then_some(true),
        actions: number,
        schemas_total: 226 + u32::from(number >= 1_233),
        schemas_generalised: 1,
        failure: None,
        perceived: touched,
        heard: if phase == 0 { vec!["touch".to_owned()] } else { Vec::new() },
        decision: Some(TraceDecision {
            excitation_top,
            excitation: excitation_top,
            schema: Some(if touching { 226 } else { 17 }),
            generalised: touching,
            distance: 1,
            action: "move(j1=0.43, j2=0.84)".to_owned(),
            reason: Reason::Excitation,
            predicts: vec![if touching { "touch" } else { "finger" }.to_owned()],
        }),
        quiet_actions: 3,
        habituating: false,
        latency_us: 55.0,
    }
}

pub(super) fn trace(from: u64, to: u64) -> TracePage {
    let stages = ["babbling", "first touches"].map(str::to_owned).to_vec();
    TracePage { from, total: to, kept_max: 65_536, stages, records: (from..to).map(record).collect() }
}

pub(super) fn live() -> Live {
    let observations = vec![
        perceived(observation("finger", &[colour("green"), field(104)]), true, 4),
        perceived(observation("object", &[colour("blue"), field(104)]), false, 12),
        perceived(observation("object", &[colour("red"), field(31)]), true, 0),
        perceived(observation("touch", &[]), true, 2),
    ];
    let world = observations.iter().map(|one| crate::render::words::notation(&one.observation)).collect();
    let status = Status {
        name: "default".to_owned(),
        pid: 4711,
        uptime_s: 754.0,
        step: 1_234,
        durable_step: Some(1_233),
        profile: "full".to_owned(),
        curriculum: "exp2".to_owned(),
        stage: "first touches".to_owned(),
        stage_state: StageState::Acting,
        saturation: Some(SaturationStatus {
            quiet_actions: 3,
            quiet_actions_wanted: 10,
            saturation_below: 0.2,
        }),
        habituation: Some(HabituationStatus { habituation_left: None, executions_min: 1, interval_max: 0.0 }),
        trial: Some(TrialStatus {
            trial: 1,
            trials_wanted: 2,
            open: true,
            actions: 4,
            actions_max: Some(50),
        }),
        schemas_total: 227,
        schemas_concrete: 226,
        schemas_generalised: 1,
        bodies: vec![
            BodyStatus {
                last_failure: Some(OrderFailure {
                    outcome: FailedOutcome::Refused,
                    reason: Some("the arm does not reach 0.1, 2.7".to_owned()),
                    step: 1_200,
                }),
                ..body(3, "sim-1", BodyState::Attached)
            },
            body(1, "sim-1", BodyState::Left),
        ],
        steps_per_s: 12.3,
        step_latency_us_p50: 55.0,
        step_latency_us_p99: 180.0,
        commit_latency_us_p50: 175.0,
        commit_latency_us_p99: 311.0,
        memory_bytes: 48 << 20,
        memory_max_bytes: None,
        memory_full: false,
        growth: Vec::new(),
        memory_digest: None,
        excitation_top: 2.5,
        world,
        goal: None,
        storage: None,
        refused: Vec::new(),
        log_lines_lost: 0,
    };
    Live {
        status,
        observations,
        explanation: Some(explanation()),
        newest: vec![
            schema(226, SchemaKind::Generalised, 2),
            schema(225, SchemaKind::Concrete, 1),
            schema(224, SchemaKind::Concrete, 1),
        ],
        trace: trace(1_134, 1_234),
    }
}

/// A hexagonal grid like that of the wide world: 41 columns of places, 19 rows.
pub(super) fn fields() -> Vec<FieldMark> {
    let mut fields = Vec::new();
    for row in 0..19u8 {
        let (shift, count) = if row % 2 == 0 { (10.0, 20u8) } else { (-10.0, 21) };
        for column in 0..count {
            let (x_px, y_px) = (f32::from(column) * 40.0 + shift, f32::from(row) * 34.64 - 22.0);
            fields.push(FieldMark { x_px, y_px, radius_px: 23.0 });
        }
    }
    fields
}

pub(super) fn detail(executions: u32) -> SchemaDetail {
    let b = || ("field", ValueText::variable("b"));
    let object = observation("object", &[("colour", ValueText::variable("a")), b()]);
    let finger = observation("finger", &[b()]);
    let sure = |observation| Condition {
        observation,
        absent: false,
        occurrences: executions,
        trials: executions,
        probability: 1.0,
        low: 0.34,
        high: 1.0,
    };
    SchemaDetail {
        id: 226,
        kind: SchemaKind::Generalised,
        action: String::new(),
        target: vec![finger.clone()],
        pre: vec![object.clone()],
        post: vec![sure(finger), sure(object), sure(observation("touch", &[]))],
        associated: vec![sure(observation("word", &[("text", ValueText::Symbol("touch".to_owned()))]))],
        executions,
        successes: executions,
        probability: 1.0,
        low: 0.34,
        high: 1.0,
        parent: Some(17),
        contradicts: None,
        examples: vec![224, 225],
        counter_examples: Vec::new(),
        created_step: 230,
        claims: Vec::new(),
    }
}

/// Somebody who watches it.
pub(super) fn state(page: WatchPage) -> State {
    let mut state = State::new(page);
    state.receive(News::Attached);
    state.receive(News::Live(Box::new(live())));
    state.receive(News::Fields { session: 3, fields: fields() });
    let schemas = vec![
        schema(17, SchemaKind::Concrete, 31),
        schema(226, SchemaKind::Generalised, 12),
        schema(4, SchemaKind::Concrete, 2),
    ];
    state.receive(News::MostUsed(SchemaList { matching: 227, schemas }));
    state
}
