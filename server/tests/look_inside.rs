//! The graph of memory, pages of lists and why a schema was not executed, against what else is told of the same memory.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::collections::BTreeSet;

use common::{FIELDS, Row, curriculum, setup};
use pschema_inspect::{
    DetailQuery, Explanation, ExplanationQuery, Graph, GraphQuery, GraphTie, PlanQuery, Reason, SchemaDetail,
    SchemaKind, SchemaList, SchemaQuery, SchemaSort, Verdict, WhyNot, WhyNotQuery,
};
use pschema_server::in_process::{InProcess, RunState};
use pschema_server::inspect::Inspect;

type Run = InProcess<Row>;

fn begun(seed: u64) -> Run {
    InProcess::new(Row::new("row"), setup(seed, curriculum())).unwrap()
}

fn finished(seed: u64) -> Run {
    let mut run = begun(seed);
    while run.advance().unwrap() == RunState::Running {}
    run
}

fn graph(run: &Run, query: GraphQuery) -> Graph {
    run.ask(&query).unwrap()
}

fn list(run: &Run, query: SchemaQuery) -> SchemaList {
    run.ask(&query).unwrap()
}

fn show(run: &Run, id: u32) -> SchemaDetail {
    run.ask(&DetailQuery { id }).unwrap()
}

fn problem<Q: Inspect>(run: &Run, question: &Q) -> String {
    run.ask(question).err().unwrap().0
}

/// Ties by schema number.
fn ties(graph: &Graph, kind: GraphTie) -> BTreeSet<(u32, u32)> {
    let id = |at: u32| graph.nodes[at as usize].schema.as_ref().unwrap().id;
    graph.edges.iter().filter(|e| e.kind == kind).map(|e| (id(e.from), id(e.to))).collect()
}

/// The graph of all that was learnt has the ties that what is told of each schema by itself has.
#[test]
fn the_whole_graph_is_what_is_told_of_each_schema() {
    let run = finished(1);
    let whole = graph(&run, GraphQuery::default());
    let schemas: Vec<_> = (0..FIELDS as u32 + 3).map(|id| show(&run, id)).collect();
    assert_eq!(
        (whole.nodes_total, whole.shown as usize, whole.truncated),
        (schemas.len() as u64, schemas.len(), false)
    );
    let members: u64 = whole.clusters.iter().map(|cluster| cluster.members).sum();
    assert_eq!(members, whole.nodes_total);

    let pairs = |of: &dyn Fn(&SchemaDetail) -> Vec<(u32, u32)>| -> BTreeSet<(u32, u32)> {
        schemas.iter().flat_map(of).collect()
    };
    let general = |schema: &SchemaDetail| !schema.target.is_empty();
    let examples =
        pairs(&|s| if general(s) { s.examples.iter().map(|e| (*e, s.id)).collect() } else { Vec::new() });
    assert_eq!(ties(&whole, GraphTie::ExampleOf), examples);
    assert!(!examples.is_empty());
    let parents = pairs(&|s| s.parent.iter().map(|parent| (*parent, s.id)).collect());
    assert_eq!(ties(&whole, GraphTie::ParentOf), parents);
    // Every babbled schema brings the finger somewhere, and any place will do for the law's target.
    let carriers = pairs(&|law| {
        let brings = |s: &&SchemaDetail| {
            let made =
                |c: &&pschema_inspect::Condition| !s.pre.contains(&c.observation) && c.probability >= 0.5;
            !general(s)
                && s.post.iter().filter(made).any(|c| law.target.iter().any(|t| t.kind == c.observation.kind))
        };
        schemas.iter().filter(brings).map(|s| (s.id, law.id)).collect()
    });
    assert_eq!(ties(&whole, GraphTie::Carries), carriers);
    assert_eq!(whole, graph(&run, GraphQuery::default()), "the same memory always gives the same graph");
}

#[test]
fn what_is_too_much_to_be_told_one_by_one_stands_together_and_is_counted() {
    let run = finished(1);
    let whole = graph(&run, GraphQuery::default());
    for limit in [1, 4, 8] {
        let part = graph(&run, GraphQuery { limit, ..GraphQuery::default() });
        assert_eq!((part.shown, part.nodes_total, part.truncated), (limit, whole.nodes_total, true));
        assert_eq!(part.nodes.iter().map(|node| node.members).sum::<u64>(), whole.nodes_total);
        assert_eq!(part.clusters, whole.clusters, "limit {limit}");
        assert!(
            part.nodes.iter().any(|node| node.kind == SchemaKind::Generalised && node.schema.is_some()),
            "laws come first"
        );
        let ended = |at: u32| (at as usize) < part.nodes.len();
        assert!(part.edges.iter().all(|edge| ended(edge.from) && ended(edge.to) && edge.from != edge.to));
        assert!(
            part.edges.iter().any(|edge| edge.kind == GraphTie::Carries && edge.count > 1),
            "{:?}",
            part.edges
        );
    }
}

