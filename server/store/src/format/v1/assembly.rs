//! Items to memory. Each is checked as it is taken: a file must not be able to make a learner look for what is not there.
//! The memory takes room in proportion to the items that came, whatever they say.

use std::collections::{HashSet, VecDeque};
use std::sync::Arc;

use pschema_learner::item::{self as live_item, EXPERIENCES_MAX, ITEMS_MAX};
use pschema_learner::memory::Content;
use pschema_learner::observation::{Observation, PropertyId, TypeId};
use pschema_learner::policy::Policy;
use pschema_learner::progress::{self, REPORTS_MAX};
use pschema_learner::pursuit::{Goal, Pursuit};
use pschema_learner::random::Random;
use pschema_learner::schema::{PreConditionInterner, SCHEMAS_MAX};
use pschema_learner::vocabulary::{self as live, BodyId, ValueKind, Vocabulary, VocabularyLists, limits};

use super::experience::SyntheticItem;
use super::finding::Finding;
use super::goal::Wanted;
use super::item::{
    BodyDescription, BodyLine, End, Generator, Item, Kind, KnownObservation, LivedExperience, Outline,
    Pending, PlanPolicy, PlanYields, Primitive, Property,
};
use super::schema::Schema;
use super::setting::Setting;
use super::vocabulary::DeclaredType;
use crate::content_error::ContentError;
use crate::extent::{Extent, STEPS_MAX, counted, limited, within};
use crate::format::mirror::Mirror;

/// Pools of a curriculum: far more than any has.
const POOLS_MAX: usize = 65_536;

/// Kinds of which a memory has one item at most, beside the first and the last.
const SINGLE: [Kind; 7] =
    [Kind::Progress, Kind::Goal, Kind::Generator, Kind::Full, Kind::Mechanisms, Kind::Values, Kind::Wanted];

type Taken = Result<(), ContentError>;

/// A memory that is whole, with what it lives under.
#[derive(Clone, Debug)]
pub(crate) struct WholeMemory {
    pub(crate) content: Content,
    pub(crate) setting: Setting,
    /// The digest that the end says it has.
    pub(crate) memory_digest: String,
}

/// A memory in the making.
#[derive(Debug)]
pub(crate) struct Assembly {
    setting: Setting,
    /// How many observations and schemas are announced.
    announced: (u64, u64),
    /// The kind of the last item.
    last: Kind,
    items: u64,
    names: HashSet<(Kind, String)>,
    lists: VocabularyLists,
    content: Content,
    finding: Finding,
    /// Once the vocabulary is whole.
    extent: Option<Extent>,
    observed: HashSet<Observation>,
    pre_conditions: PreConditionInterner,
}

impl Assembly {
    /// Begins with the first item.
    pub(crate) fn begin(item: Item) -> Result<Self, ContentError> {
        let last = item.kind();
        let Item::Memory(outline) = item else { return Err(ContentError::missing("memory")) };
        let Outline { step, observations, schemas, setting } = *outline;
        setting.checked()?;
        if step > STEPS_MAX {
            return Err(ContentError::value("the number of steps"));
        }
        let content = Content { step, ..Content::default() };
        Ok(Self {
            setting,
            announced: (observations, schemas),
            last,
            items: 1,
            names: HashSet::new(),
            lists: VocabularyLists::default(),
            content,
            finding: Finding::default(),
            extent: None,
            observed: HashSet::new(),
            pre_conditions: PreConditionInterner::default(),
        })
    }

    /// Takes the next item, which is not the end.
    pub(crate) fn take(&mut self, item: Item) -> Taken {
        let kind = item.kind();
        self.in_order(kind)?;
        match item {
            Item::Memory(_) | Item::End(_) => Err(ContentError::second(kind.name())),
            Item::Property(property) => self.property(kind, property),
            Item::Type(declared) => self.observation_type(kind, declared),
            Item::Symbol(symbol) => {
                self.named(kind, &symbol, self.lists.symbols.len(), limits::SYMBOLS_MAX)?;
                self.lists.symbols.push(symbol);
                Ok(())
            }
            Item::Action(action) => {
                self.named(kind, &action.name, self.lists.actions.len(), limits::ACTIONS_MAX)?;
                let action: live::DeclaredAction = action.live();
                action.parameters.iter().try_for_each(|declared| sound(&declared.kind))?;
                self.lists.actions.push(action);
                Ok(())
            }
            Item::Primitive(primitive) => self.primitive(primitive),
            Item::Body(body) => {
                self.named(kind, &body.name, self.lists.bodies.len(), limits::BODIES_MAX)?;
                self.lists.bodies.push(body.live());
                self.content.pending.push(None);
                Ok(())
            }
            item => self.of_content(item),
        }
    }

