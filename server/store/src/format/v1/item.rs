//! The items of a memory. A snapshot's blocks hold them in bincode, and an export has one to a line in JSON; both have the
//! same items in the same order.

use std::sync::Arc;

use pschema_learner::digest;
use pschema_learner::evidence::{Beginnings, FoundFacet, Recollection};
use pschema_learner::experience::Experience as LiveExperience;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Content;
use pschema_learner::observation::PropertyId;
use pschema_learner::pursuit::Goal;
use pschema_learner::vocabulary::{ValueKind as LiveKind, Vocabulary};
use serde::{Deserialize, Serialize};

use super::claim::{
    BodyBeginnings, BodyMemory, BodyRecollection, ClaimTree, ExamplePlaces, FacetChange, FoundPool,
    PLACES_MAX, PoolEffect, PoolFacet, Singly, TreeClaim,
};
use super::execution::Execution;
use super::experience::{Experience, Mechanism, SyntheticItem};
use super::goal::{Policy, Pursuit, Wanted, Yield};
use super::observation::{Count, Observation};
use super::schema::Schema;
use super::setting::Setting;
use super::stage::{Progress, StageReport};
use super::vocabulary::{Body, DeclaredAction, DeclaredType, Parameter, ValueKind};
use crate::format::mirror::{Mirror, list};

/// Declares the kinds of items, each with its name.
macro_rules! items {
    ($($(#[$attribute:meta])* $kind:ident($content:ty) = $name:literal,)*) => {
        /// One part of a memory.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        pub(crate) enum Item {
            $($(#[$attribute])* #[serde(rename = $name)] $kind($content),)*
        }

        /// The kind of an item. Items of a memory come in the order of their kinds.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub(crate) enum Kind {
            $($kind,)*
        }

        impl Item {
            pub(crate) fn kind(&self) -> Kind {
                match self {
                    $(Self::$kind(_) => Kind::$kind,)*
                }
            }
        }

        impl Kind {
            /// What it is called in an export and in messages.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }
        }
    };
}

// What an item refers to by number stands before it, counted from 0 in each kind; but a schema may refer to later schemas.
items! {
    /// The first: what the memory lives under, and how much of it follows.
    Memory(Box<Outline>) = "memory",
    /// A property name.
    Property(Property) = "property",
    /// An observation type.
    Type(DeclaredType) = "type",
    /// A symbol; words are symbols.
    Symbol(String) = "symbol",
    /// An action.
    Action(DeclaredAction) = "action",
    /// An action with its parameters filled in.
    Primitive(Primitive) = "primitive",
    /// A body.
    Body(Body) = "body",
    /// An observation that memory refers to.
    Observation(KnownObservation) = "observation",
    /// A schema.
    Schema(Box<Schema>) = "schema",
    /// What is left in a pool of the curriculum; the number that is drawn next is at the end.
    Pool(Vec<i64>) = "pool",
    /// What happened in a stage.
    Stage(Box<StageReport>) = "stage",
    /// Where the curriculum stands.
    Progress(Box<Progress>) = "progress",
    /// The goal that is pursued, or was the last to be.
    Goal(Box<Pursuit>) = "goal",
    /// What a body was sent to do.
    Pending(Box<Pending>) = "pending",
    /// The generator of random numbers.
    Generator(Generator) = "generator",
    /// The last.
    End(End) = "end",
    /// Whether memory is full; it stands before the end, and only when it is so.
    Full(bool) = "full",
    /// How a body described itself; it stands before the end.
    Description(BodyDescription) = "description",
    /// The mechanisms beyond the paper that are on; it stands before the end, and only when there are any.
    Mechanisms(Vec<Mechanism>) = "mechanisms",
    /// An experience that is kept; it stands before the end.
    Experience(Box<KeptExperience>) = "experience",
    /// A synthetic item; it stands before the end.
    Supposed(Box<SyntheticItem>) = "synthetic_item",
    /// What a body supposes, of each body up to the last that supposes anything; it stands before the end.
    Line(BodyLine) = "line",
    /// What a body lived through of late, after what it lived through before; it stands before the end.
    Lived(Box<LivedExperience>) = "lived",
    /// What was found of the experiences of a pool, as it stands in the items after it; it stands before the end.
    Found(FoundPool) = "found",
    /// The own effect of a primitive; it stands before the end.
    OwnEffect(Box<PoolEffect>) = "own_effect",
    /// Types that change together, after those of the same pool that come before it; it stands before the end.
    Facet(PoolFacet) = "facet",
    /// A change that the claims of a facet speak of, after those that come before it; it stands before the end.
    Change(Box<FacetChange>) = "change",
    /// A tree of claims, those about the action before those about each primitive; it stands before the end.
    Tree(ClaimTree) = "tree",
    /// A claim, after those of the same tree that come before it; it stands before the end.
    Claim(Box<TreeClaim>) = "claim",
    /// The places of experiences among claims, after those that come before them; it stands before the end.
    Places(ExamplePlaces) = "places",
    /// What a body recalls, as it stands in the items after it; it stands before the end.
    Recalling(BodyMemory) = "recalling",
    /// What was there at last when an observation showed how a body was; it stands before the end.
    Recollection(Box<BodyRecollection>) = "recollection",
    /// The policy of one of the plans of the goal; it stands before the end.
    Policy(Box<PlanPolicy>) = "policy",
    /// What was to be learnt where episodes of a body began; it stands before the end.
    Beginnings(BodyBeginnings) = "beginnings",
    /// The numbers of the observation types that are values; it stands before the end, and only when there are any.
    Values(Vec<u16>) = "values",
    /// What is wanted, where that is not that something is observed; it stands before the end.
    Wanted(Box<Wanted>) = "wanted",
    /// What comes of a policy for most of something; it stands before the end.
    Yields(Box<PlanYields>) = "yields",
}

/// What a memory lives under, and how much of it follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Outline {
    /// Steps taken.
    pub(crate) step: u64,
    /// How many observations follow.
    pub(crate) observations: u64,
    /// How many schemas follow.
    pub(crate) schemas: u64,
    /// What the memory lives under, as in the manifest.
    pub(crate) setting: Setting,
}

/// A property name, with the values that a property of this name takes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Property {
    /// The name.
    pub(crate) name: String,
    /// The values that a property of this name takes.
    pub(crate) kind: ValueKind,
}