#[test]
fn around_a_schema_there_is_what_it_is_tied_to() {
    let run = finished(1);
    let law = list(&run, SchemaQuery { generalised: true, ..SchemaQuery::default() }).schemas[0].id;
    let whole = graph(&run, GraphQuery::default());
    let ids = |graph: &Graph| -> BTreeSet<u32> {
        graph.nodes.iter().map(|node| node.schema.as_ref().unwrap().id).collect()
    };
    let all_ties: BTreeSet<(u32, u32)> = [
        GraphTie::Enables,
        GraphTie::Carries,
        GraphTie::ExampleOf,
        GraphTie::CounterExampleTo,
        GraphTie::ParentOf,
    ]
    .into_iter()
    .flat_map(|kind| ties(&whole, kind))
    .collect();
    for centre in 0..u32::try_from(whole.nodes.len()).unwrap() {
        let mut expected = BTreeSet::from([centre]);
        for depth in 1..=3 {
            let known = expected.clone();
            for (from, to) in &all_ties {
                if known.contains(from) || known.contains(to) {
                    expected.extend([*from, *to]);
                }
            }
            let found = graph(&run, GraphQuery { around: Some(centre), depth, ..GraphQuery::default() });
            assert_eq!(ids(&found), expected, "around {centre}, {depth} away");
            assert!(!found.truncated);
        }
    }
    let few = graph(&run, GraphQuery { around: Some(law), limit: 3, ..GraphQuery::default() });
    assert!(few.truncated && few.nodes_total > 3, "{few:?}");
    let kin = show(&run, law);
    let expected: BTreeSet<u32> = kin.examples.iter().copied().chain([law]).collect();
    assert_eq!(ids(&few), expected, "examples come first");
    assert!(problem(&run, &GraphQuery { around: Some(999), ..GraphQuery::default() }).contains("999"));
}

#[test]
fn the_chain_to_a_goal_is_the_plan() {
    let mut run = begun(1);
    let wanted = vec!["touch{}".to_owned()];
    let mut chains = 0;
    while run.advance().unwrap() == RunState::Running {
        let Ok(plan) = run.ask(&PlanQuery { goal: wanted.clone(), ..PlanQuery::default() }) else { continue };
        let query = GraphQuery { goal: wanted.clone(), ..GraphQuery::default() };
        if plan.steps.is_empty() {
            let said = problem(&run, &query);
            assert!(said.contains("holds already") || said.contains("nothing known leads there"), "{said}");
            continue;
        }
        let chain = graph(&run, query);
        assert_eq!((chain.probability, chain.goal.clone()), (plan.probability, plan.wanted.goal.clone()));
        let steps: Vec<_> = plan.steps.iter().filter_map(|step| Some(step.schema.as_ref()?.id)).collect();
        let next: BTreeSet<_> = steps.windows(2).map(|pair| (pair[0], pair[1])).collect();
        assert_eq!(ties(&chain, GraphTie::Next), next);
        let carried: BTreeSet<_> = plan
            .steps
            .iter()
            .filter_map(|step| Some((step.schema.as_ref()?.carrier?, step.schema.as_ref()?.id)))
            .collect();
        assert!(ties(&chain, GraphTie::Carries).is_superset(&carried), "{chain:?}");
        chains += 1;
    }
    assert!(chains > 0);
    let both = GraphQuery { around: Some(0), goal: wanted, ..GraphQuery::default() };
    assert!(problem(&run, &both).contains("one of them"));
}

#[test]
fn pages_of_a_list_make_up_the_list() {
    let run = finished(1);
    for sort in [SchemaSort::Age, SchemaSort::Uses, SchemaSort::Probability, SchemaSort::Excitation] {
        for post in [None, Some("finger{field=$x}".to_owned())] {
            let query = SchemaQuery { sort, post, ..SchemaQuery::default() };
            let whole = list(&run, query.clone());
            let mut paged = Vec::new();
            for offset in (0..).step_by(3) {
                let page = list(&run, SchemaQuery { limit: 3, offset, ..query.clone() });
                assert_eq!(page.matching, whole.matching);
                if page.schemas.is_empty() {
                    break;
                }
                paged.extend(page.schemas);
            }
            assert_eq!(paged, whole.schemas, "{sort:?}");
            assert!(list(&run, SchemaQuery { offset: u32::MAX, ..query }).schemas.is_empty());
        }
    }
}

