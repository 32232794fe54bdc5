//! Lines to memory. A line says what is wrong with it as soon as it is read; what all of them together say is then checked
//! as a snapshot is.

use std::collections::HashMap;
use std::sync::Arc;

use pschema_learner::chunks::Chunks;
use pschema_learner::execution::{ChainLink, Execution};
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::{self as seen, PropertyId, Substitution, SymbolId, Term, TypeId};
use pschema_learner::probability::Count;
use pschema_learner::progress::{Progress, REPORTS_MAX, StageReport};
use pschema_learner::pursuit::{Ending, PLANS_KEPT_MAX, PlanCause, PlanRecord, Pursuit};
use pschema_learner::random::Random;
use pschema_learner::schema::{self as learnt, Form, ObservationId, PostCondition, SCHEMAS_MAX, SchemaId};
use pschema_learner::vocabulary::{
    self, BodyId, PrimitiveId, ValueKind, Vocabulary, VocabularyLists, limits,
};
use pschema_learner::world_state::WorldState;

use super::lines::*;
use super::values::*;

/// Pools in one curriculum.
const POOLS_MAX: usize = 65_536;

/// Memory in the making.
#[derive(Debug)]
pub(super) struct Reading {
    header: Header,
    parts: VocabularyLists,
    known: Known,
    content: Content,
    observed: HashMap<seen::Observation, ObservationId>,
    sharing: learnt::PreConditionInterner,
    stands: bool,
    generator: bool,
}

/// What has been named so far.
#[derive(Debug, Default)]
struct Known {
    types: HashMap<String, TypeId>,
    properties: HashMap<String, PropertyId>,
    symbols: HashMap<String, SymbolId>,
    actions: HashMap<String, usize>,
    bodies: HashMap<String, BodyId>,
}

type Said<T> = Result<T, String>;

impl Reading {
    /// Begins with what the first line says.
    pub(super) fn begin(line: Line) -> Said<Self> {
        let Line::Pschema(header) = line else {
            return Err(format!(
                "the first line must be a `pschema` line, and this is a `{}` line: it is no export, or not the \
                 beginning of one",
                line.name()
            ));
        };
        if header.format != FORMAT {
            let found = header.format;
            return Err(format!("it has format {found}, and this release reads formats 1 to {FORMAT}"));
        }
        let content = Content {
            vocabulary: Arc::default(),
            schemas: Chunks::default(),
            observations: Chunks::default(),
            attention: Chunks::default(),
            happened: Chunks::default(),
            attempts: Chunks::default(),
            pending: Vec::new(),
            progress: Progress::default(),
            pursuit: None,
            random: Random::from_seed(0),
            step: header.step,
            generalised_count: 0,
        };
        Ok(Self {
            header: *header,
            parts: VocabularyLists::default(),
            known: Known::default(),
            content,
            observed: HashMap::new(),
            sharing: learnt::PreConditionInterner::default(),
            stands: false,
            generator: false,
        })
    }

    /// Takes a line.
    pub(super) fn take(&mut self, line: Line) -> Said<()> {
        match line {
            Line::Pschema(_) => Err("a second `pschema` line: this is more than one export".to_owned()),
            Line::Property(line) => self.property(line),
            Line::Type(line) => self.observation_type(line),
            Line::Symbol(line) => self.symbol(line),
            Line::Action(line) => self.action(line),
            Line::Primitive(line) => self.primitive(line),
            Line::Body(line) => self.body(line),
            Line::Observation(line) => self.observation(&line),
            Line::Schema(line) => self.schema(*line),
            Line::Pool(line) => {
                room("pools", self.content.progress.pools.len(), POOLS_MAX)?;
                self.content.progress.pools.push(line.left);
                Ok(())
            }
            Line::Stage(line) => {
                room("stages", self.content.progress.reports.len(), REPORTS_MAX)?;
                self.content.progress.reports.push(report(*line));
                Ok(())
            }
            Line::Progress(line) => self.progress(*line),
            Line::Goal(line) => self.goal(*line),
            Line::Pending(line) => self.pending(&line),
            Line::Generator(line) => {
                let state = u64::from_str_radix(&line.state, 16).ok().filter(|_| line.state.len() == 16);
                let state = state.ok_or_else(|| {
                    format!("the state of the generator is 16 hexadecimal digits, not {:?}", line.state)
                })?;
                if std::mem::replace(&mut self.generator, true) {
                    return Err("a second `generator` line".to_owned());
                }
                self.content.random = Random::from_seed(state);
                Ok(())
            }
            Line::End(_) => Err("the `end` line stands before the end".to_owned()),
        }
    }

