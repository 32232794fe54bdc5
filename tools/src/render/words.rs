//! Observations, schemas, probabilities and durations in words.

use pschema_inspect::{
    Condition, Expectation, NamedValues, ObservationText, SchemaDetail, SchemaForm, SchemaSummary, ValueText,
};
use pschema_learner::notation::{SchemaText, by_names, outcome, outcomes, side};
use pschema_process::number;

/// A figure below this is told with its power of ten.
const SMALLEST_IN_DECIMALS: f64 = 1e-5;

/// Text of others (names of bodies, words heard) without control characters, which would steer a terminal.
pub(crate) fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// An observation as it is written on the command line: `object{colour=blue, field=$x}`.
pub fn notation(observation: &ObservationText) -> String {
    let properties = observation.properties.iter().map(|(name, known)| (plain(name), value(known)));
    by_names(&plain(&observation.kind), properties)
}

/// A post-condition as it is written.
pub(crate) fn condition(condition: &Condition) -> String {
    outcome(notation(&condition.observation), condition.absent)
}

/// An expectation as it is written.
pub(crate) fn expectation(expectation: &Expectation) -> String {
    outcome(notation(&expectation.observation), expectation.absent)
}

/// A schema as it is written, on one line: pre-conditions / action / post-conditions.
fn on_one_line(
    pre: &[ObservationText],
    target: &[ObservationText],
    action: &str,
    post: impl Iterator<Item = (String, Option<f64>)>,
) -> String {
    let action = match target {
        [] => plain(action),
        target => format!("achieve {}", side(target.iter().map(notation))),
    };
    let (post, post_shares) = post.unzip();
    SchemaText { pre: pre.iter().map(notation).collect(), action, post, post_shares }.to_string()
}

/// A schema as it is written, on one line.
pub(crate) fn schema_notation(schema: &SchemaDetail) -> String {
    let share = |post: &Condition| (post.trials > 0).then_some(post.probability);
    let post = schema.post.iter().map(|post| (condition(post), share(post)));
    on_one_line(&schema.pre, &schema.target, &schema.action, post)
}

/// A schema as it is written, on one line, from its parts.
pub(crate) fn form_notation(form: &SchemaForm) -> String {
    let post = form.post.iter().map(|post| (expectation(post), post.share));
    on_one_line(&form.pre, &form.target, &form.action, post)
}

/// A schema of a list as it is written, on one line.
pub(crate) fn summary_notation(schema: &SchemaSummary) -> String {
    summary_text(schema).to_string()
}

/// A schema of a list as text, in its parts.
pub(crate) fn summary_text(schema: &SchemaSummary) -> SchemaText {
    let written = |list: &[String]| list.iter().map(|one| plain(one)).collect();
    SchemaText {
        pre: written(&schema.pre),
        action: plain(&schema.action),
        post: written(&schema.post),
        post_shares: schema.post_shares.clone(),
    }
}

/// The outcomes that a schema expects, side by side.
pub(crate) fn expectations(post: &[Expectation]) -> String {
    outcomes(post.iter().map(|post| (expectation(post), post.share)))
}

/// The parts of a schema with the values of its variables put in.
pub(crate) fn bound(form: &SchemaForm, binding: &NamedValues) -> SchemaForm {
    let bound = |observation: &ObservationText| {
        let value = |value: &ValueText| match value {
            ValueText::Variable { var } => binding.get(var).unwrap_or(value).clone(),
            constant => constant.clone(),
        };
        let properties = observation.properties.iter().map(|(name, known)| (name.clone(), value(known)));
        ObservationText { kind: observation.kind.clone(), properties: properties.collect() }
    };
    SchemaForm {
        pre: form.pre.iter().map(bound).collect(),
        action: form.action.clone(),
        target: form.target.iter().map(bound).collect(),
        post: form
            .post
            .iter()
            .map(|post| Expectation { observation: bound(&post.observation), ..post.clone() })
            .collect(),
    }
}

