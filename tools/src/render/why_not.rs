//! `explain --why-not` for people: the obstacle in a schema's way, then both sides of the comparison.

use pschema_inspect::{
    Candidate, ObservationText, Reason, SchemaKind, TermRole, UnmetCondition, Verdict, WhyNot,
};
use pschema_learner::notation::side;

use super::claims;
use super::explanation::{named, perceived, shown, sum, terms};
use super::schema::wrapped;
use super::table::Columns;
use super::words::{bound, capitalised, form_notation, notation, plain, value};

/// Why a schema was not executed.
pub fn why_not(why: &WhyNot) -> String {
    let mut text = wrapped(&sentence(why), "");
    for more in [unreliable(why), habituated(why), truncated(why)].into_iter().flatten() {
        text.push_str(&wrapped(&more, ""));
    }
    text.push_str(&format!("\n{}", wrapped(&heading(why), "")));
    text.push_str(&format!("\n{}", perceived(&why.world)));
    if let Verdict::OtherClaims { claims } = &why.verdict {
        let foretold = claims::foretold(claims, true);
        text.push_str(&format!("\nWhat the claims in force foretell of its action here:\n{foretold}"));
    }
    if let Some(candidate) = &why.candidate
        && why.verdict != Verdict::Chosen
    {
        text.push_str(&format!("\n{}", beside(why, candidate)));
        text.push_str(&format!("\nSchema {}:\n{}", why.schema, terms(candidate, &why.world)));
        text.push_str(&format!(
            "\n{}:\n{}",
            capitalised(&named(&why.chosen)),
            terms(&why.chosen, &why.world)
        ));
    }
    text
}

fn sentence(why: &WhyNot) -> String {
    let (schema, step) = (why.schema, why.step);
    let action = plain(&why.action);
    let instead = match why.chosen.schema {
        Some(id) => format!("schema {id} was executed instead ({action})"),
        None => format!("{action} was tried instead"),
    };
    let instead = capitalised(&instead);
    let not = |reason: String| format!("Schema {schema} was not executed in step {step}: {reason}");
    match &why.verdict {
        Verdict::Chosen => format!("Schema {schema} is what was chosen in step {step} ({action})."),
        Verdict::ExecutedFor { schema: other } => format!(
            "Schema {schema} was executed in step {step}, for the sake of schema {other}: it is what carries out that \
             one's target, or the first of a chain to it."
        ),
        Verdict::NotWeighed => not(format!(
            "{} was being followed, so that nothing else was weighed. {}.",
            if why.reason == Reason::Goal { "a plan for a goal" } else { "a chain begun before" },
            instead
        )),
        Verdict::Retired => {
            not(format!("it is retired. It failed too often, and is never chosen again. {}.", instead))
        }
        Verdict::NotInRepertoire => not(format!("{} can't do its action. {}.", plain(&why.body), instead)),
        Verdict::PreConditions { lacking } => {
            let reasons: Vec<_> = lacking.iter().map(missing).collect();
            let chain = if why.kind == SchemaKind::Generalised {
                ""
            } else {
                " No chain that is known leads from here to where it holds."
            };
            not(format!("{}.{chain} {}.", reasons.join("; "), instead))
        }
        Verdict::TargetNotAchievable { target } => not(format!(
            "nothing that is known achieves its target {} from here. {}.",
            side(target.iter().map(notation)),
            instead
        )),
        Verdict::StoodInFor { by, kind } => not(format!(
            "schema {by}, {} for exactly this case, is selected instead (paper, IV-A).",
            if *kind == SchemaKind::CounterExample { "a counter-example" } else { "a concrete schema" }
        )),
        Verdict::OtherClaims { claims } => {
            let conditions: Vec<_> = claims.iter().flat_map(|facet| &facet.because).collect();
            let told: Vec<_> = conditions.iter().map(|one| claims::condition(&one.condition)).collect();
            let others = match told.is_empty() {
                true => "none of the conditions that it needs holds for its action here".to_owned(),
                false => {
                    format!("another claim is in force for its action here, because {}", told.join(" and "))
                }
            };
            not(format!("{others}. {instead}."))
        }
        Verdict::NotExciting => not(format!(
            "nothing that was perceived shares a value with what it remembers, so that its excitation is 0. {}.",
            instead
        )),
        Verdict::LessExciting { by } => not(format!(
            "{} was more exciting by {}: E = {} against {}{}.",
            named(&why.chosen),
            shown(*by),
            shown(why.chosen.excitation),
            why.candidate.as_ref().map_or_else(|| shown(0.0), |candidate| shown(candidate.excitation)),
            far(why)
        )),
        Verdict::LotFellOnAnother => not(format!(
            "{} candidates were equally exciting (E = {}), and the lot fell on {}{}.",
            why.ties,
            shown(why.chosen.excitation),
            named(&why.chosen),
            far(why)
        )),
    }
}

