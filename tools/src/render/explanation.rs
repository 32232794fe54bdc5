//! `explain` for people: a sentence first, then the sum that made it so.

use pschema_inspect::{Candidate, ExcitationTerm, Explanation, ObservationText, Reason, TermRole};
use pschema_learner::notation::side;

use super::claims;
use super::goals;
use super::schema::wrapped;
use super::table::Columns;
use super::words::{bound, count, expectations, figure, notation, plain, with_values};

/// Why an action was chosen.
pub fn explanation(e: &Explanation) -> String {
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
    if !e.claims.is_empty() {
        let foretold = claims::foretold(&e.claims, false);
        text.push_str(&format!("\nWhat claims foretold of {}:\n{foretold}", plain(&e.action)));
    }
    text
}

/// Why an action was chosen, in one sentence.
pub(crate) fn in_a_sentence(e: &Explanation) -> String {
    let chosen = usize::try_from(e.chosen).ok().and_then(|at| e.candidates.get(at));
    chosen.map_or_else(String::new, |chosen| sentence(e, chosen))
}

fn sentence(e: &Explanation, chosen: &Candidate) -> String {
    let because = match e.reason {
        Reason::Goal => e.goal.as_ref().map_or_else(|| "for a goal".to_owned(), goals::followed),
        Reason::Chain => "because it is the next of a chain begun before".to_owned(),
        Reason::Tie => format!(
            "because {} candidates were equally exciting (E = {}) and the lot fell on it",
            e.ties,
            shown(chosen.excitation)
        ),
        Reason::Excitation => format!(
            "because nothing else was as exciting: E = {}{}",
            shown(chosen.excitation),
            rival(e, chosen)
        ),
    };
    // A decision for a goal does not depend on excitation.
    let exciting = strongest(chosen).filter(|_| e.goal.is_none());
    let why = exciting.map_or_else(String::new, |term| told(term, chosen));
    let (step, body, action) = (e.step, plain(&e.body), plain(&e.action));
    format!("In step {step}, {body} was sent to {action}{}, {because}.{why}", expecting(chosen))
}

/// The outcome that the chosen schema expects, under its binding.
fn expecting(chosen: &Candidate) -> String {
    let Some(id) = chosen.schema else { return String::new() };
    let bound = bound(&chosen.form, &chosen.binding);
    let post = expectations(&bound.post);
    let given = match bound.pre.as_slice() {
        [] => String::new(),
        pre => format!(" given {}", side(pre.iter().map(notation))),
    };
    match chosen.distance {
        0 | 1 => format!(", of which schema {id} expects {post}{given}"),
        // The action sent is that of the first schema of a chain to this one.
        _ => format!(", on the way to schema {id}, which expects {post}{given}{}", together(chosen)),
    }
}

/// The schemas that achieve the target of a candidate together, where no single one does.
fn together(candidate: &Candidate) -> String {
    let schemas: Vec<_> =
        candidate.together.iter().map(|one| format!("schema {} ({})", one.id, plain(&one.action))).collect();
    match schemas.is_empty() {
        true => String::new(),
        false => format!(" (no single schema achieves its target; {} do together)", schemas.join(", then ")),
    }
}

fn rival(e: &Explanation, chosen: &Candidate) -> String {
    let others = e.candidates.iter().filter(|c| !std::ptr::eq(*c, chosen));
    // Among equals, the first listed is taken.
    let next = others.rev().max_by(|a, b| a.excitation.total_cmp(&b.excitation));
    next.map_or_else(String::new, |next| format!(", the next ({}) {}", named(next), shown(next.excitation)))
}

fn strongest(candidate: &Candidate) -> Option<&ExcitationTerm> {
    // The rest is many terms added up, so it is not the strongest term. Among equals, the first is taken.
    let terms = candidate.terms.iter().filter(|term| term.role != TermRole::Rest);
    terms.rev().max_by(|a, b| a.value.total_cmp(&b.value))
}

/// The strongest term as sentences: the origin of its value, and how the sum becomes the excitation.
fn told(term: &ExcitationTerm, chosen: &Candidate) -> String {
    let (value, sum) = (shown(term.value), shown(sum(chosen)));
    let part = if chosen.terms.len() == 1 {
        format!("Its {value} comes")
    } else {
        format!("Of its sum {sum}, {value} comes")
    };
    let from = match (&term.observation, &term.seen, term.role) {
        (Some(remembered), Some(seen), role) => {
            let attended = match term.attention {
                0 => "never had attention before".to_owned(),
                1 => "had attention once before".to_owned(),
                n => format!("had attention {n} times before"),
            };
            format!(
                "{part} from {}, which was perceived: it has {} in common with the schema's {} {}, which {attended}",
                notation(seen),
                count(term.shared, "value"),
                role,
                notation(remembered)
            )
        }
        (_, _, TermRole::Babbling) => format!("{part} from the drive to try what was never tried here"),
        (_, _, TermRole::Habituation) => {
            format!("{part} from the drive to repeat what is not yet known well enough")
        }
        (_, _, TermRole::Curiosity) => {
            format!("{part} from curiosity: its action surprised of late, and is new in this place")
        }
        (_, _, role) => format!("{part} of its {role}"),
    };
    match chosen.distance {
        0 | 1 => format!(" {from}."),
        d => format!(
            " {from}. The sum is divided by its distance: {d} schemas, itself included, are to be executed."
        ),
    }
}