    /// What the lines say together, not yet checked, and what the first said of it.
    pub(super) fn end(self) -> Said<(Header, Content)> {
        let Self { header, parts, mut content, stands, generator, .. } = self;
        for (there, what) in [(stands, "progress"), (generator, "generator")] {
            if !there {
                return Err(format!("there is no `{what}` line: lines are missing"));
            }
        }
        let counts = [
            ("observations", header.observations, content.observations.len()),
            ("schemas", header.schemas, content.schemas.len()),
        ];
        for (what, said, there) in counts {
            if said != there as u64 {
                return Err(format!("the first line speaks of {said} {what}, and there are {there}"));
            }
        }
        let vocabulary = Vocabulary::from_lists(parts);
        let wrong = |what| format!("its {what} refer to something that is not there, or are too many");
        content.vocabulary = Arc::new(vocabulary.map_err(wrong)?);
        Ok((header, content))
    }

    fn property(&mut self, line: PropertyLine) -> Said<()> {
        let at = room("properties", self.parts.properties.len(), limits::PROPERTIES_MAX)?;
        let id = PropertyId(u16::try_from(at).unwrap_or(u16::MAX));
        new(self.known.properties.insert(line.name.clone(), id), "property", &line.name)?;
        self.parts.property_kinds.push(kind(line.kind, line.resolution)?);
        self.parts.properties.push(line.name);
        Ok(())
    }

    fn observation_type(&mut self, line: TypeLine) -> Said<()> {
        let at = room("observation types", self.parts.types.len(), limits::TYPES_MAX)?;
        let id = TypeId(u16::try_from(at).unwrap_or(u16::MAX));
        new(self.known.types.insert(line.name.clone(), id), "observation type", &line.name)?;
        let properties = line.properties.iter().map(|declared| self.known.property(&declared.name));
        let properties = properties.collect::<Said<_>>()?;
        let TypeLine { name, own, transient, heard, properties: lines } = line;
        let declared = vocabulary::DeclaredType { name, own, transient, heard, properties: declared(lines)? };
        self.parts.types.push(vocabulary::ObservationType { declared, properties });
        Ok(())
    }

    fn symbol(&mut self, line: SymbolLine) -> Said<()> {
        let at = room("symbols", self.parts.symbols.len(), limits::SYMBOLS_MAX)?;
        new(self.known.symbols.insert(line.name.clone(), SymbolId(number(at))), "symbol", &line.name)?;
        self.parts.symbols.push(line.name);
        Ok(())
    }

    fn action(&mut self, line: ActionLine) -> Said<()> {
        let at = room("actions", self.parts.actions.len(), limits::ACTIONS_MAX)?;
        new(self.known.actions.insert(line.name.clone(), at), "action", &line.name)?;
        let parameters = declared(line.parameters)?;
        self.parts.actions.push(vocabulary::DeclaredAction { name: line.name, parameters });
        Ok(())
    }

    fn primitive(&mut self, line: PrimitiveLine) -> Said<()> {
        let at = room("primitives", self.parts.primitives.len(), limits::PRIMITIVES_MAX)?;
        next("primitive", line.id, at)?;
        let action = self.known.actions.get(&line.action).copied();
        let action = action.ok_or_else(|| unknown("action", &line.action))?;
        let declared = self.parts.actions.get(action).map_or(&[][..], |action| &action.parameters);
        if declared.len() != line.parameters.0.len() {
            let (wanted, found) = (declared.len(), line.parameters.0.len());
            return Err(format!("action {:?} has {wanted} parameters, not {found}", line.action));
        }
        let named = declared.iter().zip(line.parameters.0);
        let parameters = named.map(|(declared, (name, value))| {
            if declared.name != name {
                return Err(format!("parameter {:?} is wanted where {name:?} stands", declared.name));
            }
            parameter(&declared.kind, value).ok_or_else(|| format!("parameter {name:?} takes other values"))
        });
        let parameters = parameters.collect::<Said<_>>()?;
        self.parts.primitives.push(vocabulary::Primitive { action, parameters });
        self.content.attempts.push(Count { occurrences: line.carried_out, trials: line.attempts });
        Ok(())
    }

