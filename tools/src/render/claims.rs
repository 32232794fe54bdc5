//! Claims for people: `claims`, and what claims foretell in `predict`, `show` and `explain`.

use pschema_inspect::{
    Change, Claim, ClaimCondition, ClaimEvidence, ClaimList, ClaimTree, ClaimView, Comparison, Foretold,
    JointOutcome, ObservationText, SyntheticItem,
};
use pschema_learner::notation::side;

use super::table::{Columns, WIDTH};
use super::words::{count, notation, plain, probability, value};

/// What stands for an outcome in which nothing changes.
const NO_CHANGE: &str = "no change";

/// A list of claims, from which the first `offset` trees were left out.
pub(crate) fn list(list: &ClaimList, offset: u32) -> String {
    if list.claims.is_empty() {
        return match list.matching {
            0 => "There are no claims yet: they come of experiences.\n".to_owned(),
            n => format!("{} in all: none is left beyond the first {offset}.\n", count(n, "tree")),
        };
    }
    let mut text = String::new();
    for tree in &list.claims {
        text.push_str(&one(tree));
        text.push('\n');
    }
    list.items.iter().for_each(|item| text.push_str(&supposed(item)));
    let (shown, all) = (list.claims.len() as u64, count(list.matching, "tree"));
    let end = u64::from(offset) + shown;
    let more =
        if end < u64::from(list.matching) { format!("; --offset {end} goes on") } else { String::new() };
    text + &match offset {
        0 if more.is_empty() => format!("{all}.\n"),
        0 => format!("{shown} of {all}{more}.\n"),
        _ => format!("{} to {end} of {all}{more}.\n", offset + 1),
    }
}

/// A synthetic item, and what becomes of it.
fn supposed(item: &SyntheticItem) -> String {
    let by = match item.supposed_by.as_slice() {
        [] => "not supposed now".to_owned(),
        bodies => {
            format!("supposed now by {}", bodies.iter().map(|b| plain(b)).collect::<Vec<_>>().join(", "))
        }
    };
    let (name, action) = (plain(&item.name), plain(&item.action));
    let mut text = String::new();
    hanging("", &format!("{name}, {by}: tells what comes of {action}, in {}", types(&item.types)), &mut text);
    for event in &item.events {
        let after: Vec<_> = event.after.iter().map(notation).collect();
        let after = if after.is_empty() { "nothing".to_owned() } else { after.join(" & ") };
        hanging(
            "  ",
            &format!("{}: when {} comes to {after}", event.update, plain(&event.action)),
            &mut text,
        );
    }
    text.push('\n');
    text
}

/// The claims about one group of types.
fn one(tree: &ClaimTree) -> String {
    let done = tree.action.as_deref().map_or_else(|| "whatever is done".to_owned(), plain);
    let each = if tree.each { "each " } else { "" };
    let mut text = format!("{done}: {each}{}\n", types(&tree.types));
    branch(&tree.claim, 1, &mut text);
    text
}

/// A claim with its evidence and its exceptions, each deeper than the claim that it is an exception to.
fn branch(claim: &Claim, depth: usize, text: &mut String) {
    let indent = "  ".repeat(depth);
    let Some(evidence) = &claim.because else {
        let told = claim.outcomes.iter().map(|one| (change(&one.change), one.occurrences, String::new()));
        outcomes(told, claim.trials, &indent, text);
        return claim.exceptions.iter().for_each(|exception| branch(exception, depth, text));
    };
    let gain = format!("but where {} ({}):", condition(&evidence.condition), gain(evidence));
    hanging(&indent, &gain, text);
    let counted = evidence.outcomes.iter().filter(|one| claim.exceptions.is_empty() && one.with == 0);
    let of_others = counted.map(|one| (&one.change, 0));
    let own = claim.outcomes.iter().map(|one| (&one.change, one.occurrences));
    let told = own.chain(of_others).map(|(one, times)| {
        let known = evidence.outcomes.iter().find(|known| known.change == *one);
        let (with, without) = known.map_or((0, 0), |known| (known.with, known.without));
        let all = match claim.exceptions.is_empty() {
            true => String::new(),
            false => format!("with all its exceptions {with}/{}, ", evidence.trials_with),
        };
        (change(one), times, format!("; {all}without it {without}/{}", evidence.trials_without))
    });
    outcomes(told, claim.trials, &format!("{indent}  "), text);
    claim.exceptions.iter().for_each(|exception| branch(exception, depth + 1, text));
}