    /// Items that refer to the vocabulary.
    fn of_content(&mut self, item: Item) -> Taken {
        let kind = item.kind();
        match item {
            Item::Observation(known) => self.observation(known),
            Item::Schema(schema) => self.schema(*schema),
            Item::Pool(left) => {
                limited("pools", self.content.progress.pools.len() + 1, POOLS_MAX)?;
                Arc::make_mut(&mut self.content.progress).pools.push(Arc::new(left));
                Ok(())
            }
            Item::Stage(report) => {
                limited("reports of stages", self.content.progress.reports.len() + 1, REPORTS_MAX)?;
                Arc::make_mut(&mut self.content.progress).reports.push(Arc::new((*report).live()));
                Ok(())
            }
            Item::Progress(stands) => {
                let stands: progress::Progress = (*stands).live();
                self.extent()?.progress(&stands)?;
                let known = Arc::make_mut(&mut self.content.progress);
                let progress::Progress { pools, reports, .. } = std::mem::take(known);
                *known = progress::Progress { pools, reports, ..stands };
                Ok(())
            }
            Item::Goal(pursuit) => {
                let pursuit: Pursuit = (*pursuit).live();
                self.extent()?.pursuit(&pursuit)?;
                self.content.pursuit = Some(Arc::new(pursuit));
                Ok(())
            }
            Item::Pending(pending) => self.pending(*pending),
            Item::Generator(Generator { state }) => {
                let seed = u64::from_str_radix(&state, 16).ok().filter(|_| state.len() == 16);
                let seed = seed.ok_or(ContentError::value("the state of the generator"))?;
                self.content.random = Random::from_seed(seed);
                Ok(())
            }
            Item::Full(full) => {
                self.content.full = full;
                Ok(())
            }
            Item::Description(described) => self.description(described),
            Item::Mechanisms(mechanisms) => {
                self.content.mechanisms = mechanisms.live();
                Ok(())
            }
            Item::Experience(kept) => {
                self.extent()?;
                let extent = self.extent.as_ref().ok_or(ContentError::missing(Kind::Memory.name()))?;
                self.finding.experience(extent, *kept)
            }
            Item::Supposed(item) => self.synthetic_item(*item),
            Item::Line(line) => self.line(line),
            Item::Lived(lived) => self.lived(*lived),
            Item::Policy(policy) => self.policy(*policy),
            Item::Values(kinds) => self.values(&kinds),
            Item::Wanted(wanted) => self.wanted(*wanted),
            Item::Yields(yields) => self.yields(*yields),
            item if kind >= Kind::Found => {
                self.extent()?;
                let extent = self.extent.as_ref().ok_or(ContentError::missing(Kind::Memory.name()))?;
                self.finding.take(extent, item)
            }
            // All others were taken before.
            _ => Err(ContentError::second(kind.name())),
        }
    }

    /// The policy of a plan that came before.
    fn policy(&mut self, PlanPolicy { plan, policy }: PlanPolicy) -> Taken {
        let policy: Arc<Policy> = policy.live();
        self.extent()?.policy(&policy)?;
        let pursuit = self.content.pursuit.as_mut().map(Arc::make_mut);
        let record = pursuit.and_then(|pursuit| pursuit.plans.get_mut(plan as usize));
        let record = record.ok_or_else(|| {
            ContentError::new(format!("it is the policy of plan {plan}, and no goal before has such a plan"))
        })?;
        Arc::make_mut(record).policy = Some(policy);
        Ok(())
    }

    /// The types that are values.
    fn values(&mut self, kinds: &[u16]) -> Taken {
        let mut vocabulary = Vocabulary::clone(&self.extent()?.vocabulary);
        for kind in kinds.iter().copied().map(TypeId) {
            within("observation type", usize::from(kind.0), vocabulary.types().len())?;
            if !vocabulary.make_value(kind) {
                return Err(ContentError::value("a value, which is an event with one number for a property"));
            }
        }
        self.content.vocabulary = Arc::new(vocabulary);
        if let Some(extent) = &mut self.extent {
            extent.vocabulary = self.content.vocabulary.clone();
        }
        Ok(())
    }

    /// What is wanted of the goal that came before.
    fn wanted(&mut self, Wanted { goal, came }: Wanted) -> Taken {
        let goal: Goal = goal.live();
        self.extent()?.goal(&goal)?;
        let pursuit = self.content.pursuit.as_mut().map(Arc::make_mut);
        let pursuit =
            pursuit.filter(|pursuit| pursuit.goal.patterns() == goal.patterns() && came.is_finite());
        let pursuit = pursuit.ok_or(ContentError::value("what is wanted, for no such goal was before"))?;
        (pursuit.goal, pursuit.came) = (goal, came);
        Ok(())
    }

