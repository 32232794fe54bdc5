//! `predict`, `plan` and `achieve` for people.

use pschema_inspect::{
    Condition, DecisionGoal, GoalSummary, ObservationText, Plan, PlanCause, PlanState, PlanStep, Prediction,
    Pursuit, PursuitPlan, PursuitState, SchemaInUse, Wanted,
};
use pschema_learner::notation::side;

use super::claims;
use super::schema::wrapped;
use super::table::Columns;
use super::words::{binding, condition, count, figure, notation, plain, probability, with_values};

/// A prediction.
pub(crate) fn prediction(p: &Prediction) -> String {
    let (body, action) = (plain(&p.body), plain(&p.action));
    if !p.claims.is_empty() {
        let text = wrapped(&format!("{action} of {body}, as claims foretell it:"), "");
        return format!("{text}{}\n{}{}", claims::foretold(&p.claims, false), here(&p.world), carried_out(p));
    }
    let Some(schema) = &p.schema else {
        let text = format!("Nothing that is known says what {action} of {body} would do here.");
        return wrapped(&text, "") + &here(&p.world) + &carried_out(p);
    };
    let mut text = wrapped(&format!("{action} of {body}, by {}:", in_use(schema)), "");
    let mut table = Columns::new(&["then", "probability"]);
    for outcome in &p.outcomes {
        table.row([condition(outcome), counted(outcome)]);
    }
    text.push_str(&format!("\n{}", table.text(&[1])));
    text + &here(&p.world) + &carried_out(p)
}

fn carried_out(p: &Prediction) -> String {
    match (p.attempts, p.carried_out) {
        (0, _) => "It was never tried.\n".to_owned(),
        (all, done) if all == done => format!("It was carried out whenever asked for, {all} of {all}.\n"),
        (all, done) => format!("It was carried out {done} of the {all} times that it was asked for.\n"),
    }
}

fn here(world: &[ObservationText]) -> String {
    wrapped(&format!("Perceived now: {}.", side(world.iter().map(notation))), "")
}

fn counted(c: &Condition) -> String {
    probability(c.probability, c.occurrences, c.trials, c.low, c.high)
}

/// A plan.
pub(crate) fn plan(p: &Plan) -> String {
    let goal = wanted(&p.wanted);
    let budget = if p.search_truncated {
        "The search used up its budget: there may be a way that it did not come to.\n"
    } else {
        ""
    };
    let Some(likely) = p.probability else {
        let text = match p.state {
            PlanState::FurtherThanLooked => {
                format!("Nothing leads from here to {goal} as far as was looked.")
            }
            PlanState::NothingBringsAny => format!("Nothing known from here brings any, of {goal}."),
            _ => format!("Nothing known leads from here to {goal}."),
        };
        return wrapped(&text, "") + &here(&p.world) + budget;
    };
    if p.steps.is_empty() {
        return wrapped(&format!("{goal} holds already."), "");
    }
    let mut text = wrapped(&format!("{goal} {}:", means(p, likely)), "");
    for (at, step) in p.steps.iter().enumerate() {
        let schema = step.schema.as_ref().map_or_else(String::new, |schema| format!(": {}", in_use(schema)));
        let line = format!("{}. {}{schema}", at + 1, plain(&step.action));
        text.push_str(&format!("\n{}", wrapped(&line, "   ")));
        if p.contexts.is_some() {
            text.push_str(&foretold(step));
            continue;
        }
        let mut table = Columns::new(&["   relies on", "probability"]);
        for relied in step.through.iter().chain(&step.relies_on) {
            table.row([format!("   {}", relied_on(relied)), counted_on(relied)]);
        }
        table.row(["   that it is carried out".to_owned(), figure(step.reliability, 2)]);
        text.push_str(&table.text(&[1]));
    }
    format!("{text}\n{}{budget}", here(&p.world))
}

