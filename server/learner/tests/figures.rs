//! The paper's worked figures as executable examples, and equation (1) by hand.

mod common;

use common::{FINGER, OBJECT, Table, finger, free, object, touch};
use pschema_learner::decision::{Role, Subject};
use pschema_learner::notation;
use pschema_learner::observation::{Pattern, PropertyId, SymbolId, Term, Value, Variable};
use pschema_learner::parameters::Parameters;
use pschema_learner::schema::{Form, SchemaId};
use pschema_learner::{ActionOutcome, Frame, Output};

/// A learner that has babbled postures 0 to 5: `∅ / move(f) / finger in field f`.
fn babbled() -> Table {
    let mut table = Table::new(1, 6, 6, free(), Parameters::default());
    while table.learner.memory().content().schemas.len() < 6 {
        assert!(table.step(), "babbling goes on while there is something untried");
    }
    assert!(table.step());
    table.finger = None;
    table
}

/// Has the learner see `block` alone, and returns what it then decides.
fn show(table: &mut Table, colour: u32, field: i64) {
    table.blocks = vec![(colour, field)];
    table.finger = None;
    table.touching = false;
    // The arm was parked by hand: nothing is learnt from that.
    table.outcome = None;
}

#[test]
fn figure_1_an_unexpected_touch_makes_a_schema() {
    let mut table = babbled();
    show(&mut table, 1, 4);
    assert!(table.step());
    let chosen = table.steps.last().unwrap().decision.clone().unwrap();
    let selected = &chosen.candidates[chosen.chosen];
    let Subject::Schema(selected) = selected.subject else { panic!("a schema is selected: {chosen:?}") };
    let content = table.learner.memory().content();
    let text = notation::schema(content, content.schema(selected).unwrap());
    assert_eq!(
        text, "∅ / move(posture=4) / finger{colour=green, field=4}",
        "the object in field 4 excites it"
    );

    assert!(table.step());
    let content = table.learner.memory().content();
    let made = content.schema(SchemaId(6)).expect("the touch was not predicted, so a schema is made");
    assert_eq!(
        notation::schema(content, made),
        "object{colour=blue, field=4} / move(posture=4) / \
         finger{colour=green, field=4} & object{colour=blue, field=4} & touch{}"
    );
    assert_eq!(content.schemas.len(), 7);
    assert_eq!(made.parent, Some(selected));
}

#[test]
fn figure_1_what_was_predicted_makes_none() {
    let mut table = babbled();
    table.within = 0;
    show(&mut table, 1, 4);
    assert!(table.step());
    assert!(table.step());
    // The finger is seen over the object and not felt: all that is seen was predicted.
    assert_eq!(table.finger, Some(4));
    assert_eq!(table.learner.memory().content().schemas.len(), 6);
}

/// Touches blocks at two places; the generalised schema is then number 8.
fn touched_twice() -> Table {
    let mut table = babbled();
    for field in [4, 2] {
        show(&mut table, 1, field);
        assert!(table.step());
        assert_eq!(table.finger, Some(field), "the block excites the posture that brings the finger there");
        assert!(table.step());
    }
    table
}

#[test]
fn figures_2_and_3_the_action_becomes_a_target_and_values_become_variables() {
    let mut table = touched_twice();
    let content = table.learner.memory().content();
    assert_eq!(content.generalised_count, 1, "two touches at two places are enough");
    let schema = content.schema(SchemaId(8)).unwrap();
    assert_eq!(
        notation::schema(content, schema),
        "object{colour=$a, field=$b} / achieve finger{colour=green, field=$b} / \
         finger{colour=green, field=$b} & object{colour=$a, field=$b} & touch{}"
    );
    let Form::Generalised(generalised) = &schema.form else { panic!("it is generalised") };
    assert_eq!(generalised.examples, [SchemaId(6), SchemaId(7)]);
    let (colour, field) = (PropertyId(0), PropertyId(1));
    let (a, b) = (Term::Variable(Variable(0)), Term::Variable(Variable(1)));
    assert_eq!(*generalised.pre, [Pattern::new(OBJECT, [(colour, a), (field, b)])]);
    let green = Term::Constant(Value::Symbol(SymbolId(0)));
    assert_eq!(*generalised.target, [Pattern::new(FINGER, [(colour, green), (field, b)])]);

    // "The values from the current world state are used to populate the variables": another colour, another
    // place, touched at the first try, and nothing has to be remembered of it.
    let before = table.learner.memory().content().schemas.len();
    show(&mut table, 2, 5);
    assert!(table.step());
    assert_eq!((table.finger, table.touching), (Some(5), true));
    assert!(table.step());
    assert_eq!(table.learner.memory().content().schemas.len(), before);
}

