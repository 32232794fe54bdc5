//! Claims, what they foretell, and the evidence for their conditions.

use pschema_inspect as told;
use pschema_inspect::codec::Problem;
use pschema_inspect::{
    ClaimCondition, ClaimEvidence, ClaimList, ClaimOutcome, ClaimQuery, ClaimTree, ClaimView, Comparison,
    JointOutcome, NamedValue, ObservationText, OutcomeEvidence, ValueText,
};
use pschema_learner::claim::{Anchor, Change, Claim, Condition, Expression, Reference, Sketch};
use pschema_learner::evidence::{About, Foretold, View as Basis};
use pschema_learner::goals;
use pschema_learner::item::{Event, Item, Update};
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::probability::Count;
use pschema_learner::schema::{Form, Schema};
use pschema_learner::vocabulary::{BodyId, PrimitiveId, ValueKind};
use pschema_learner::world_state::WorldState;

use super::question::Inspect;
use super::text;
use crate::view::View;

/// Most trees in one list.
const TREES_MAX: u32 = 1_000;

impl Inspect for ClaimQuery {
    fn answer(&self, view: &View) -> Result<ClaimList, Problem> {
        let content = &view.content;
        if content.evidence.is_empty() && !content.mechanisms.claims {
            return Err(Problem::of(
                "no claims are kept: the learner's profile is paper. A daemon whose curriculum and configuration do not say \
                 profile = \"paper\" keeps them",
            ));
        }
        let vocabulary = &content.vocabulary;
        let asked = asked(content, self.action.as_deref())?;
        let items = content.items.all.iter().filter(|item| !item.dropped);
        let items = items.filter(|item| asked.iter().any(|about| is_about(content, *about, item.primitive)));
        let items = items.map(|item| one_item(content, item)).collect();
        let trees = asked.into_iter().flat_map(|about| {
            let claims = content.evidence.claims(vocabulary, about);
            claims.into_iter().map(move |(kinds, claim)| (about, kinds, claim))
        });
        let trees: Vec<_> = trees.collect();
        let limit = if self.limit == 0 { TREES_MAX } else { self.limit.min(TREES_MAX) };
        let size = |count: u32| usize::try_from(count).unwrap_or(usize::MAX);
        let page = trees.iter().skip(size(self.offset)).take(size(limit));
        Ok(ClaimList {
            matching: u32::try_from(trees.len()).unwrap_or(u32::MAX),
            claims: page.map(|(about, kinds, claim)| tree(content, *about, kinds, claim)).collect(),
            items,
        })
    }
}

/// What is asked about: an action by its name, a primitive as it prints; or each action, and whatever is done.
fn asked(content: &Content, action: Option<&str>) -> Result<Vec<About>, Problem> {
    let vocabulary = &content.vocabulary;
    let actions = vocabulary.actions();
    let Some(given) = action else {
        return Ok((0..actions.len()).map(About::Action).chain([About::Anything]).collect());
    };
    if let Some(at) = actions.iter().position(|known| known.name == given.trim()) {
        return Ok(vec![About::Action(at)]);
    }
    let all = 0..u32::try_from(vocabulary.primitives().len()).unwrap_or(u32::MAX);
    let primitives: Vec<_> = all.map(PrimitiveId).collect();
    let primitive = notation::parse_primitive(vocabulary, &primitives, given).map_err(Problem::of)?;
    Ok(vec![About::Primitive(primitive)])
}

/// Whether claims about this tell of a primitive.
fn is_about(content: &Content, about: About, primitive: PrimitiveId) -> bool {
    match about {
        About::Primitive(one) => one == primitive,
        about => Words::about_action(content, primitive) == about,
    }
}

fn one_item(content: &Content, item: &Item) -> told::SyntheticItem {
    let vocabulary = &content.vocabulary;
    let number = content.items.all.iter().position(|known| known.kind == item.kind);
    let supposes = |body: &usize| {
        let on = content.items.lines.get(*body).and_then(|line| line.on.get(number?));
        on.copied().unwrap_or(false)
    };
    let bodies = vocabulary.bodies().iter().enumerate().filter(|(body, _)| supposes(body));
    let event = |(event, update): &(Event, Update)| told::ItemEvent {
        action: notation::primitive(vocabulary, event.primitive),
        after: text::observations(vocabulary, &event.after),
        update: match update {
            Update::On => told::ItemUpdate::On,
            Update::Off => told::ItemUpdate::Off,
            Update::Turn => told::ItemUpdate::Turn,
        },
    };
    told::SyntheticItem {
        name: text::kind(vocabulary, item.kind),
        action: notation::primitive(vocabulary, item.primitive),
        types: types(content, &item.kinds),
        supposed_by: bodies.map(|(_, body)| body.name.clone()).collect(),
        events: item.updates.iter().map(event).collect(),
    }
}