/// How a plan brings its goal about, and how surely.
fn means(p: &Plan, likely: f64) -> String {
    let (body, likely) = (plain(&p.body), figure(likely, 2));
    let steps = count(u64::try_from(p.steps.len()).unwrap_or(u64::MAX), "step");
    if let Some((expected, contexts)) = p.expected.zip(p.contexts) {
        let contexts = count(contexts, "context");
        return format!(
            "by {body}: a policy for {contexts}, which is expected to bring {} (what comes an action later counts 0.99 times as much). If \
             all comes about that is most likely, it begins with {steps}",
            figure(expected, 2)
        );
    }
    match p.expected_actions.zip(p.contexts) {
        Some((actions, contexts)) => {
            let contexts = count(contexts, "context");
            format!(
                "by {body}, probability {likely}: a policy for {contexts}, which is expected to take {} actions. If all comes \
                 about that is most likely, in {steps}",
                figure(actions, 1)
            )
        }
        None => format!("by {body} in {steps}, probability {likely}"),
    }
}

/// What is foretold of a step of a policy.
fn foretold(step: &PlanStep) -> String {
    let mut table = Columns::new(&["   then", "probability"]);
    for change in &step.relies_on {
        table.row([format!("   {}", condition(change)), counted(change)]);
    }
    table.row(["   that it leads to the next step".to_owned(), figure(step.probability, 2)]);
    table.text(&[1])
}

/// A condition that is relied on: that it holds, or that it does not end as it sometimes does.
fn relied_on(c: &Condition) -> String {
    if c.absent { format!("{} stays", notation(&c.observation)) } else { notation(&c.observation) }
}

fn counted_on(c: &Condition) -> String {
    if !c.absent {
        return counted(c);
    }
    let stayed = c.trials.saturating_sub(c.occurrences);
    probability(1.0 - c.probability, stayed, c.trials, 1.0 - c.high, 1.0 - c.low)
}

/// Patterns as they are written.
fn patterns(patterns: &[String]) -> String {
    side(patterns.iter().map(|pattern| plain(pattern)))
}

/// What is wanted: `touch{}`, `touch{} again`, `most reward`.
pub(crate) fn wanted(wanted: &Wanted) -> String {
    match &wanted.most {
        Some(most) => format!("most {}", plain(most)),
        None if wanted.again => format!("{} again", patterns(&wanted.goal)),
        None => patterns(&wanted.goal),
    }
}

/// What was done for a goal, and what came: `7 of at most 50 actions, in which 3.5 came`.
pub(crate) fn done(goal: &GoalSummary) -> String {
    let came = goal.came.map_or_else(String::new, |came| format!(", in which {} came", figure(came, 2)));
    format!("{} of at most {}{came}", count(goal.actions, "action"), goal.actions_max)
}

/// A schema with its binding: `schema 226 (generalised), with $a=blue, $b=17`.
fn in_use(s: &SchemaInUse) -> String {
    let carrier = s.carrier.map_or_else(String::new, |carrier| format!(", through schema {carrier}"));
    format!("schema {} ({}), {}{carrier}", s.id, s.kind, with_values(&s.text, &s.binding))
}

/// A plan made in pursuit of a goal, as a line of the talk.
pub(crate) fn plan_made(plan: &PursuitPlan) -> String {
    let because = match plan.because {
        PlanCause::First => None,
        PlanCause::NotReached => Some("the last one was carried through and the goal does not hold"),
        PlanCause::NextNotAllowed => Some("the last step's outcome does not allow the next"),
        PlanCause::NotCarriedOut => Some("the body did not carry out the action"),
        PlanCause::Interrupted => Some("it was interrupted"),
    };
    let after = count(plan.after_actions, "action");
    let why = because.map_or_else(
        || "Plan".to_owned(),
        |because| format!("Another plan after {after}, because {because}"),
    );
    let chain: Vec<_> = if plan.course.is_empty() {
        plan.chain.iter().map(link).collect()
    } else {
        plan.course.iter().map(|action| plain(action)).collect()
    };
    let budget = if plan.search_truncated { "; the search used up its budget" } else { "" };
    let likely = likely(plan.probability, plan.expected);
    format!("{why}: {} ({likely}{budget})", chain.join(", then "))
}