#[test]
fn out_of_reach_it_points_and_the_counter_example_is_then_selected_instead() {
    let mut table = touched_twice();
    table.within = 5;
    show(&mut table, 1, 5);
    assert!(table.step());
    assert_eq!((table.finger, table.touching), (Some(5), false), "it points");
    assert!(table.step());
    let content = table.learner.memory().content();
    let counter_example = SchemaId(9);
    let schema = content.schema(counter_example).unwrap();
    assert_eq!(
        notation::schema(content, schema),
        "object{colour=blue, field=5} / move(posture=5) / \
         finger{colour=green, field=5} & object{colour=blue, field=5}"
    );
    assert_eq!(schema.concrete().unwrap().contradicts, Some(SchemaId(8)));
    let generalised = content.schema(SchemaId(8)).unwrap();
    assert_eq!(generalised.generalised().unwrap().counter_examples, [counter_example]);

    show(&mut table, 1, 5);
    assert!(table.step());
    let decision = table.steps.last().unwrap().decision.clone().unwrap();
    let subjects: Vec<_> = decision.candidates.iter().map(|candidate| candidate.subject).collect();
    assert!(subjects.contains(&Subject::Schema(counter_example)), "{decision:#?}");
    assert!(!subjects.contains(&Subject::Schema(SchemaId(8))), "the generalised one gives way: {decision:?}");
}

#[test]
fn equation_1_adds_up() {
    let mut table = touched_twice();
    // The finger rests at 0 and a red block lies at 4.
    let frame = Frame { body: table.body, outcome: None, observations: vec![finger(0), object(2, 4)] };
    let step = table.learner.step(&frame);
    let decision = step.decision.unwrap();
    let memory = table.learner.memory();
    let n = |observation| f64::from(memory.attention(&observation));
    let find = |subject| decision.candidates.iter().find(|c| c.subject == subject).unwrap();

    // ∅ / move(4) / finger in field 4: shares `green` with the finger seen and `field=4` with the block.
    let concrete = (0..6)
        .map(SchemaId)
        .find(|id| {
            let content = memory.content();
            notation::schema(content, content.schema(*id).unwrap()).starts_with("∅ / move(posture=4)")
        })
        .unwrap();
    let expected = 1.0 / (1.0 + n(finger(4))) + 1.0 / (1.0 + n(finger(4)));
    assert!((find(Subject::Schema(concrete)).excitation - expected).abs() < 1e-12);

    // The generalised schema, bound to the red block at 4: the block itself (2 shared, never attended), the
    // block's field with the finger remembered there, and `green` with the finger seen.
    let expected = 2.0 / (1.0 + n(object(2, 4))) + 2.0 / (1.0 + n(finger(4)));
    let generalised = find(Subject::Schema(SchemaId(8)));
    assert_eq!(n(object(2, 4)), 0.0);
    assert!((generalised.excitation - expected).abs() < 1e-12, "{generalised:?}");
    assert_eq!(generalised.terms.iter().filter(|t| t.role == Role::PreCondition).count(), 1);

    // What no chain reaches is no candidate: the touch at 2 needs a block at 2.
    assert!(!decision.candidates.iter().any(|c| c.subject == Subject::Schema(SchemaId(7))));
    assert_eq!(decision.candidates[decision.chosen].subject, Subject::Schema(SchemaId(8)));
    assert!(matches!(step.output, Output::Act(_)));
}