/// Adds a line for each outcome, with its count and what is to be said behind it.
fn outcomes(told: impl Iterator<Item = (String, u32, String)>, trials: u32, indent: &str, text: &mut String) {
    let mut rest = trials;
    for (change, times, more) in told {
        rest = rest.saturating_sub(times);
        hanging(indent, &format!("{times}/{trials} {change}{more}"), text);
    }
    match (rest, trials) {
        (_, 0) => hanging(indent, "0/0: it was always one of the exceptions", text),
        (0, _) => (),
        _ => hanging(indent, &format!("{rest}/{trials} anything else"), text),
    }
}

fn gain(evidence: &ClaimEvidence) -> String {
    format!("{:.1} bits above its price", evidence.gain_bits)
}

/// Adds the evidence for a condition: what followed where it holds, and where it does not.
fn because(evidence: &ClaimEvidence, indent: &str, text: &mut String) {
    let told = evidence.outcomes.iter().map(|one| {
        let without = format!("; without it {}/{}", one.without, evidence.trials_without);
        (change(&one.change), one.with, without)
    });
    outcomes(told, evidence.trials_with, indent, text);
}

/// A condition as it is written.
pub(crate) fn condition(condition: &ClaimCondition) -> String {
    let compared = |sign: &str, compared: &Comparison| {
        format!("{} {sign} {}", plain(&compared.named.to_string()), value(&compared.value))
    };
    match condition {
        ClaimCondition::Observed(observation) => notation(observation),
        ClaimCondition::Recalled(observation) => format!("recalled {}", notation(observation)),
        ClaimCondition::Is(both) => compared("=", both),
        ClaimCondition::AtLeast(both) => compared(">=", both),
    }
}

/// A change as it is written: `becomes finger{field=4} & no longer object{field=4}`.
fn change(change: &Change) -> String {
    changes(&[("becomes", &change.becomes), ("no longer", &change.vanishes), ("new", &change.appears)])
}

fn changes(parts: &[(&str, &[ObservationText])]) -> String {
    let told =
        parts.iter().flat_map(|(lead, part)| part.iter().map(move |o| format!("{lead} {}", notation(o))));
    let told: Vec<_> = told.collect();
    if told.is_empty() { NO_CHANGE.to_owned() } else { side(told) }
}

fn types(types: &[String]) -> String {
    types.iter().map(|kind| plain(kind)).collect::<Vec<_>>().join(" & ")
}

/// What is foretold of each group of types, with the conditions that it rests on; with the `evidence` for them if that is wanted.
pub(crate) fn foretold(list: &[Foretold], evidence: bool) -> String {
    let mut text = String::new();
    for facet in list {
        let each = if facet.each { "each " } else { "" };
        text.push_str(&format!("\n{each}{}: {}\n", types(&facet.types), basis(facet)));
        for condition in &facet.because {
            let told = format!("because {}", self::condition(&condition.condition));
            if evidence {
                hanging("  ", &format!("{told} ({}):", gain(condition)), &mut text);
                because(condition, "    ", &mut text);
            } else {
                hanging("  ", &told, &mut text);
            }
        }
        let mut table = Columns::new(&["  then", "probability"]);
        for outcome in &facet.outcomes {
            table.row([format!("  {}", joint(outcome)), likely(outcome, facet.trials)]);
        }
        let told: u32 = facet.outcomes.iter().map(|outcome| outcome.occurrences).sum();
        if told < facet.trials {
            let rest = facet.trials - told;
            table.row(["  anything else".to_owned(), format!("{rest}/{}", facet.trials)]);
        }
        text.push_str(&table.text(&[1]));
    }
    text
}

fn basis(facet: &Foretold) -> String {
    let from = match facet.view {
        ClaimView::General => "from the claims about the action",
        ClaimView::Primitive => "from the claims about this primitive alone",
        ClaimView::Context => "from what came of it in this very context",
    };
    let doing = if facet.attributed { "" } else { "; not put down to the action" };
    format!("{from}{doing}")
}

/// What comes of it, as one outcome.
pub(crate) fn joint(outcome: &JointOutcome) -> String {
    changes(&[("no longer", &outcome.vanishes), ("new", &outcome.appears)])
}

fn likely(outcome: &JointOutcome, trials: u32) -> String {
    probability(outcome.probability, outcome.occurrences, trials, outcome.low, outcome.high)
}

/// Adds a text that is broken into lines, those after the first with a deeper indent.
fn hanging(indent: &str, told: &str, text: &mut String) {
    let mut line = indent.to_owned();
    let mut free = true;
    for word in told.split(' ') {
        if !free && line.chars().count() + 1 + word.chars().count() > usize::from(WIDTH) {
            text.push_str(&line);
            text.push('\n');
            line = format!("{indent}  ");
            free = true;
        }
        if !free {
            line.push(' ');
        }
        line.push_str(word);
        free = false;
    }
    text.push_str(&line);
    text.push('\n');
}