/// How surely a plan brings its goal about, or how much it is expected to bring.
fn likely(probability: f64, expected: Option<f64>) -> String {
    match expected {
        Some(expected) => format!("{} expected", figure(expected, 2)),
        None => format!("probability {}", figure(probability, 2)),
    }
}

fn link(s: &SchemaInUse) -> String {
    let with = binding(&s.binding);
    let with = if with.is_empty() { String::new() } else { format!(" with {with}") };
    format!("schema {}{with} by {}", s.id, plain(&s.action))
}

/// The state of a pursuit, as a sentence without its full stop.
pub(crate) fn ending(p: &Pursuit) -> String {
    let (goal, actions) = (wanted(&p.wanted), count(p.actions, "action"));
    if let Some(came) = p.came {
        return most(p, &goal, &format!("{} came in {actions}", figure(came, 2)));
    }
    match p.state {
        PursuitState::Achieved if p.actions == 0 => format!("{goal} holds already"),
        PursuitState::Achieved => format!("{goal} was achieved with {actions}"),
        PursuitState::NothingLeadsThere => {
            format!("{goal} was given up after {actions}: nothing known leads there from here")
        }
        PursuitState::FurtherThanLooked => {
            format!("{goal} was given up after {actions}: nothing leads there from here as far as was looked")
        }
        PursuitState::ActionsUsedUp => {
            format!("{goal} does not hold after {actions}, all it may take: allow more with --actions-max")
        }
        PursuitState::NothingBringsAny => {
            format!("{goal} was given up after {actions}: nothing known brings any")
        }
        PursuitState::Constrained => {
            format!(
                "{goal} was given up after {actions}: the stage entered meanwhile does not lift what it speaks of"
            )
        }
        PursuitState::Cancelled => format!("{goal} was called off after {actions}"),
        PursuitState::Pursued => format!("{goal} is pursued, {actions} so far"),
    }
}

/// The state of a pursuit of most of something, of which so much came.
fn most(p: &Pursuit, goal: &str, came: &str) -> String {
    match p.state {
        PursuitState::Pursued => format!("{goal} is pursued: {came} so far"),
        PursuitState::ActionsUsedUp => format!("{goal}: {came}, all it may take"),
        PursuitState::Cancelled => format!("{goal}: {came}, and it was called off"),
        PursuitState::FurtherThanLooked => {
            format!("{goal}: {came}, and it was given up: nothing brings any from here as far as was looked")
        }
        PursuitState::Constrained => {
            format!(
                "{goal}: {came}, and it was given up: the stage entered meanwhile does not lift what it speaks of"
            )
        }
        PursuitState::Achieved | PursuitState::NothingLeadsThere | PursuitState::NothingBringsAny => {
            format!("{goal}: {came}, and it was given up: nothing known brings any from here")
        }
    }
}

/// The goal that a decision follows, as a clause.
pub(crate) fn followed(f: &DecisionGoal) -> String {
    let (at, all) = (f.at.saturating_add(1), f.chain.len());
    let step = match f.course.len() {
        0 if all == 1 => "the plan".to_owned(),
        0 => format!("step {at} of {all} of the plan"),
        _ => "what the policy says here".to_owned(),
    };
    let likely = likely(f.probability, f.expected);
    format!("because it is {step} for the goal {} ({likely})", wanted(&f.wanted))
}

/// The chain that a decision follows, with the executed schema marked.
pub(crate) fn chain(f: &DecisionGoal) -> String {
    if !f.course.is_empty() {
        let course: Vec<_> = f.course.iter().map(|action| plain(action)).collect();
        return wrapped(&format!("If all comes about that is most likely: {}.", course.join(", then ")), "");
    }
    let mut table = Columns::new(&["", "schema", "plan", "action"]).figures(&[1]);
    for (at, s) in f.chain.iter().enumerate() {
        let mark = if u32::try_from(at).is_ok_and(|at| at == f.at) { ">" } else { "" };
        table.row([mark.to_owned(), s.id.to_string(), with_values(&s.text, &s.binding), plain(&s.action)]);
    }
    table.text(&[0, 1])
}
