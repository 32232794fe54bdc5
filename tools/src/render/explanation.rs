//! `explain` for people: a sentence first, then the sum that made it so.

use pschema_protocol::inspect::{Candidate, ExcitationTerm, Explanation, ObservationText};

use super::goals;
use super::schema::wrapped;
use super::table::Columns;
use super::words::{binding, notation, plain};

/// Why an action was chosen.
pub(crate) fn explanation(e: &Explanation) -> String {
    let Some(chosen) = usize::try_from(e.chosen).ok().and_then(|at| e.candidates.get(at)) else {
        return format!("Step {}: {} (the daemon did not say why)\n", e.step, plain(&e.action));
    };
    let mut text = wrapped(&sentence(e, chosen), "");
    text.push_str(&format!("\n{}", perceived(&e.world)));
    text.push_str(&format!("\n{}\n{}", heading(chosen), terms(chosen, &e.world)));
    if let Some(goal) = &e.goal {
        text.push_str(&format!("\n{}", goals::chain(goal)));
    }
    text.push_str(&others(e));
    text
}

fn sentence(e: &Explanation, chosen: &Candidate) -> String {
    let because = match e.reason.as_str() {
        "goal" => e.goal.as_ref().map_or_else(|| "for a goal".to_owned(), goals::followed),
        "chain" => "because it is the next of a chain begun before".to_owned(),
        "tie" => format!(
            "because {} candidates were equally exciting (E = {:.3}) and the lot fell on it",
            e.ties, chosen.excitation
        ),
        "excitation" => {
            format!("because nothing else was as exciting: E = {:.3}{}", chosen.excitation, rival(e, chosen))
        }
        other => format!("because of {} (E = {:.3})", plain(other), chosen.excitation),
    };
    // What is done for a goal is done whatever it excites.
    let exciting = strongest(chosen).filter(|_| e.goal.is_none());
    let why = exciting.map_or_else(String::new, |term| format!("; above all, {}", told(term)));
    let (step, body, action) = (e.step, plain(&e.body), plain(&e.action));
    format!("In step {step}, {body} was sent to {action}, {because}{why}.")
}

fn rival(e: &Explanation, chosen: &Candidate) -> String {
    let next =
        e.candidates.iter().filter(|c| !std::ptr::eq(*c, chosen)).map(|c| c.excitation).reduce(f64::max);
    next.map_or_else(String::new, |next| format!(", the next {next:.3}"))
}

fn strongest(candidate: &Candidate) -> Option<&ExcitationTerm> {
    // The rest is many terms in one: none of them is the strongest for that.
    let terms = candidate.terms.iter().filter(|term| term.role != "rest");
    terms.max_by(|a, b| a.value.total_cmp(&b.value))
}

/// A term as a clause.
fn told(term: &ExcitationTerm) -> String {
    match (&term.observation, &term.seen, term.role.as_str()) {
        (Some(remembered), Some(seen), role) => {
            let (remembered, seen) = (notation(remembered), notation(seen));
            let attended = match term.attention {
                0 => "which never had attention before".to_owned(),
                1 => "which had attention once".to_owned(),
                n => format!("which had attention {n} times"),
            };
            format!(
                "{seen} was perceived and resembles the schema's {} {remembered}, {attended}",
                plain(role)
            )
        }
        (_, _, "babbling") => "it had never been tried here".to_owned(),
        (_, _, "habituation") => "it had not been repeated often enough to be sure of".to_owned(),
        (_, _, role) => format!("of its {}", plain(role)),
    }
}

fn heading(chosen: &Candidate) -> String {
    let subject = match chosen.schema {
        Some(id) => format!("Schema {id}: {}", plain(&chosen.text)),
        None => format!("Primitive {}", plain(&chosen.text)),
    };
    let with = binding(&chosen.binding);
    let subject = if with.is_empty() { subject } else { format!("{subject}, with {with}") };
    wrapped(&subject, "")
}

/// What was perceived, numbered for the terms to refer to.
fn perceived(world: &[ObservationText]) -> String {
    if world.is_empty() {
        return "Nothing was perceived.\n".to_owned();
    }
    let mut table = Columns::new(&["", "perceived"]).figures(&[0]);
    for (at, observation) in world.iter().enumerate() {
        table.row([format!("#{}", at + 1), notation(observation)]);
    }
    table.text(&[0])
}

/// The terms, and their sum as it makes the excitation.
fn terms(chosen: &Candidate, world: &[ObservationText]) -> String {
    let headings = ["term", "remembered", "seen", "same", "prob", "weight", "1+n", "value"];
    let mut table = Columns::new(&headings).figures(&[3, 4, 5, 6, 7]);
    for t in &chosen.terms {
        let remembered = t.observation.as_ref().map_or_else(|| "-".to_owned(), notation);
        let number =
            |o: &ObservationText| world.iter().position(|seen| seen == o).map(|at| format!("#{}", at + 1));
        let seen =
            t.seen.as_ref().map_or_else(|| "-".to_owned(), |o| number(o).unwrap_or_else(|| notation(o)));
        table.row([
            plain(&t.role),
            remembered,
            seen,
            t.shared.to_string(),
            format!("{:.2}", t.probability),
            format!("{:.2}", t.weight),
            (u64::from(t.attention) + 1).to_string(),
            format!("{:.3}", t.value),
        ]);
    }
    let sum: f64 = chosen.terms.iter().map(|term| term.value).sum();
    let (d, e) = (chosen.distance, chosen.excitation);
    let table = if chosen.terms.is_empty() { String::new() } else { table.text(&[3, 4, 5, 6, 7]) };
    format!("{table}\nvalue = same x prob x weight / (1+n)    sum {sum:.3} / distance {d} = E {e:.3}\n")
}

fn others(e: &Explanation) -> String {
    if e.candidates.len() < 2 {
        return String::new();
    }
    let mut table = Columns::new(&["", "schema", "candidate", "distance", "e"]).figures(&[1, 3, 4]);
    for (at, c) in e.candidates.iter().enumerate() {
        let with = binding(&c.binding);
        let text = if with.is_empty() { plain(&c.text) } else { format!("{}, with {with}", plain(&c.text)) };
        table.row([
            if u32::try_from(at).is_ok_and(|at| at == e.chosen) { ">".to_owned() } else { String::new() },
            c.schema.map_or_else(|| "-".to_owned(), |id| id.to_string()),
            text,
            c.distance.to_string(),
            format!("{:.3}", c.excitation),
        ]);
    }
    let total = e.candidates_total;
    format!("\n{} of {total} candidates:\n{}", e.candidates.len(), table.text(&[0, 1, 3, 4]))
}