/// In every step of a life, every schema is said to have been in the way of just what was in its way.
#[test]
fn why_not_agrees_with_what_was_weighed() {
    let mut run = begun(1);
    let mut seen = BTreeSet::new();
    while run.advance().unwrap() == RunState::Running {
        let Ok(told) = run.ask(&ExplanationQuery { step: None, candidates_max: 1000 }) else { continue };
        // A decision of some steps ago was made with another memory.
        let report = run.report();
        for schema in 0..report.schemas_total {
            match run.ask(&WhyNotQuery { schema, step: None }) {
                Ok(why) => {
                    agrees(&told, &why);
                    seen.insert(name(&why.verdict));
                }
                Err(problem) => {
                    assert!(told.step < report.step || problem.0.contains("only after"), "{problem}");
                }
            }
        }
    }
    for verdict in ["chosen", "pre-conditions", "less-exciting", "not-exciting", "executed-for"] {
        assert!(seen.contains(verdict), "{verdict} is not among {seen:?}");
    }
    assert!(problem(&run, &WhyNotQuery { schema: 999, step: None }).contains("999"));
    let beyond = problem(&run, &WhyNotQuery { schema: 0, step: Some(1_000_000) });
    assert!(beyond.contains("step 1000000 has not been taken yet"), "{beyond}");
}

fn name(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Chosen => "chosen",
        Verdict::ExecutedFor { .. } => "executed-for",
        Verdict::NotWeighed => "not-weighed",
        Verdict::Retired => "retired",
        Verdict::NotInRepertoire => "not-in-repertoire",
        Verdict::PreConditions { .. } => "pre-conditions",
        Verdict::TargetNotAchievable { .. } => "target-not-achievable",
        Verdict::StoodInFor { .. } => "stood-in-for",
        Verdict::OtherClaims { .. } => "other-claims",
        Verdict::NotExciting => "not-exciting",
        Verdict::LessExciting { .. } => "less-exciting",
        Verdict::LotFellOnAnother => "lot-fell-on-another",
    }
}

fn agrees(told: &Explanation, why: &WhyNot) {
    assert_eq!((told.step, &told.world, &told.action), (why.step, &why.world, &why.action));
    let chosen = &told.candidates[told.chosen as usize];
    assert_eq!(*chosen, why.chosen);
    let top = told.candidates[0].excitation;
    let listed: Vec<_> = told.candidates.iter().filter(|c| c.schema == Some(why.schema)).collect();
    let all_listed = told.candidates_total as usize == told.candidates.len();
    match &why.verdict {
        Verdict::Chosen => assert_eq!(chosen.schema, Some(why.schema)),
        Verdict::LessExciting { by } => {
            let candidate = why.candidate.as_ref().unwrap();
            assert!(*by > 0.0 && candidate.excitation + by == top, "{why:?}");
            assert!(!all_listed || listed.contains(&candidate), "{why:?}");
        }
        Verdict::LotFellOnAnother => {
            assert!(told.ties > 1 && why.candidate.as_ref().unwrap().excitation == top, "{why:?}");
        }
        Verdict::PreConditions { lacking } => {
            assert!(!lacking.is_empty() && listed.is_empty(), "{why:?}");
            for one in lacking {
                assert!(!told.world.contains(&one.wanted), "{why:?}");
                let of_type: Vec<_> = told.world.iter().filter(|seen| seen.kind == one.wanted.kind).collect();
                assert_eq!(one.nearest.is_some(), !of_type.is_empty(), "{why:?}");
                assert!(one.nearest.as_ref().is_none_or(|nearest| of_type.contains(&nearest)), "{why:?}");
            }
        }
        Verdict::StoodInFor { .. }
        | Verdict::OtherClaims { .. }
        | Verdict::NotExciting
        | Verdict::TargetNotAchievable { .. } => {
            assert!(listed.is_empty(), "{why:?}");
        }
        Verdict::ExecutedFor { schema } => assert_eq!(chosen.schema, Some(*schema)),
        Verdict::NotWeighed => assert!(matches!(told.reason, Reason::Chain | Reason::Goal)),
        Verdict::Retired | Verdict::NotInRepertoire => assert!(listed.is_empty(), "{why:?}"),
    }
}