/// A value as it is written.
pub(crate) fn value(value: &ValueText) -> String {
    match value {
        ValueText::Integer(n) => n.to_string(),
        ValueText::Symbol(s) => plain(s),
        ValueText::Boolean(b) => b.to_string(),
        ValueText::Real(r) => number(*r),
        ValueText::Variable { var } => format!("${}", plain(var)),
        ValueText::Named { named } => plain(&named.to_string()),
    }
}

/// The values of variables: `$a=blue, $b=17`; empty where there are none.
pub(crate) fn binding(binding: &NamedValues) -> String {
    let pairs = binding.iter().map(|(name, v)| format!("${}={}", plain(name), value(v)));
    pairs.collect::<Vec<_>>().join(", ")
}

/// A text, and the values of the variables in it: `object{field=$b}, with $b=17`.
pub(crate) fn with_values(text: &str, values: &NamedValues) -> String {
    let (text, values) = (plain(text), binding(values));
    if values.is_empty() { text } else { format!("{text}, with {values}") }
}

/// The text with a capital letter.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A probability with its counts and its interval: `0.93 (14/15, 0.70-0.99)`.
pub(crate) fn probability(probability: f64, occurrences: u32, trials: u32, low: f64, high: f64) -> String {
    if trials == 0 {
        return "not tried yet".to_owned();
    }
    format!("{probability:.2} ({occurrences}/{trials}, {low:.2}-{high:.2})")
}

/// A figure that may be very small, such as an excitation: with so many decimals, or where that leaves fewer digits that say
/// something, with so many digits: `0.333`, `0.0123`, `0.000457`, `1.2e-7`.
pub(crate) fn figure(value: f64, digits: usize) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() || size >= 0.1 {
        return format!("{value:.digits$}");
    }
    if size < SMALLEST_IN_DECIMALS {
        return format!("{value:.*e}", digits - 1);
    }
    // Rounded first, for 0.09996 has one decimal less than it seems.
    let rounded = format!("{value:.*e}", digits - 1);
    let exponent = rounded.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    let decimals = digits + exponent.map_or(0, |exponent| usize::try_from(-exponent - 1).unwrap_or(0));
    format!("{value:.decimals$}")
}

/// A duration for people: `850 ms`, `12.3 s`, `2 h 05 min`.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.0} h {:02.0} min", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor()),
    }
}

/// Bytes for people: `512 B`, `48.0 MiB`.
pub fn bytes(bytes: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "shown with one decimal")]
    let (bytes, mut unit) = (bytes as f64, "B");
    let mut shown = bytes;
    for next in ["KiB", "MiB", "GiB", "TiB"] {
        if shown < 1024.0 {
            break;
        }
        shown /= 1024.0;
        unit = next;
    }
    if unit == "B" { format!("{shown:.0} B") } else { format!("{shown:.1} {unit}") }
}

/// A count with its noun: `1 place`, `2 places`.
pub(crate) fn count(n: impl Into<u64>, thing: &str) -> String {
    let n = n.into();
    format!("{n} {thing}{}", if n == 1 { "" } else { "s" })
}

/// A schema as a sentence: "an object of any colour $a in any field $b: bring the finger to field $b, and
/// it touches (always so far, in 12 of 12)".
pub(crate) fn schema_sentence(schema: &SchemaDetail) -> String {
    let mut known = Vec::new();
    let mut sentence = match schema.pre.as_slice() {
        [] => "whatever is perceived".to_owned(),
        pre => pre.iter().map(|o| with_article(o, &mut known)).collect::<Vec<_>>().join(" and "),
    };
    sentence.push_str(": ");
    if schema.target.is_empty() {
        sentence.push_str(&plain(&schema.action));
    } else {
        let target = schema.target.iter().map(|o| order(o, &mut known)).collect::<Vec<_>>();
        sentence.push_str(&target.join(" and "));
    }
    sentence.push_str(", and ");
    sentence.push_str(&news(schema, &mut known));
    sentence
}