fn tree(content: &Content, about: About, kinds: &[TypeId], claim: &Claim) -> ClaimTree {
    let vocabulary = &content.vocabulary;
    ClaimTree {
        action: match about {
            About::Action(at) => vocabulary.actions().get(at).map(|known| known.name.clone()),
            About::Primitive(primitive) => Some(notation::primitive(vocabulary, primitive)),
            About::Anything => None,
        },
        types: types(content, kinds),
        each: claim.is_of_each(),
        claim: Words::new(content, about).claim(claim, None),
    }
}

fn types(content: &Content, kinds: &[TypeId]) -> Vec<String> {
    kinds.iter().map(|kind| text::kind(&content.vocabulary, *kind)).collect()
}

/// What claims foretell of an action in a world, by what a body recalls, if it is one's; nothing where none are kept.
pub(super) fn foretold(
    content: &Content,
    body: Option<BodyId>,
    action: PrimitiveId,
    world: &WorldState,
) -> Vec<told::Foretold> {
    let foretold = goals::foretell(content, body, world, action);
    foretold.iter().map(|facet| one_foretold(content, action, world, facet)).collect()
}

fn one_foretold(
    content: &Content,
    primitive: PrimitiveId,
    world: &WorldState,
    from: &Foretold,
) -> told::Foretold {
    let vocabulary = &content.vocabulary;
    let (view, about) = match from.view {
        Basis::General => (ClaimView::General, Words::about_action(content, primitive)),
        Basis::Particular => (ClaimView::Primitive, About::Primitive(primitive)),
        Basis::Remembered => (ClaimView::Context, About::Primitive(primitive)),
    };
    let conditions = from.claim.as_ref().map_or(&[][..], |(conditions, _)| conditions);
    let known = content.evidence.claims(vocabulary, about);
    let claim = known.iter().find(|(kinds, _)| *kinds == from.kinds).map(|(_, claim)| *claim);
    let words = Words::new(content, about);
    let observations = |list: &[Observation]| text::observations(vocabulary, list);
    // An event is over with its frame: what comes after is another one.
    let lasts = |kind: TypeId| {
        let known = vocabulary.types().get(usize::from(kind.0));
        known.is_some_and(|known| !known.declared.transient)
    };
    let before = world.observations().iter().filter(|o| from.kinds.contains(&o.kind()) && lasts(o.kind()));
    let before: Vec<_> = before.collect();
    let outcome = |(after, times): &(Vec<Observation>, u32)| {
        let appears: Vec<_> = after.iter().filter(|o| !before.contains(o)).cloned().collect();
        let vanishes: Vec<_> = before.iter().filter(|o| !after.contains(o)).map(|o| (*o).clone()).collect();
        let count = Count { occurrences: *times, trials: from.trials };
        let (low, high) = count.interval();
        JointOutcome {
            observed: observations(after),
            appears: observations(&appears),
            vanishes: observations(&vanishes),
            occurrences: *times,
            probability: count.ratio(),
            low,
            high,
        }
    };
    told::Foretold {
        types: types(content, &from.kinds),
        each: from.is_of_each,
        view,
        because: claim.map(|claim| words.in_force(claim, conditions)).unwrap_or_default(),
        attributed: from.attributed,
        outcomes: from.outcomes.iter().map(outcome).collect(),
        trials: from.trials,
    }
}

/// What claims foretell of an action in a world, of the types that a schema tells of.
pub(super) fn of_schema(
    content: &Content,
    body: Option<BodyId>,
    schema: &Schema,
    action: PrimitiveId,
    world: &WorldState,
) -> Vec<told::Foretold> {
    let kinds: Vec<_> = match &schema.form {
        Form::Concrete(known) => {
            known.post.iter().map(|post| content.observation(post.what).kind()).collect()
        }
        Form::Generalised(law) => law.post.iter().map(|post| post.what.kind()).collect(),
    };
    let mut foretold = goals::foretell(content, body, world, action);
    foretold.retain(|facet| facet.kinds.iter().any(|kind| kinds.contains(kind)));
    foretold.iter().map(|facet| one_foretold(content, action, world, facet)).collect()
}