/// A primitive, with how often it was asked for and how often carried out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Primitive {
    /// The number of the action.
    pub(crate) action: u64,
    /// A value for each parameter of the action.
    pub(crate) parameters: Vec<Parameter>,
    /// `trials`: how often it was asked for; `occurrences`: how often it was carried out.
    pub(crate) attempts: Count,
}

/// An observation, with its counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct KnownObservation {
    /// The observation.
    pub(crate) observation: Observation,
    /// N(x) of equation (1).
    pub(crate) attention: u32,
    /// Before or after how many executions it was perceived, if it is an event.
    pub(crate) happened: u32,
}

/// The policy of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PlanPolicy {
    /// The number of the plan among those that are kept of the goal, from 0.
    pub(crate) plan: u32,
    /// The policy.
    pub(crate) policy: Box<Policy>,
}

/// What comes of a policy that came before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PlanYields {
    /// The number of the plan among those that are kept of the goal, from 0.
    pub(crate) plan: u32,
    /// What comes of each row.
    pub(crate) yields: Vec<Yield>,
}

/// What a body was sent to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Pending {
    /// The body.
    pub(crate) body: u16,
    /// What it was sent to do.
    pub(crate) execution: Execution,
}

/// How a body described itself when it attached last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyDescription {
    pub(crate) body: u16,
    pub(crate) text: String,
}

/// An experience that is kept in a pool, after those that were made before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct KeptExperience {
    /// The number of the action whose pool it is; `null` for the background.
    pub(crate) pool: Option<u64>,
    /// The experience.
    pub(crate) experience: Experience,
}

/// What a body supposes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyLine {
    /// The number of the body; all numbers follow each other from 0.
    pub(crate) body: u16,
    /// For each item whether it is supposed; of the last ones nothing may be known.
    pub(crate) on: Vec<bool>,
    /// Its experiences since the last item was made.
    pub(crate) taken: u64,
}

/// An experience of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct LivedExperience {
    /// The number of the body.
    pub(crate) body: u16,
    /// The experience.
    pub(crate) experience: Experience,
}

/// The state of the generator, from which all later random numbers follow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Generator {
    /// 16 hexadecimal digits: many readers of JSON can't take so large a number.
    pub(crate) state: String,
}

/// All of a memory has been read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct End {
    /// How many items come before this one.
    pub(crate) items: u64,
    /// The digest of the memory, in hexadecimal.
    pub(crate) memory_digest: String,
}