/// The probable outcomes of a schema, without those that were there before and those that are its target.
fn news(schema: &SchemaDetail, known: &mut Vec<String>) -> String {
    let known_before =
        |c: &Condition| schema.pre.contains(&c.observation) || schema.target.contains(&c.observation);
    let said = |c: &&Condition| c.probability > 0.5 && (c.absent || !known_before(c));
    let news: Vec<_> = schema.post.iter().filter(said).collect();
    if news.is_empty() {
        return "nothing else changes".to_owned();
    }
    let clauses: Vec<_> = news.iter().map(|c| clause(c, known)).collect();
    clauses.join(" and ")
}

/// The outcomes that a generalised schema predicts and its counter-example lacks: ", but it does not touch".
pub(crate) fn missing(general: &SchemaDetail, exception: &SchemaDetail) -> String {
    let held = |kind: &str| exception.post.iter().any(|c| !c.absent && c.observation.kind == kind);
    let lacking =
        general.post.iter().filter(|c| !c.absent && c.probability > 0.5 && !held(&c.observation.kind));
    let told = lacking.map(|c| match (c.observation.kind.as_str(), c.observation.properties.is_empty()) {
        ("touch", true) => "it does not touch".to_owned(),
        _ => format!("there is no {}", plain(&c.observation.kind)),
    });
    let told: Vec<_> = told.collect();
    if told.is_empty() { String::new() } else { format!(", but {}", told.join(" and ")) }
}

fn clause(condition: &Condition, known: &mut Vec<String>) -> String {
    let observation = &condition.observation;
    match (observation.kind.as_str(), observation.properties.is_empty(), condition.absent) {
        // The one event that the paper's first experiment is about deserves a verb.
        ("touch", true, false) => "it touches".to_owned(),
        ("touch", true, true) => "it no longer touches".to_owned(),
        (_, _, false) => format!("there is {}", with_article(observation, known)),
        (_, _, true) => format!("there is no longer {}", with_article(observation, known)),
    }
}

/// A target as an order: to bring what is somewhere to that place, else to make it so. What is fixed about the thing
/// (the finger's colour) goes without saying.
fn order(observation: &ObservationText, known: &mut Vec<String>) -> String {
    let is_place = |name: &str| name == "field";
    let fixed =
        |(name, value): &(String, ValueText)| is_place(name) || !matches!(value, ValueText::Variable { .. });
    let place = observation.properties.iter().find(|(name, _)| is_place(name));
    match place {
        Some((name, place)) if observation.properties.iter().all(fixed) => {
            format!("bring the {} to {}", plain(&observation.kind), qualified(name, place, known))
        }
        _ => format!("bring about {}", with_article(observation, known)),
    }
}

/// An observation as a noun: `a blue object in field 4`. A variable is "any" when it is first met.
fn with_article(observation: &ObservationText, known: &mut Vec<String>) -> String {
    let colour = match observation.properties.get("colour") {
        Some(ValueText::Symbol(colour)) => Some(plain(colour)),
        _ => None,
    };
    let noun = colour.iter().cloned().chain([plain(&observation.kind)]).collect::<Vec<_>>().join(" ");
    let article = if noun.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
    let mut text = format!("{article} {noun}");
    let rest = observation.properties.iter().filter(|(name, _)| colour.is_none() || name != "colour");
    // Properties of the thing come before its place.
    let (places, rest): (Vec<_>, Vec<_>) = rest.partition(|(name, _)| name == "field");
    for (name, property) in rest.into_iter().chain(places) {
        let preposition = match name.as_str() {
            "field" => "in",
            "colour" => "of",
            _ => "with",
        };
        text.push_str(&format!(" {preposition} {}", qualified(&plain(name), property, known)));
    }
    text
}