#[test]
fn equation_1_weighs_associations_by_omega() {
    let mut table = touched_twice();
    show(&mut table, 1, 3);
    assert!(table.step());
    table.words = vec!["touch"];
    assert!(table.step());
    // The word came in the frame of the touch: one example, and it is associated with the generalised schema.
    let content = table.learner.memory().content();
    let schema = content.schema(SchemaId(8)).unwrap();
    let word = content.observation(schema.associations.last().unwrap().observation).clone();
    assert_eq!(notation::observation(&content.vocabulary, &word), "word{text=touch}");
    assert_eq!(content.schemas.len(), 9, "a word is no effect of the action: no schema is made for it");

    table.words = vec!["touch"];
    let before = table.learner.memory().attention(&word);
    table.outcome = Some(ActionOutcome::Failed);
    assert!(table.step());
    let decision = table.steps.last().unwrap().decision.clone().unwrap();
    let candidate = decision.candidates.iter().find(|c| c.subject == Subject::Schema(SchemaId(8))).unwrap();
    let term = candidate.terms.iter().find(|t| t.role == Role::Association).expect("the word excites it");
    assert!((term.value - 0.8 * term.weight / 0.8 / (1.0 + f64::from(before))).abs() < 1e-12);
    assert!((term.weight / 0.8 - candidate.terms[0].weight).abs() < 1e-12, "ω times what others weigh");
}

#[test]
fn a_decision_is_explained_as_of_its_moment() {
    let mut table = touched_twice();
    show(&mut table, 1, 4);
    let frame = table.frame();
    let mut twin = table.learner.clone();
    let at_once = twin.step(&frame).decision.unwrap();
    let told = format!("{at_once:?}");
    let later = table.learner.step(&frame).decision.unwrap();
    let before = table.learner.memory().attention(&object(1, 4));
    // What it was made of goes on changing before anybody asks for its terms.
    let observations = vec![finger(4), object(1, 4), touch()];
    for _ in 0..20 {
        let outcome = Some(ActionOutcome::Done);
        table.learner.step(&Frame { body: frame.body, outcome, observations: observations.clone() });
    }
    assert!(table.learner.memory().attention(&object(1, 4)) > before, "the block was attended to");
    let terms = later.candidates.iter().flat_map(|candidate| &candidate.terms);
    let terms = terms.filter(|term| term.pair.as_ref().is_some_and(|(known, _)| *known == object(1, 4)));
    let terms: Vec<_> = terms.collect();
    assert!(!terms.is_empty() && terms.iter().all(|term| term.attention == before), "{before}: {terms:?}");
    assert_eq!(later, at_once);
    assert_eq!(format!("{later:?}"), told);
}

#[test]
fn an_ignored_bystander_keeps_its_interest() {
    let mut table = touched_twice();
    let (familiar, bystander) = (object(1, 4), object(2, 5));
    // Both are perceived in every frame; what is executed concerns the familiar block only.
    let mut seen = 0;
    for _ in 0..20 {
        let frame = Frame {
            body: table.body,
            outcome: table.outcome.take(),
            observations: vec![finger(4), familiar.clone(), bystander.clone(), touch()],
        };
        let step = table.learner.step(&frame);
        let decision = step.decision.unwrap();
        let concerns = |subject| match subject {
            Subject::Schema(id) => {
                let memory = table.learner.memory();
                notation::schema(memory.content(), memory.content().schema(id).unwrap()).contains("posture=4")
            }
            Subject::Primitive(_) => false,
        };
        let attended = table.learner.memory().attention(&bystander);
        table.outcome = Some(ActionOutcome::Done);
        if concerns(decision.candidates[decision.chosen].subject) {
            seen += 1;
            // Learn from it in the next frame, then compare.
            let frame = Frame { outcome: Some(ActionOutcome::Done), ..frame };
            table.learner.step(&frame);
            assert_eq!(table.learner.memory().attention(&bystander), attended);
            table.outcome = None;
        }
    }
    assert!(seen > 0, "the familiar block was played with");
}