    fn body(&mut self, line: BodyLine) -> Said<()> {
        let at = room("bodies", self.parts.bodies.len(), limits::BODIES_MAX)?;
        let id = BodyId(u16::try_from(at).unwrap_or(u16::MAX));
        new(self.known.bodies.insert(line.name.clone(), id), "body", &line.name)?;
        let repertoire = line.repertoire.into_iter().map(PrimitiveId).collect();
        self.parts.bodies.push(vocabulary::KnownBody { name: line.name, repertoire });
        self.content.pending.push(None);
        Ok(())
    }

    fn observation(&mut self, line: &ObservationLine) -> Said<()> {
        let at = room("observations", self.content.observations.len(), u32::MAX as usize)?;
        next("observation", line.id, at)?;
        let observation = self.known.observation(&line.observation)?;
        if self.observed.insert(observation.clone(), ObservationId(line.id)).is_some() {
            return Err("this observation stands in a line above".to_owned());
        }
        self.content.observations.push(observation);
        self.content.attention.push(line.attention);
        self.content.happened.push(line.happened);
        Ok(())
    }

    fn schema(&mut self, line: SchemaLine) -> Said<()> {
        let at = room("schemas", self.content.schemas.len(), SCHEMAS_MAX)?;
        next("schema", line.id, at)?;
        let ids = |ids: Vec<u32>| ids.into_iter().map(SchemaId).collect();
        let form = match (line.concrete, line.generalised) {
            (Some(form), None) => Form::Concrete(learnt::Concrete {
                pre: line.pre.iter().map(|one| self.observed(one)).collect::<Said<_>>()?,
                action: PrimitiveId(form.primitive),
                post: posts(line.post, |one| self.observed(one))?,
                contradicts: form.contradicts.map(SchemaId),
            }),
            (None, Some(form)) => {
                self.content.generalised_count += 1;
                Form::Generalised(Box::new(learnt::Generalised {
                    pre: self.known.patterns(&line.pre)?,
                    target: self.known.patterns(&form.target)?,
                    post: posts(line.post, |one| self.known.pattern(one))?,
                    examples: ids(form.examples),
                    counter_examples: ids(form.counter_examples),
                    retired: form.retired,
                }))
            }
            _ => return Err("a schema is either `concrete` or `generalised`".to_owned()),
        };
        let associations = line.associated.into_iter().map(|one| {
            Ok(learnt::Association {
                observation: self.observed(&one.observation)?,
                count: Count { occurrences: one.occurrences, trials: one.trials },
                since_step: one.since_step,
            })
        });
        let associations = associations.collect::<Said<_>>()?;
        let mut schema = learnt::Schema {
            form,
            executions: Count { occurrences: line.successes, trials: line.executions },
            associations,
            parent: line.parent.map(SchemaId),
            created_step: line.created_step,
        };
        self.sharing.share(&mut schema);
        self.content.schemas.push(schema);
        Ok(())
    }

    /// The number of an observation that stands in a line above.
    fn observed(&self, observation: &Observation) -> Said<ObservationId> {
        let found = self.known.observation(observation)?;
        self.observed.get(&found).copied().ok_or_else(|| {
            format!("an observation of type {:?} that no `observation` line above has", observation.kind)
        })
    }

    fn progress(&mut self, line: ProgressLine) -> Said<()> {
        if std::mem::replace(&mut self.stands, true) {
            return Err("a second `progress` line".to_owned());
        }
        let student = line.student.map(|name| self.known.body(&name)).transpose()?;
        let progress = &mut self.content.progress;
        let (pools, reports) = (std::mem::take(&mut progress.pools), std::mem::take(&mut progress.reports));
        *progress = Progress {
            student,
            pools,
            stage: usize::try_from(line.stage).unwrap_or(usize::MAX),
            begun: line.begun,
            finished: line.finished,
            held: line.held,
            stuck: line.stuck,
            trial_open: line.trial_open,
            trial_actions: line.trial_actions,
            absent_actions: line.absent_actions,
            trial_fresh: line.trial_fresh,
            said: line.said,
            quiet_actions: line.quiet_actions,
            habituating: line.habituating,
            reports,
        };
        Ok(())
    }