    /// What comes of the policy of a plan that came before.
    fn yields(&mut self, PlanYields { plan, yields }: PlanYields) -> Taken {
        let pursuit = self.content.pursuit.as_mut().map(Arc::make_mut);
        let record = pursuit.and_then(|pursuit| pursuit.plans.get_mut(plan as usize));
        let policy = record.and_then(|record| Arc::make_mut(record).policy.as_mut());
        let policy = policy.map(Arc::make_mut).ok_or_else(|| {
            ContentError::new(format!("it is of the policy of plan {plan}, and none before has that number"))
        })?;
        policy.yields = yields.live();
        if policy.is_sound() {
            return Ok(());
        }
        Err(ContentError::value("what comes of a policy, row by row"))
    }

    /// The memory, if all of it came.
    pub(crate) fn end(mut self, end: End) -> Result<WholeMemory, ContentError> {
        let Extent { observations: observed, schemas: learnt, .. } = *self.extent()?;
        let End { items, memory_digest } = end;
        if self.last < Kind::Generator {
            let item = if self.last < Kind::Progress { Kind::Progress } else { Kind::Generator };
            return Err(ContentError::missing(item.name()));
        }
        let Content { observations, schemas, .. } = &self.content;
        let counts = [
            ("items", items, self.items),
            ("observations", observed as u64, observations.len() as u64),
            ("schemas", learnt as u64, schemas.len() as u64),
        ];
        for (what, said, there) in counts {
            if said != there {
                return Err(ContentError::new(format!(
                    "{said} {what} are announced, and there are {there}: something is missing, or too much"
                )));
            }
        }
        let evidence = self.finding.end(&self.content.vocabulary)?;
        self.content.evidence = evidence;
        Ok(WholeMemory { content: self.content, setting: self.setting, memory_digest })
    }

    fn in_order(&mut self, kind: Kind) -> Taken {
        let before = std::mem::replace(&mut self.last, kind);
        self.items += 1;
        if kind < before {
            let (item, before) = (kind.name(), before.name());
            return Err(ContentError::new(format!(
                "`{item}` stands after `{before}`: something is missing, or out of order"
            )));
        }
        if kind == before && SINGLE.contains(&kind) {
            return Err(ContentError::second(kind.name()));
        }
        if before < Kind::Progress && kind > Kind::Progress {
            return Err(ContentError::missing(Kind::Progress.name()));
        }
        Ok(())
    }

    /// Notes the name of an item, of whose kind there are `count` so far.
    fn named(&mut self, kind: Kind, name: &str, count: usize, limit: usize) -> Taken {
        limited(kind.name(), count + 1, limit)?;
        if self.names.insert((kind, name.to_owned())) {
            return Ok(());
        }
        Err(ContentError::new(format!("the {} {name:?} was there before", kind.name())))
    }

    fn property(&mut self, kind: Kind, property: Property) -> Taken {
        self.named(kind, &property.name, self.lists.properties.len(), limits::PROPERTIES_MAX)?;
        let takes = property.kind.live();
        sound(&takes)?;
        self.lists.properties.push(property.name);
        self.lists.property_kinds.push(takes);
        Ok(())
    }

    fn observation_type(&mut self, kind: Kind, declared: DeclaredType) -> Taken {
        self.named(kind, &declared.name, self.lists.types.len(), limits::TYPES_MAX)?;
        let declared: live::DeclaredType = declared.live();
        let number = |property: &live::DeclaredProperty| {
            sound(&property.kind)?;
            let at = self.lists.properties.iter().position(|name| *name == property.name);
            let at = at.and_then(|at| u16::try_from(at).ok());
            at.map(PropertyId).ok_or_else(|| {
                let name = &property.name;
                ContentError::new(format!(
                    "it speaks of the property {name:?}, and nothing before has that name"
                ))
            })
        };
        let properties = declared.properties.iter().map(number).collect::<Result<_, _>>()?;
        self.lists.types.push(live::ObservationType { declared, properties });
        Ok(())
    }

    fn primitive(&mut self, Primitive { action, parameters, attempts }: Primitive) -> Taken {
        limited("primitives", self.lists.primitives.len() + 1, limits::PRIMITIVES_MAX)?;
        let (action, parameters): (usize, Vec<live::Parameter>) = (action.live(), parameters.live());
        within("action", action, self.lists.actions.len())?;
        let declared = self.lists.actions.get(action).map_or(&[][..], |action| &action.parameters);
        let fits = declared.len() == parameters.len()
            && declared.iter().zip(&parameters).all(|(declared, value)| declared.kind.takes(value));
        if !fits {
            return Err(ContentError::value("a parameter of the primitive"));
        }
        let attempts = attempts.live();
        counted(attempts)?;
        self.lists.primitives.push(live::Primitive { action, parameters });
        self.content.attempts.push(attempts);
        Ok(())
    }