/// All items of a memory but the end.
pub(crate) fn items<'a>(content: &'a Content, setting: &Setting) -> impl Iterator<Item = Item> + 'a {
    let outline = Outline {
        step: content.step,
        observations: content.observations.len() as u64,
        schemas: content.schemas.len() as u64,
        setting: setting.clone(),
    };
    let observations = content.observations.iter().enumerate().map(|(at, observation)| {
        Item::Observation(KnownObservation {
            observation: Mirror::of(observation),
            attention: content.attention.get(at).copied().unwrap_or(0),
            happened: content.happened.get(at).copied().unwrap_or(0),
        })
    });
    let schemas = content.schemas.iter().map(|schema| Item::Schema(Box::new(Mirror::of(schema))));
    std::iter::once(Item::Memory(Box::new(outline)))
        .chain(vocabulary(content))
        .chain(observations)
        .chain(schemas)
        .chain(standing(content))
}

/// What bodies declared.
fn vocabulary(content: &Content) -> impl Iterator<Item = Item> + '_ {
    let vocabulary: &Vocabulary = &content.vocabulary;
    let properties = (0..).map(PropertyId).zip(vocabulary.properties()).map(|(id, name)| {
        let kind = vocabulary.property_kind(id).unwrap_or(&LiveKind::Integer);
        Item::Property(Property { name: name.clone(), kind: Mirror::of(kind) })
    });
    let types = vocabulary.types().iter().map(|known| Item::Type(Mirror::of(&known.declared)));
    let symbols = vocabulary.symbols().iter().map(|symbol| Item::Symbol(symbol.clone()));
    let actions = vocabulary.actions().iter().map(|action| Item::Action(Mirror::of(action)));
    let primitives = vocabulary.primitives().iter().enumerate().map(|(at, primitive)| {
        Item::Primitive(Primitive {
            action: Mirror::of(&primitive.action),
            parameters: list(&primitive.parameters),
            attempts: Mirror::of(&content.attempts.get(at).copied().unwrap_or_default()),
        })
    });
    let bodies = vocabulary.bodies().iter().map(|body| Item::Body(Mirror::of(body)));
    properties.chain(types).chain(symbols).chain(actions).chain(primitives).chain(bodies)
}

/// Where everything stands: the curriculum, the goal, what is under way, the generator.
fn standing(content: &Content) -> impl Iterator<Item = Item> + '_ {
    let progress = &content.progress;
    let pools = progress.pools.iter().map(|left| Item::Pool(left.to_vec()));
    let stages = progress.reports.iter().map(|report| Item::Stage(Box::new(Mirror::of(&**report))));
    let stands = Item::Progress(Box::new(Mirror::of(&**progress)));
    let goal = content.pursuit.iter().map(|pursuit| Item::Goal(Box::new(Mirror::of(&**pursuit))));
    let pending = (0..).zip(&content.pending).filter_map(|(body, execution)| {
        let execution = Mirror::of(&**execution.as_ref()?);
        Some(Item::Pending(Box::new(Pending { body, execution })))
    });
    let generator = Item::Generator(Generator { state: format!("{:016x}", content.random.state()) });
    let full = content.full.then_some(Item::Full(true));
    let descriptions = (0..).zip(&content.descriptions).filter_map(|(body, text)| {
        Some(Item::Description(BodyDescription { body, text: text.as_ref()?.to_string() }))
    });
    let mechanisms =
        (content.mechanisms != Mechanisms::PAPER).then(|| Item::Mechanisms(Mirror::of(&content.mechanisms)));
    let experiences = content.evidence.kept().map(|(pool, experience)| {
        Item::Experience(Box::new(KeptExperience {
            pool: Mirror::of(&pool),
            experience: Mirror::of(experience),
        }))
    });
    let plans = (0..).zip(content.pursuit.iter().flat_map(|pursuit| &pursuit.plans));
    let policies = plans.filter_map(|(plan, record)| {
        let policy = Mirror::of(record.policy.as_ref()?);
        Some(Item::Policy(Box::new(PlanPolicy { plan, policy })))
    });
    let beginnings = content.evidence.beginnings().map(|(body, Beginnings { is_next, learnable })| {
        let (all, count) = *learnable;
        let (body, is_next) = (Mirror::of(&body), *is_next);
        Item::Beginnings(BodyBeginnings { body, is_next, learnable: [all, count] })
    });
    let types = (0..).zip(content.vocabulary.types());
    let values: Vec<u16> = types.filter(|(_, known)| known.declared.value).map(|(kind, _)| kind).collect();
    let values = (!values.is_empty()).then_some(Item::Values(values));
    let wanted = content.pursuit.iter().filter(|pursuit| !matches!(pursuit.goal, Goal::Observed(_)));
    let wanted = wanted.map(|pursuit| {
        Item::Wanted(Box::new(Wanted { goal: Mirror::of(&pursuit.goal), came: pursuit.came }))
    });
    let plans = (0..).zip(content.pursuit.iter().flat_map(|pursuit| &pursuit.plans));
    let yields = plans.filter_map(|(plan, record)| {
        let yields = &record.policy.as_ref().filter(|policy| !policy.yields.is_empty())?.yields;
        Some(Item::Yields(Box::new(PlanYields { plan, yields: list(yields) })))
    });
    let items = content.items.all.iter().map(|item| Item::Supposed(Box::new(Mirror::of(item))));
    let lines = || (0..).zip(&content.items.lines);
    let supposed =
        lines().map(|(body, line)| Item::Line(BodyLine { body, on: line.on.clone(), taken: line.taken }));
    let lived = lines().flat_map(|(body, line)| {
        let one = move |experience: &Arc<LiveExperience>| {
            Item::Lived(Box::new(LivedExperience { body, experience: Mirror::of(&**experience) }))
        };
        line.recent.iter().map(one)
    });
    pools
        .chain(stages)
        .chain([stands])
        .chain(goal)
        .chain(pending)
        .chain([generator])
        .chain(full)
        .chain(descriptions)
        .chain(mechanisms)
        .chain(experiences)
        .chain(items)
        .chain(supposed)
        .chain(lived)
        .chain(std::iter::once_with(|| found(content)).flatten())
        .chain(policies)
        .chain(beginnings)
        .chain(values)
        .chain(wanted)
        .chain(yields)
}