    fn goal(&mut self, line: GoalLine) -> Said<()> {
        if self.content.pursuit.is_some() {
            return Err("a second `goal` line".to_owned());
        }
        room("plans", line.plans.len().saturating_sub(1), PLANS_KEPT_MAX)?;
        let plans = line.plans.into_iter().map(|plan| {
            Ok(PlanRecord {
                after_actions: plan.after_actions,
                because: match plan.because {
                    BecauseWord::First => PlanCause::First,
                    BecauseWord::NotReached => PlanCause::NotReached,
                    BecauseWord::NextNotAllowed => PlanCause::NextNotAllowed,
                    BecauseWord::NotCarriedOut => PlanCause::NotCarriedOut,
                    BecauseWord::Interrupted => PlanCause::Interrupted,
                },
                chain: self.chain(plan.chain)?,
                probability: plan.probability,
                truncated: plan.truncated,
            })
        });
        self.content.pursuit = Some(Pursuit {
            number: line.number,
            body: self.known.body(&line.body)?,
            goal: self.known.patterns(&line.goal)?,
            actions_max: line.actions_max,
            actions: line.actions,
            plans_made: line.plans_made,
            plans: plans.collect::<Said<_>>()?,
            ended: line.ended.map(|ending| match ending {
                EndingWord::Achieved => Ending::Achieved,
                EndingWord::NothingLeadsThere => Ending::NothingLeadsThere,
                EndingWord::ActionsUsedUp => Ending::ActionsUsedUp,
                EndingWord::Constrained => Ending::Constrained,
                EndingWord::Cancelled => Ending::Cancelled,
            }),
        });
        Ok(())
    }

    fn pending(&mut self, line: &PendingLine) -> Said<()> {
        let body = self.known.body(&line.body)?;
        let before = line.before.iter().map(|one| self.known.observation(one));
        let before = before.collect::<Said<Vec<_>>>()?;
        let execution = Execution {
            schema: line.schema.map(SchemaId),
            binding: self.known.binding(&line.binding)?,
            carrier: line.carrier.map(SchemaId),
            action: PrimitiveId(line.primitive),
            before: WorldState::new(before),
            chain: self.chain(line.chain.clone())?,
            for_goal: line.for_goal,
        };
        match self.content.pending.get_mut(usize::from(body.0)) {
            Some(slot @ None) => {
                *slot = Some(Box::new(execution));
                Ok(())
            }
            _ => Err(format!("a second `pending` line of body {:?}", line.body)),
        }
    }

    fn chain(&self, links: Vec<LinkLine>) -> Said<Vec<ChainLink>> {
        let link = |line: LinkLine| {
            Ok(ChainLink {
                schema: SchemaId(line.schema),
                binding: self.known.binding(&line.binding)?,
                carrier: line.carrier.map(SchemaId),
            })
        };
        links.into_iter().map(link).collect()
    }
}

impl Known {
    fn property(&self, name: &str) -> Said<PropertyId> {
        self.properties.get(name).copied().ok_or_else(|| unknown("property", name))
    }

    fn body(&self, name: &str) -> Said<BodyId> {
        self.bodies.get(name).copied().ok_or_else(|| unknown("body", name))
    }

    fn kind(&self, name: &str) -> Said<TypeId> {
        self.types.get(name).copied().ok_or_else(|| unknown("type", name))
    }

    fn value(&self, value: &Value) -> Said<seen::Value> {
        Ok(match value {
            Value::Integer(number) => seen::Value::Integer(*number),
            Value::Boolean(value) => seen::Value::Boolean(*value),
            Value::Symbol(name) => {
                let symbol = self.symbols.get(name).copied();
                seen::Value::Symbol(symbol.ok_or_else(|| unknown("symbol", name))?)
            }
            Value::Bin(bin) => seen::Value::Bin(bin.bin),
            Value::Variable(Variable { var }) => {
                return Err(format!("${var} stands where only a value can"));
            }
        })
    }

    fn observation(&self, line: &Observation) -> Said<seen::Observation> {
        let properties = line.properties.0.iter();
        let properties = properties.map(|(name, value)| Ok((self.property(name)?, self.value(value)?)));
        Ok(seen::Observation::new(self.kind(&line.kind)?, properties.collect::<Said<Vec<_>>>()?))
    }

    fn pattern(&self, line: &Observation) -> Said<seen::Pattern> {
        let terms = line.properties.0.iter().map(|(name, value)| {
            let term = match value {
                Value::Variable(Variable { var }) => Term::Variable(variable(var)?),
                value => Term::Constant(self.value(value)?),
            };
            Ok((self.property(name)?, term))
        });
        Ok(seen::Pattern::new(self.kind(&line.kind)?, terms.collect::<Said<Vec<_>>>()?))
    }