    /// What numbers may refer to. The vocabulary is whole from here on: nothing is added to it any more.
    fn extent(&mut self) -> Result<&Extent, ContentError> {
        if self.extent.is_none() {
            let vocabulary = Vocabulary::from_lists(std::mem::take(&mut self.lists));
            let wrong = |lists| {
                ContentError::new(format!(
                    "its {lists} refer to something that is not there, or are too many"
                ))
            };
            self.content.vocabulary = Arc::new(vocabulary.map_err(wrong)?);
            let (observations, schemas) = self.announced;
            self.extent = Some(Extent {
                vocabulary: self.content.vocabulary.clone(),
                observations: announced("observations", observations, u32::MAX as usize)?,
                schemas: announced("schemas", schemas, SCHEMAS_MAX)?,
            });
        }
        self.extent.as_ref().ok_or(ContentError::missing(Kind::Memory.name()))
    }

    fn observation(&mut self, known: KnownObservation) -> Taken {
        let KnownObservation { observation, attention, happened } = known;
        let (observation, at) = (observation.live(), self.content.observations.len());
        let extent = self.extent()?;
        within("observation", at, extent.observations)?;
        extent.observation(&observation)?;
        if !self.observed.insert(observation.clone()) {
            return Err(ContentError::new("this observation was there before"));
        }
        self.content.observations.push(observation);
        self.content.attention.push(attention);
        self.content.happened.push(happened);
        Ok(())
    }

    fn schema(&mut self, schema: Schema) -> Taken {
        let (mut schema, at) = (schema.live(), self.content.schemas.len());
        let extent = self.extent()?;
        within("schema", at, extent.schemas)?;
        extent.schema(&schema)?;
        self.pre_conditions.share(&mut schema);
        self.content.generalised_count += u32::from(schema.generalised().is_some());
        self.content.schemas.push(schema);
        Ok(())
    }

    fn description(&mut self, BodyDescription { body, text }: BodyDescription) -> Taken {
        let bodies = self.extent()?.vocabulary.bodies().len();
        within("body", usize::from(body), bodies)?;
        limited("bytes of a description", text.len(), limits::DESCRIPTION_BYTES_MAX)?;
        self.content.descriptions.resize(bodies, None);
        match self.content.descriptions.get_mut(usize::from(body)) {
            Some(slot @ None) => {
                *slot = Some(text.into());
                Ok(())
            }
            _ => Err(ContentError::second(Kind::Description.name())),
        }
    }

    fn synthetic_item(&mut self, item: SyntheticItem) -> Taken {
        let item: live_item::Item = item.live();
        let known = self.content.items.all.len();
        limited("synthetic items", known + 1, ITEMS_MAX)?;
        self.extent()?.item(&item)?;
        Arc::make_mut(&mut self.content.items.all).push(item);
        Ok(())
    }

    fn line(&mut self, BodyLine { body, on, taken }: BodyLine) -> Taken {
        let bodies = self.extent()?.vocabulary.bodies().len();
        within("body", usize::from(body), bodies)?;
        limited("items of a body", on.len(), self.content.items.all.len())?;
        let lines = &mut self.content.items.lines;
        if lines.len() != usize::from(body) {
            return Err(ContentError::new("the lines of bodies do not follow each other"));
        }
        lines.push(live_item::Line { on, taken, recent: VecDeque::new() });
        Ok(())
    }

    fn lived(&mut self, LivedExperience { body, experience }: LivedExperience) -> Taken {
        let experience = experience.live();
        self.extent()?.lived(&experience)?;
        let lines = &mut self.content.items.lines;
        let count = lines.len();
        let Some(line) = lines.get_mut(usize::from(body)) else {
            return within("line of a body", usize::from(body), count);
        };
        limited("experiences of a body", line.recent.len() + 1, EXPERIENCES_MAX)?;
        line.recent.push_back(Arc::new(experience));
        Ok(())
    }

    fn pending(&mut self, Pending { body, execution }: Pending) -> Taken {
        let execution = execution.live();
        self.extent()?.execution(BodyId(body), &execution)?;
        match self.content.pending.get_mut(usize::from(body)) {
            Some(slot @ None) => {
                *slot = Some(Arc::new(execution));
                Ok(())
            }
            _ => Err(ContentError::second(Kind::Pending.name())),
        }
    }
}

/// How many were announced, if memory has room for them.
fn announced(what: &'static str, number: u64, limit: usize) -> Result<usize, ContentError> {
    let count = usize::try_from(number).unwrap_or(usize::MAX);
    limited(what, count, limit).map(|()| count)
}

/// Bins have a width.
fn sound(kind: &ValueKind) -> Taken {
    match kind {
        ValueKind::Real { resolution } if !(resolution.is_finite() && *resolution > 0.0) => {
            Err(ContentError::value("a resolution"))
        }
        _ => Ok(()),
    }
}