/// The claims that a schema rests on: what they foretell of its action where its pre-conditions hold and nothing else is there. Of a
/// law it is what they foretell where it was found, under the pre-conditions of its first example.
pub(super) fn beneath(content: &Content, schema: &Schema) -> Vec<told::Foretold> {
    let found = || content.concrete(*schema.generalised()?.examples.first()?);
    let Some(concrete) = schema.concrete().or_else(found) else { return Vec::new() };
    let pre = concrete.pre.iter().map(|id| content.observation(*id).clone());
    of_schema(content, None, schema, concrete.action, &WorldState::new(pre))
}

/// What each observation by itself comes to, of the joint outcomes: how often it appears, and how often it vanishes.
pub(super) fn singly(foretold: &[told::Foretold]) -> Vec<told::Condition> {
    let mut found: Vec<told::Condition> = Vec::new();
    for facet in foretold {
        let from = found.len();
        for outcome in &facet.outcomes {
            let parts = [(&outcome.appears, false), (&outcome.vanishes, true)];
            let parts = parts.into_iter().flat_map(|(part, absent)| part.iter().map(move |o| (o, absent)));
            for (observation, absent) in parts {
                let known = found.get_mut(from..).and_then(|of_facet| {
                    of_facet.iter_mut().find(|c| c.absent == absent && c.observation == *observation)
                });
                let before = known.as_ref().map_or(0, |known| known.occurrences);
                let count = Count { occurrences: before + outcome.occurrences, trials: facet.trials };
                let counted = text::condition(observation.clone(), absent, count);
                match known {
                    Some(known) => *known = counted,
                    None => found.push(counted),
                }
            }
        }
    }
    found
}

/// Claims about one thing that is done, by names.
struct Words<'a> {
    content: &'a Content,
    /// The number of the action, of which the parameters are.
    action: Option<usize>,
}

impl<'a> Words<'a> {
    fn new(content: &'a Content, about: About) -> Self {
        let action = match about {
            About::Action(action) => Some(action),
            About::Primitive(primitive) => match Self::about_action(content, primitive) {
                About::Action(action) => Some(action),
                _ => None,
            },
            About::Anything => None,
        };
        Self { content, action }
    }

    /// The action that a primitive is one of.
    fn about_action(content: &Content, primitive: PrimitiveId) -> About {
        let at = usize::try_from(primitive.0).unwrap_or(usize::MAX);
        content.vocabulary.primitives().get(at).map_or(About::Anything, |known| About::Action(known.action))
    }

    fn claim(&self, claim: &Claim, because: Option<ClaimEvidence>) -> told::Claim {
        let outcome = |(change, count): &(Change, u32)| ClaimOutcome {
            change: self.change(change),
            occurrences: *count,
        };
        let exceptions = claim.exceptions.iter().enumerate();
        told::Claim {
            because,
            outcomes: claim.outcomes.iter().map(outcome).collect(),
            trials: claim.trials,
            exceptions: exceptions.map(|(at, below)| self.claim(below, self.evidence(claim, at))).collect(),
        }
    }

    /// The evidence for each of the conditions that lead from the most general claim to the one in force.
    fn in_force(&self, mut claim: &Claim, conditions: &[Condition]) -> Vec<ClaimEvidence> {
        let mut found = Vec::new();
        for condition in conditions {
            let at = claim.exceptions.iter().position(|below| below.condition.as_ref() == Some(condition));
            let Some(at) = at else { break };
            found.extend(self.evidence(claim, at));
            claim = &claim.exceptions[at];
        }
        found
    }

    /// The evidence for the condition of the exception `at` to a claim.
    fn evidence(&self, claim: &Claim, at: usize) -> Option<ClaimEvidence> {
        let exception = claim.exceptions.get(at)?;
        let evidence = claim.evidence(at);
        let outcome = |(change, with, without): &(&Change, u32, u32)| OutcomeEvidence {
            change: self.change(change),
            with: *with,
            without: *without,
        };
        Some(ClaimEvidence {
            condition: self.condition(exception.condition.as_ref()?),
            gain_bits: exception.gain / std::f64::consts::LN_2,
            trials_with: evidence.with,
            trials_without: evidence.without,
            outcomes: evidence.outcomes.iter().map(outcome).collect(),
        })
    }