/// A candidate by its number; a primitive as it prints.
pub(super) fn named(candidate: &Candidate) -> String {
    candidate.schema.map_or_else(|| plain(&candidate.text), |id| format!("schema {id}"))
}

/// A figure of equation (1) as it is shown.
pub(super) fn shown(value: f64) -> String {
    figure(value, 3)
}

/// The sum of a candidate's terms.
pub(super) fn sum(candidate: &Candidate) -> f64 {
    // From 0: an empty sum of floats would be -0.
    candidate.terms.iter().fold(0.0, |sum, term| sum + term.value)
}

fn heading(chosen: &Candidate) -> String {
    let subject = match chosen.schema {
        Some(id) => format!("Schema {id}: {}", chosen.text),
        None => format!("Primitive {}", chosen.text),
    };
    wrapped(&with_values(&subject, &chosen.binding), "")
}

/// The observations, numbered so that the terms can refer to them.
pub(super) fn perceived(world: &[ObservationText]) -> String {
    if world.is_empty() {
        return "Nothing was perceived.\n".to_owned();
    }
    let mut table = Columns::new(&["", "perceived"]).figures(&[0]);
    for (at, observation) in world.iter().enumerate() {
        table.row([format!("#{}", at + 1), notation(observation)]);
    }
    table.text(&[0])
}

/// The terms, and how their sum makes the excitation.
pub(super) fn terms(chosen: &Candidate, world: &[ObservationText]) -> String {
    let headings = ["term", "remembered", "seen", "same", "prob", "weight", "1+n", "value"];
    let mut table = Columns::new(&headings).figures(&[3, 4, 5, 6, 7]);
    for t in &chosen.terms {
        let remembered = t.observation.as_ref().map_or_else(|| "-".to_owned(), notation);
        let number =
            |o: &ObservationText| world.iter().position(|seen| seen == o).map(|at| format!("#{}", at + 1));
        let seen =
            t.seen.as_ref().map_or_else(|| "-".to_owned(), |o| number(o).unwrap_or_else(|| notation(o)));
        // A drive, and the rest, is no product, so its factors are left out.
        let of_pair = |figure: String| if t.seen.is_some() { figure } else { "-".to_owned() };
        table.row([
            t.role.to_string(),
            remembered,
            seen,
            of_pair(t.shared.to_string()),
            of_pair(shown(t.probability)),
            of_pair(shown(t.weight)),
            of_pair((u64::from(t.attention) + 1).to_string()),
            shown(t.value),
        ]);
    }
    let table = if chosen.terms.is_empty() { String::new() } else { table.text(&[3, 4, 5, 6, 7]) };
    let (total, d, e) = (shown(sum(chosen)), chosen.distance, shown(chosen.excitation));
    let rounded = rounded(chosen);
    format!("{table}\nvalue = same x prob x weight / (1+n)    sum {total} / distance {d} = E {e}\n{rounded}")
}

/// Sums of figures as they are shown that differ by less are the same.
const LAST_DECIMAL: f64 = 1e-9;

/// Says that the figures are rounded, and where the rounded ones do not add up, to what they add up.
fn rounded(chosen: &Candidate) -> String {
    // Read from the figures as they are shown, so that the rounding is the same.
    let as_shown = |value: f64| shown(value).parse::<f64>().unwrap_or(value);
    let added = chosen.terms.iter().fold(0.0, |sum, term| sum + as_shown(term.value));
    let rounded = "Figures are rounded to 3 decimals, below 0.1 to 3 digits; --json has them whole.\n";
    if (added - as_shown(sum(chosen))).abs() < LAST_DECIMAL {
        return rounded.to_owned();
    }
    let added = format!("{added:.9}");
    let added = added.trim_end_matches('0').trim_end_matches('.');
    format!("{rounded}Each is rounded by itself: as shown, the values add up to {added}.\n")
}

fn others(e: &Explanation) -> String {
    if e.candidates.len() < 2 {
        return String::new();
    }
    let mut table = Columns::new(&["", "schema", "candidate", "distance", "e"]).figures(&[1, 3, 4]);
    for (at, c) in e.candidates.iter().enumerate() {
        table.row([
            if u32::try_from(at).is_ok_and(|at| at == e.chosen) { ">".to_owned() } else { String::new() },
            c.schema.map_or_else(|| "-".to_owned(), |id| id.to_string()),
            with_values(&c.text, &c.binding),
            c.distance.to_string(),
            shown(c.excitation),
        ]);
    }
    let total = e.candidates_total;
    format!("\n{} of {total} candidates:\n{}", e.candidates.len(), table.text(&[0, 1, 3, 4]))
}