/// What was found of the experiences that are kept, and what bodies recall.
fn found(content: &Content) -> Vec<Item> {
    let (mut pools, mut effects, mut facets) = (Vec::new(), Vec::new(), FacetItems::default());
    for (pool, found) in content.evidence.found() {
        let digest = digest::found(&found);
        let pool = Mirror::of(&pool);
        let key = Mirror::of(&found.key);
        pools.push(Item::Found(FoundPool { pool, key, facets: found.facets.len() as u64, digest }));
        for effect in found.effects.iter().map(Mirror::of) {
            effects.extend(pool.map(|pool| Item::OwnEffect(Box::new(PoolEffect { pool, effect }))));
        }
        found.facets.iter().for_each(|facet| facets.add(pool, facet, None));
    }
    let (mut bodies, mut recollections) = (Vec::new(), Vec::new());
    for (body, recalled) in content.evidence.recollections() {
        let body = Mirror::of(&body);
        bodies.push(Item::Recalling(BodyMemory { body, experiences: recalled.noted() }));
        recollections.extend(recalled.all().map(|Recollection { shown, noted, there }| {
            let (shown, there) = (Mirror::of(&shown), list(&there));
            Item::Recollection(Box::new(BodyRecollection { body, shown, noted, there }))
        }));
    }
    let FacetItems { facets, changes, trees, claims, places } = facets;
    [pools, effects, facets, changes, trees, claims, places, bodies, recollections].concat()
}

/// Facets, and what is found of each.
#[derive(Default)]
struct FacetItems {
    facets: Vec<Item>,
    changes: Vec<Item>,
    trees: Vec<Item>,
    claims: Vec<Item>,
    places: Vec<Item>,
}

impl FacetItems {
    /// Adds a facet of a pool; if it tells observations of another facet one by one, after that.
    fn add(&mut self, pool: Option<u64>, one: &FoundFacet, singly: Option<Singly>) {
        let facet = self.facets.len() as u64;
        self.facets.push(Item::Facet(PoolFacet {
            pool,
            kinds: list(&one.kinds),
            surprise: one.surprise,
            singly,
        }));
        let change = |change| Item::Change(Box::new(FacetChange { facet, change: Mirror::of(change) }));
        self.changes.extend(one.changes.iter().map(change));
        for grown in &one.grown {
            let tree = self.trees.len() as u64;
            let claim = |claim| Item::Claim(Box::new(TreeClaim { tree, claim: Mirror::of(claim) }));
            self.claims.extend(grown.claims.iter().map(claim));
            self.trees.push(Item::Tree(ClaimTree::of(facet, grown)));
        }
        let part = |places: &[_]| Item::Places(ExamplePlaces { facet, places: list(places) });
        self.places.extend(one.places.chunks(PLACES_MAX).map(part));
        let trial = one.trial.as_ref().map(|trial| (&trial.each, Some(trial.scores)));
        for (each, trial) in one.each.as_ref().map(|each| (each, None)).into_iter().chain(trial) {
            let (from, known) = (Mirror::of(&each.from), list(&each.known));
            self.add(pool, &each.facet, Some(Singly { facet, from, known, trial }));
        }
    }
}