    fn condition(&self, condition: &Condition) -> ClaimCondition {
        let compared = |anchor: Anchor, value: Value| Comparison {
            named: self.reference(anchor.into()),
            value: text::value_of_kind(&self.content.vocabulary, self.kind(anchor), value),
        };
        match condition {
            Condition::Observed(sketch) => ClaimCondition::Observed(self.sketch(sketch)),
            Condition::Recalled(sketch) => ClaimCondition::Recalled(self.sketch(sketch)),
            Condition::Is(anchor, value) => ClaimCondition::Is(compared(*anchor, *value)),
            Condition::AtLeast(anchor, least) => {
                let value = match self.kind(*anchor) {
                    Some(ValueKind::Real { .. }) => Value::Bin(*least),
                    _ => Value::Integer(*least),
                };
                ClaimCondition::AtLeast(compared(*anchor, value))
            }
        }
    }

    /// The kind of the values that an anchor names.
    fn kind(&self, anchor: Anchor) -> Option<&'a ValueKind> {
        let vocabulary = &self.content.vocabulary;
        match anchor {
            Anchor::Parameter(at) => {
                let action = vocabulary.actions().get(self.action?)?;
                action.parameters.get(usize::from(at)).map(|declared| &declared.kind)
            }
            Anchor::Effect(_, property) | Anchor::Only(_, property) | Anchor::Itself(property) => {
                vocabulary.property_kind(property)
            }
            Anchor::Age => None,
        }
    }

    fn change(&self, change: &Change) -> told::Change {
        let sketches = |list: &[Sketch]| list.iter().map(|one| self.sketch(one)).collect();
        told::Change {
            becomes: sketches(&change.becomes),
            vanishes: sketches(&change.vanishes),
            appears: sketches(&change.appears),
        }
    }

    fn sketch(&self, sketch: &Sketch) -> ObservationText {
        let vocabulary = &self.content.vocabulary;
        let property = |(property, expression): &(PropertyId, Expression)| {
            let value = match *expression {
                Expression::Constant(value) => text::value(vocabulary, *property, value),
                Expression::Named(reference, more) => {
                    let unit = match vocabulary.property_kind(*property) {
                        Some(ValueKind::Real { resolution }) => *resolution,
                        _ => 1.0,
                    };
                    #[expect(clippy::cast_precision_loss, reason = "a difference of what is seen is small")]
                    let more = more as f64 * unit;
                    ValueText::Named {
                        named: Box::new(NamedValue { reference: self.reference(reference), more }),
                    }
                }
            };
            (text::property(vocabulary, *property), value)
        };
        ObservationText {
            kind: text::kind(vocabulary, sketch.kind),
            properties: sketch.properties.iter().map(property).collect(),
        }
    }

    fn reference(&self, reference: Reference) -> told::Reference {
        let vocabulary = &self.content.vocabulary;
        let kind = |kind: TypeId| text::kind(vocabulary, kind);
        let property = |property: PropertyId| text::property(vocabulary, property);
        match reference {
            Reference::Parameter(at) => {
                let action = self.action.and_then(|action| vocabulary.actions().get(action));
                let declared = action.and_then(|action| action.parameters.get(usize::from(at)));
                let parameter = declared.map(|declared| declared.name.clone()).unwrap_or_default();
                told::Reference::Parameter { parameter }
            }
            Reference::Effect(of, at) => told::Reference::Effect { kind: kind(of), property: property(at) },
            Reference::Only(of, at) => told::Reference::Only { kind: kind(of), property: property(at) },
            Reference::Itself(at) => told::Reference::Itself { property: property(at) },
            Reference::Recalled(of, at) => {
                told::Reference::Recalled { kind: kind(of), property: property(at) }
            }
            Reference::Age => told::Reference::Age,
            Reference::Tied { from, kind: of, at, to } => told::Reference::Tied {
                kind: kind(of),
                at: property(at),
                from: Box::new(self.reference(from.into())),
                property: property(to),
            },
        }
    }
}