    fn patterns<C: FromIterator<seen::Pattern>>(&self, lines: &[Observation]) -> Said<C> {
        lines.iter().map(|line| self.pattern(line)).collect()
    }

    fn binding(&self, line: &Binding) -> Said<Substitution> {
        let mut binding = Substitution::new();
        for (name, value) in &line.0 {
            binding.bind(variable(name)?, self.value(value)?);
        }
        Ok(binding)
    }
}

fn posts<T>(lines: Vec<Counted>, named: impl Fn(&Observation) -> Said<T>) -> Said<Vec<PostCondition<T>>> {
    let one = |line: Counted| {
        Ok(PostCondition {
            what: named(&line.observation)?,
            absent: line.absent,
            count: Count { occurrences: line.occurrences, trials: line.trials },
        })
    };
    lines.into_iter().map(one).collect()
}

fn report(line: StageLine) -> StageReport {
    StageReport {
        name: line.name,
        first_step: line.first_step,
        actions: line.actions,
        concrete_new: line.concrete_new,
        generalised_new: line.generalised_new,
        counter_examples_new: line.counter_examples_new,
        trials: line.trials,
        trials_met: line.trials_met,
        trials_met_first: line.trials_met_first,
        actions_of_trial: line.actions_of_trial,
        generalised_after_trial: line.generalised_after_trial,
        drawn: line.drawn,
        saturated: line.saturated,
        ended: line.ended,
    }
}

fn declared(lines: Vec<DeclaredLine>) -> Said<Vec<vocabulary::DeclaredProperty>> {
    let one = |line: DeclaredLine| {
        let kind = kind(line.kind, line.resolution)?;
        Ok(vocabulary::DeclaredProperty { name: line.name, unit: line.unit, kind })
    };
    lines.into_iter().map(one).collect()
}

fn kind(word: KindWord, resolution: Option<f64>) -> Said<ValueKind> {
    match (word, resolution) {
        (KindWord::Integer, None) => Ok(ValueKind::Integer),
        (KindWord::Symbol, None) => Ok(ValueKind::Symbol),
        (KindWord::Boolean, None) => Ok(ValueKind::Boolean),
        (KindWord::Real, Some(resolution)) if resolution.is_finite() && resolution > 0.0 => {
            Ok(ValueKind::Real { resolution })
        }
        (KindWord::Real, _) => Err("a real has a `resolution` above 0".to_owned()),
        (_, Some(_)) => Err("only a real has a `resolution`".to_owned()),
    }
}

/// A parameter's value, as its declaration says. A whole number may stand for a real.
fn parameter(kind: &ValueKind, value: Parameter) -> Option<vocabulary::Parameter> {
    Some(match (kind, value) {
        (ValueKind::Integer, Parameter::Integer(number)) => vocabulary::Parameter::Integer(number),
        (ValueKind::Symbol, Parameter::Symbol(symbol)) => vocabulary::Parameter::Symbol(symbol),
        (ValueKind::Boolean, Parameter::Boolean(value)) => vocabulary::Parameter::Boolean(value),
        (ValueKind::Real { .. }, Parameter::Real(real)) => vocabulary::Parameter::Real(real),
        (ValueKind::Real { .. }, Parameter::Integer(number)) => vocabulary::Parameter::Real(number as f64),
        _ => return None,
    })
}

/// The variable of this name.
fn variable(name: &str) -> Said<seen::Variable> {
    let mut variables = (0..=u8::MAX).map(seen::Variable);
    let found = variables.find(|variable| notation::variable(*variable) == name);
    found.ok_or_else(|| format!("{name:?} is no variable: they are a to z, then a1, b1 and so on"))
}

fn room(what: &str, there: usize, limit: usize) -> Said<usize> {
    if there < limit { Ok(there) } else { Err(format!("there are more than {limit} {what}, the limit")) }
}

fn next(what: &str, id: u32, wanted: usize) -> Said<()> {
    if id as usize == wanted {
        return Ok(());
    }
    Err(format!("{what} {id} stands where {what} {wanted} is next: lines are missing, or out of order"))
}

fn new<T>(before: Option<T>, what: &str, name: &str) -> Said<()> {
    match before {
        None => Ok(()),
        Some(_) => Err(format!("the {what} {name:?} stands in a line above")),
    }
}

fn unknown(what: &str, name: &str) -> String {
    format!("no line above declares the {what} {name:?}")
}

fn number(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}