fn qualified(name: &str, property: &ValueText, known: &mut Vec<String>) -> String {
    match property {
        ValueText::Variable { var } if !known.contains(var) => {
            known.push(var.clone());
            format!("any {name} ${}", plain(var))
        }
        other => format!("{name} {}", value(other)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observation(kind: &str, properties: &[(&str, ValueText)]) -> ObservationText {
        let properties = properties.iter().map(|(name, v)| ((*name).to_owned(), v.clone())).collect();
        ObservationText { kind: kind.to_owned(), properties }
    }

    fn variable(name: &str) -> ValueText {
        ValueText::variable(name)
    }

    fn sure(observation: ObservationText) -> Condition {
        Condition {
            observation,
            absent: false,
            occurrences: 2,
            trials: 2,
            probability: 1.0,
            low: 0.34,
            high: 1.0,
        }
    }

    fn touching() -> SchemaDetail {
        let object = observation("object", &[("colour", variable("a")), ("field", variable("b"))]);
        let finger = observation("finger", &[("field", variable("b"))]);
        SchemaDetail {
            id: 226,
            kind: pschema_inspect::SchemaKind::Generalised,
            action: String::new(),
            target: vec![finger.clone()],
            pre: vec![object.clone()],
            post: vec![sure(finger), sure(object), sure(observation("touch", &[]))],
            associated: Vec::new(),
            executions: 2,
            successes: 2,
            probability: 1.0,
            low: 0.34,
            high: 1.0,
            parent: None,
            contradicts: None,
            examples: vec![224, 225],
            counter_examples: Vec::new(),
            created_step: 230,
            claims: Vec::new(),
        }
    }

    #[test]
    fn the_papers_generalised_schema_reads_as_a_sentence_and_as_notation() {
        let schema = touching();
        assert_eq!(
            schema_sentence(&schema),
            "an object of any colour $a in any field $b: bring the finger to field $b, and it touches"
        );
        assert_eq!(
            schema_notation(&schema),
            "object{colour=$a, field=$b} / achieve finger{field=$b} / \
             finger{field=$b} & object{colour=$a, field=$b} & touch{}"
        );
    }

    /// Both were joined by `&` once, as if the finger were in two fields.
    #[test]
    fn outcomes_that_exclude_each_other_have_their_shares() {
        let mut schema = touching();
        schema.target.clear();
        "move()".clone_into(&mut schema.action);
        let finger = |field, occurrences: u32| Condition {
            occurrences,
            trials: 5,
            probability: f64::from(occurrences) / 5.0,
            ..sure(observation("finger", &[("field", ValueText::Integer(field))]))
        };
        schema.post = vec![finger(4, 3), sure(observation("touch", &[])), finger(5, 2)];
        assert!(
            schema_notation(&schema)
                .ends_with(" / move() / (finger{field=4} 60 % or finger{field=5} 40 %) & touch{}"),
            "{}",
            schema_notation(&schema)
        );
        // Together they held more often than there were executions: they do not exclude each other.
        schema.post[2] = finger(5, 4);
        assert!(
            schema_notation(&schema).ends_with(" / finger{field=4} 60 % & touch{} & finger{field=5} 80 %")
        );
        schema.post.truncate(2);
        assert!(schema_notation(&schema).ends_with(" / finger{field=4} 60 % & touch{}"));
        schema.post[0].trials = 0;
        assert!(
            schema_notation(&schema).ends_with(" / finger{field=4} & touch{}"),
            "never tried, nothing is known"
        );
    }

    /// They were joined by `&`, though one is what the other is not.
    #[test]
    fn an_observation_and_the_same_one_gone_exclude_each_other() {
        let finger = |field, absent, probability| Condition {
            absent,
            probability,
            ..sure(observation("finger", &[("field", ValueText::Integer(field))]))
        };
        let written = |post: &[Condition]| {
            let mut schema = SchemaDetail { post: post.to_vec(), ..touching() };
            schema.target.clear();
            "move()".clone_into(&mut schema.action);
            let notation = schema_notation(&schema);
            notation.split_once(" / move() / ").unwrap().1.to_owned()
        };
        let (there, gone, elsewhere) = (finger(4, false, 0.7), finger(4, true, 0.3), finger(5, false, 0.3));
        let alternatives = "(finger{field=4} 70 % or no longer finger{field=4} 30 %)";
        assert_eq!(written(&[there.clone(), gone.clone()]), alternatives);
        let both = [there.clone(), sure(observation("touch", &[])), gone.clone(), elsewhere.clone()];
        assert_eq!(written(&both), format!("{alternatives} & touch{{}} & finger{{field=5}} 30 %"));
        let sure_and_gone = [finger(4, true, 1.0), finger(4, false, 0.1)];
        assert_eq!(written(&sure_and_gone), "(no longer finger{field=4} or finger{field=4} 10 %)");
        // The finger that is gone from one field may well be in another.
        assert_eq!(written(&[elsewhere, gone]), "finger{field=5} 30 % & no longer finger{field=4} 30 %");
    }

    #[test]
    fn what_is_fixed_about_a_thing_is_said_in_passing_or_not_at_all() {
        let mut schema = touching();
        let green = ("colour".to_owned(), ValueText::Symbol("green".to_owned()));
        schema.target[0].properties.0.insert(0, green.clone());
        assert!(
            schema_sentence(&schema).contains(": bring the finger to field $b, and"),
            "{}",
            schema_sentence(&schema)
        );
        let seen = observation("finger", &[("field", ValueText::Integer(4)), ("colour", green.1)]);
        schema.post = vec![sure(seen)];
        assert!(
            schema_sentence(&schema).ends_with("there is a green finger in field 4"),
            "{}",
            schema_sentence(&schema)
        );
        schema.target = vec![observation("object", &[("colour", variable("c")), ("field", variable("b"))])];
        assert!(schema_sentence(&schema).contains("bring about an object of any colour $c in field $b"));
    }

    #[test]
    fn an_exception_says_what_it_lacks() {
        let general = touching();
        let mut exception = touching();
        exception.post.pop();
        assert_eq!(missing(&general, &exception), ", but it does not touch");
        assert_eq!(missing(&general, &general), "");
    }

    #[test]
    fn a_babbled_schema_and_a_loss_read_as_sentences() {
        let mut schema = touching();
        schema.pre.clear();
        schema.target.clear();
        "move(j1=0.43, j2=0.84)".clone_into(&mut schema.action);
        schema.post = vec![sure(observation("finger", &[("field", ValueText::Integer(4))]))];
        assert_eq!(
            schema_sentence(&schema),
            "whatever is perceived: move(j1=0.43, j2=0.84), and there is a finger in field 4"
        );
        schema.post[0].absent = true;
        assert!(schema_sentence(&schema).ends_with("there is no longer a finger in field 4"));
        assert!(schema_notation(&schema).ends_with("/ no longer finger{field=4}"));
        schema.post.clear();
        assert!(schema_sentence(&schema).ends_with("nothing else changes"));
    }

    #[test]
    fn a_name_that_would_steer_the_terminal_is_shown_and_not_obeyed() {
        let evil = observation("\x1b[2Jobject", &[("co\nlour", ValueText::Symbol("\x07".to_owned()))]);
        assert!(!notation(&evil).chars().any(char::is_control), "{}", notation(&evil));
    }

    #[test]
    fn figures_for_people() {
        assert_eq!(probability(14.0 / 15.0, 14, 15, 0.702, 0.988), "0.93 (14/15, 0.70-0.99)");
        assert_eq!(probability(0.0, 0, 0, 0.0, 1.0), "not tried yet");
        let shown = |value| figure(value, 3);
        assert_eq!([0.0, 1.0 / 3.0, 12.3456, 0.1].map(shown), ["0.000", "0.333", "12.346", "0.100"]);
        assert_eq!(
            [0.0123, 0.000_457_1, 0.050_04, 0.099_96].map(shown),
            ["0.0123", "0.000457", "0.0500", "0.100"]
        );
        assert_eq!([1.234e-7, 2.0e-300, -0.001].map(shown), ["1.23e-7", "2.00e-300", "-0.00100"]);
        assert_eq!([0.004, 0.27].map(|value| figure(value, 2)), ["0.0040", "0.27"]);
        assert_eq!(duration(0.85), "850 ms");
        assert_eq!(duration(12.34), "12.3 s");
        assert_eq!(duration(7500.0), "2 h 05 min");
        assert_eq!(bytes(512), "512 B");
        assert_eq!(bytes(48 * 1024 * 1024), "48.0 MiB");
        assert_eq!(count(1u32, "place"), "1 place");
        assert_eq!(count(2u32, "place"), "2 places");
    }
}