/// The chain that would have led to the schema, when it could not be executed at once.
fn far(why: &WhyNot) -> String {
    let distance = why.candidate.as_ref().map_or(1, |candidate| candidate.distance);
    let chain: Vec<_> = why.chain.iter().map(|link| format!("schema {}", link.id)).collect();
    match chain.is_empty() {
        true => String::new(),
        false => format!(
            "; it can be executed only after {}, so that its excitation is divided by {distance}",
            chain.join(", then ")
        ),
    }
}

/// A pre-condition that does not hold, with the observation that comes nearest to it.
fn missing(lacking: &UnmetCondition) -> String {
    let wanted = notation(&lacking.wanted);
    if lacking.constrained {
        return format!(
            "its pre-condition {wanted} can't be perceived, because the stage does not lift {}",
            plain(&lacking.wanted.kind)
        );
    }
    let Some(nearest) = &lacking.nearest else {
        return format!("its pre-condition {wanted} does not hold; nothing of that type was perceived");
    };
    let seen = |property: &String| {
        let of = |observation: &ObservationText| {
            observation.properties.get(property).map_or_else(|| "none".to_owned(), value)
        };
        format!("{} {} wanted, {} seen", plain(property), of(&lacking.wanted), of(nearest))
    };
    let differs: Vec<_> = lacking.differs.iter().map(seen).collect();
    let differs = match differs.is_empty() {
        true => "which does not fit the other pre-conditions".to_owned(),
        false => differs.join(", "),
    };
    format!("its pre-condition {wanted} does not hold. The nearest is {}: {differs}", notation(nearest))
}

fn unreliable(why: &WhyNot) -> Option<String> {
    (why.carried_out < why.attempts).then(|| {
        format!(
            "Its action is not reliable: it was carried out {} of {} times, and counts for the less.",
            why.carried_out, why.attempts
        )
    })
}

fn habituated(why: &WhyNot) -> Option<String> {
    Some(match why.habituated? {
        true => "The stage is being habituated to, and this schema is known well enough: there is no drive to repeat it.".to_owned(),
        false => "The stage is being habituated to, and there is a drive to repeat this schema.".to_owned(),
    })
}

fn truncated(why: &WhyNot) -> Option<String> {
    why.search_truncated
        .then(|| "The search for chains used up its budget, so that there may be more.".to_owned())
}

fn heading(why: &WhyNot) -> String {
    let text = form_notation(&bound(&why.form, &why.binding));
    let bindings = match why.bindings {
        0 | 1 => String::new(),
        n => format!(" (the nearest of {n} bindings)"),
    };
    format!("Schema {}, {}: {text}{bindings}", why.schema, why.kind)
}

/// Both excitations side by side, added up by the role of the terms.
fn beside(why: &WhyNot, asked: &Candidate) -> String {
    let mut table =
        Columns::new(&["", &format!("schema {}", why.schema), &named(&why.chosen)]).figures(&[1, 2]);
    let part = |candidate: &Candidate, role: TermRole| {
        candidate.terms.iter().filter(|term| term.role == role).fold(0.0, |sum, term| sum + term.value)
    };
    for role in TermRole::ALL.iter().copied() {
        let (a, b) = (part(asked, role), part(&why.chosen, role));
        if a != 0.0 || b != 0.0 {
            table.row([role.to_string(), shown(a), shown(b)]);
        }
    }
    table.row(["sum".to_owned(), shown(sum(asked)), shown(sum(&why.chosen))]);
    table.row(["distance".to_owned(), asked.distance.to_string(), why.chosen.distance.to_string()]);
    table.row(["E".to_owned(), shown(asked.excitation), shown(why.chosen.excitation)]);
    table.text(&[1, 2])
}
