//! Memory to lines.

use pschema_learner::digest::digest;
use pschema_learner::execution::{ChainLink, Execution};
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::{self as seen, Substitution, Term};
use pschema_learner::probability::Count;
use pschema_learner::progress::StageReport;
use pschema_learner::pursuit::{Ending, PlanCause, PlanRecord, Pursuit};
use pschema_learner::schema::{self as learnt, Form, PostCondition};
use pschema_learner::vocabulary::{self, BodyId, Primitive, ValueKind, Vocabulary, bin_middle};

use super::lines::*;
use super::values::*;
use super::{About, FORMAT};

/// All lines of a memory, the end with its own left out.
pub(super) fn lines<'a>(content: &'a Content, about: &'a About<'a>) -> impl Iterator<Item = Line> + 'a {
    let vocabulary = &*content.vocabulary;
    let names = Names(vocabulary);
    std::iter::once(header(content, about))
        .chain(vocabulary_lines(content))
        .chain(observations(content, names))
        .chain(content.schemas.iter().enumerate().map(move |(at, one)| schema(content, names, at, one)))
        .chain(standing(content, names))
}

fn header(content: &Content, about: &About<'_>) -> Line {
    Line::Pschema(Box::new(Header {
        format: FORMAT,
        learner: about.learner.to_owned(),
        seed: about.seed,
        step: content.step,
        observations: content.observations.len() as u64,
        schemas: content.schemas.len() as u64,
        memory_digest: digest(content),
        setting: about.setting(),
    }))
}

fn vocabulary_lines(content: &Content) -> impl Iterator<Item = Line> + '_ {
    let vocabulary = &*content.vocabulary;
    let properties = vocabulary.properties().iter().enumerate().map(|(at, name)| {
        let id = seen::PropertyId(u16::try_from(at).unwrap_or(u16::MAX));
        let (kind, resolution) = kind(vocabulary.property_kind(id).unwrap_or(&ValueKind::Integer));
        Line::Property(PropertyLine { name: name.clone(), kind, resolution })
    });
    let types = vocabulary.types().iter().map(|known| {
        let vocabulary::DeclaredType { name, own, transient, heard, properties } = &known.declared;
        let (own, transient, heard) = (*own, *transient, *heard);
        Line::Type(TypeLine { name: name.clone(), own, transient, heard, properties: declared(properties) })
    });
    let symbols = vocabulary.symbols().iter().map(|name| Line::Symbol(SymbolLine { name: name.clone() }));
    let actions = vocabulary.actions().iter().map(|action| {
        Line::Action(ActionLine { name: action.name.clone(), parameters: declared(&action.parameters) })
    });
    let primitives = vocabulary.primitives().iter().enumerate();
    let primitives = primitives.map(|(at, one)| primitive(content, at, one));
    let bodies = vocabulary.bodies().iter().map(|body| {
        let repertoire = body.repertoire.iter().map(|id| id.0).collect();
        Line::Body(BodyLine { name: body.name.clone(), repertoire })
    });
    properties.chain(types).chain(symbols).chain(actions).chain(primitives).chain(bodies)
}

fn primitive(content: &Content, at: usize, primitive: &Primitive) -> Line {
    let action = content.vocabulary.actions().get(primitive.action);
    let name = action.map(|action| action.name.clone()).unwrap_or_default();
    let named = action.into_iter().flat_map(|action| &action.parameters).zip(&primitive.parameters);
    let parameters = named.map(|(declared, value)| {
        let value = match value {
            vocabulary::Parameter::Integer(number) => Parameter::Integer(*number),
            vocabulary::Parameter::Symbol(symbol) => Parameter::Symbol(symbol.clone()),
            vocabulary::Parameter::Boolean(value) => Parameter::Boolean(*value),
            vocabulary::Parameter::Real(value) => Parameter::Real(*value),
        };
        (declared.name.clone(), value)
    });
    let attempts = content.attempts.get(at).copied().unwrap_or_default();
    Line::Primitive(PrimitiveLine {
        id: number(at),
        action: name,
        parameters: Named(parameters.collect()),
        attempts: attempts.trials,
        carried_out: attempts.occurrences,
    })
}

fn declared(properties: &[vocabulary::DeclaredProperty]) -> Vec<DeclaredLine> {
    let one = |property: &vocabulary::DeclaredProperty| {
        let (kind, resolution) = kind(&property.kind);
        DeclaredLine { name: property.name.clone(), unit: property.unit.clone(), kind, resolution }
    };
    properties.iter().map(one).collect()
}

fn kind(kind: &ValueKind) -> (KindWord, Option<f64>) {
    match kind {
        ValueKind::Integer => (KindWord::Integer, None),
        ValueKind::Symbol => (KindWord::Symbol, None),
        ValueKind::Boolean => (KindWord::Boolean, None),
        ValueKind::Real { resolution } => (KindWord::Real, Some(*resolution)),
    }
}

fn observations<'a>(content: &'a Content, names: Names<'a>) -> impl Iterator<Item = Line> + 'a {
    content.observations.iter().enumerate().map(move |(at, one)| {
        Line::Observation(ObservationLine {
            id: number(at),
            observation: names.observation(one),
            attention: content.attention.get(at).copied().unwrap_or(0),
            happened: content.happened.get(at).copied().unwrap_or(0),
        })
    })
}

fn schema(content: &Content, names: Names<'_>, at: usize, schema: &learnt::Schema) -> Line {
    let known = |id: &learnt::ObservationId| names.observation(content.observation(*id));
    let ids = |ids: &[learnt::SchemaId]| ids.iter().map(|id| id.0).collect();
    let (pre, post, concrete, generalised) = match &schema.form {
        Form::Concrete(form) => {
            let line = ConcreteLine {
                primitive: form.action.0,
                action: notation::primitive(&content.vocabulary, form.action),
                contradicts: form.contradicts.map(|id| id.0),
            };
            (form.pre.iter().map(known).collect(), counted(&form.post, known), Some(line), None)
        }
        Form::Generalised(form) => {
            let lifted = |pattern: &seen::Pattern| names.pattern(pattern);
            let line = GeneralisedLine {
                target: form.target.iter().map(lifted).collect(),
                examples: ids(&form.examples),
                counter_examples: ids(&form.counter_examples),
                retired: form.retired,
            };
            (form.pre.iter().map(lifted).collect(), counted(&form.post, lifted), None, Some(line))
        }
    };
    let associated = schema.associations.iter().map(|one| Associated {
        observation: known(&one.observation),
        occurrences: one.count.occurrences,
        trials: one.count.trials,
        since_step: one.since_step,
    });
    let Count { occurrences, trials } = schema.executions;
    Line::Schema(Box::new(SchemaLine {
        id: number(at),
        created_step: schema.created_step,
        parent: schema.parent.map(|id| id.0),
        executions: trials,
        successes: occurrences,
        pre,
        concrete,
        generalised,
        post,
        associated: associated.collect(),
    }))
}

fn counted<T>(post: &[PostCondition<T>], named: impl Fn(&T) -> Observation) -> Vec<Counted> {
    let one = |post: &PostCondition<T>| Counted {
        observation: named(&post.what),
        absent: post.absent,
        occurrences: post.count.occurrences,
        trials: post.count.trials,
    };
    post.iter().map(one).collect()
}

/// Where everything stands: curriculum, goal, what is under way, the generator.
fn standing<'a>(content: &'a Content, names: Names<'a>) -> impl Iterator<Item = Line> + 'a {
    let progress = &content.progress;
    let pools = progress.pools.iter().map(|left| Line::Pool(PoolLine { left: left.clone() }));
    let stages = progress.reports.iter().map(|report| Line::Stage(Box::new(stage(report))));
    let stands = Line::Progress(Box::new(ProgressLine {
        student: progress.student.map(|body| names.body(body)),
        stage: progress.stage as u64,
        begun: progress.begun,
        finished: progress.finished,
        held: progress.held,
        stuck: progress.stuck.clone(),
        trial_open: progress.trial_open,
        trial_actions: progress.trial_actions,
        absent_actions: progress.absent_actions,
        trial_fresh: progress.trial_fresh,
        said: progress.said.clone(),
        quiet_actions: progress.quiet_actions,
        habituating: progress.habituating,
    }));
    let goal = content.pursuit.iter().map(move |pursuit| Line::Goal(Box::new(goal(names, pursuit))));
    let bodies = (0u16..).map(BodyId).zip(&content.pending);
    let pending = bodies.filter_map(move |(body, execution)| {
        let line = pending(names, names.body(body), execution.as_deref()?);
        Some(Line::Pending(Box::new(line)))
    });
    let generator = Line::Generator(GeneratorLine { state: format!("{:016x}", content.random.state()) });
    pools.chain(stages).chain([stands]).chain(goal).chain(pending).chain([generator])
}

fn stage(report: &StageReport) -> StageLine {
    let report = report.clone();
    StageLine {
        name: report.name,
        first_step: report.first_step,
        actions: report.actions,
        concrete_new: report.concrete_new,
        generalised_new: report.generalised_new,
        counter_examples_new: report.counter_examples_new,
        trials: report.trials,
        trials_met: report.trials_met,
        trials_met_first: report.trials_met_first,
        actions_of_trial: report.actions_of_trial,
        generalised_after_trial: report.generalised_after_trial,
        drawn: report.drawn,
        saturated: report.saturated,
        ended: report.ended,
    }
}

fn goal(names: Names<'_>, pursuit: &Pursuit) -> GoalLine {
    let plan = |plan: &PlanRecord| PlanLine {
        after_actions: plan.after_actions,
        because: match plan.because {
            PlanCause::First => BecauseWord::First,
            PlanCause::NotReached => BecauseWord::NotReached,
            PlanCause::NextNotAllowed => BecauseWord::NextNotAllowed,
            PlanCause::NotCarriedOut => BecauseWord::NotCarriedOut,
            PlanCause::Interrupted => BecauseWord::Interrupted,
        },
        chain: plan.chain.iter().map(|one| link(names, one)).collect(),
        probability: plan.probability,
        truncated: plan.truncated,
    };
    GoalLine {
        number: pursuit.number,
        body: names.body(pursuit.body),
        goal: pursuit.goal.iter().map(|pattern| names.pattern(pattern)).collect(),
        actions_max: pursuit.actions_max,
        actions: pursuit.actions,
        plans_made: pursuit.plans_made,
        plans: pursuit.plans.iter().map(plan).collect(),
        ended: pursuit.ended.map(|ending| match ending {
            Ending::Achieved => EndingWord::Achieved,
            Ending::NothingLeadsThere => EndingWord::NothingLeadsThere,
            Ending::ActionsUsedUp => EndingWord::ActionsUsedUp,
            Ending::Constrained => EndingWord::Constrained,
            Ending::Cancelled => EndingWord::Cancelled,
        }),
    }
}

fn pending(names: Names<'_>, body: String, execution: &Execution) -> PendingLine {
    let before = execution.before.observations();
    PendingLine {
        body,
        schema: execution.schema.map(|id| id.0),
        binding: names.binding(&execution.binding),
        carrier: execution.carrier.map(|id| id.0),
        primitive: execution.action.0,
        before: before.iter().map(|one| names.observation(one)).collect(),
        chain: execution.chain.iter().map(|one| link(names, one)).collect(),
        for_goal: execution.for_goal,
    }
}

fn link(names: Names<'_>, link: &ChainLink) -> LinkLine {
    LinkLine {
        schema: link.schema.0,
        binding: names.binding(&link.binding),
        carrier: link.carrier.map(|id| id.0),
    }
}

fn number(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}

/// What numbers are called.
#[derive(Clone, Copy)]
struct Names<'a>(&'a Vocabulary);

impl Names<'_> {
    fn body(self, body: BodyId) -> String {
        self.0.bodies().get(usize::from(body.0)).map(|body| body.name.clone()).unwrap_or_default()
    }

    fn observation(self, observation: &seen::Observation) -> Observation {
        let properties = observation.properties().iter();
        let properties = properties
            .map(|(property, value)| (self.property(*property), self.value(Some(*property), *value)));
        Observation { kind: self.kind(observation.kind()), properties: Named(properties.collect()) }
    }

    fn pattern(self, pattern: &seen::Pattern) -> Observation {
        let terms = pattern.terms().iter().map(|(property, term)| {
            let value = match term {
                Term::Constant(value) => self.value(Some(*property), *value),
                Term::Variable(variable) => Value::Variable(Variable { var: notation::variable(*variable) }),
            };
            (self.property(*property), value)
        });
        Observation { kind: self.kind(pattern.kind()), properties: Named(terms.collect()) }
    }

    fn binding(self, binding: &Substitution) -> Binding {
        let bound = binding.bindings().iter();
        Named(
            bound
                .map(|(variable, value)| (notation::variable(*variable), self.value(None, *value)))
                .collect(),
        )
    }

    fn kind(self, kind: seen::TypeId) -> String {
        self.0.types().get(usize::from(kind.0)).map(|known| known.declared.name.clone()).unwrap_or_default()
    }

    fn property(self, property: seen::PropertyId) -> String {
        self.0.properties().get(usize::from(property.0)).cloned().unwrap_or_default()
    }

    fn value(self, property: Option<seen::PropertyId>, value: seen::Value) -> Value {
        match value {
            seen::Value::Integer(number) => Value::Integer(number),
            seen::Value::Boolean(value) => Value::Boolean(value),
            seen::Value::Symbol(symbol) => {
                let at = usize::try_from(symbol.0).unwrap_or(usize::MAX);
                Value::Symbol(self.0.symbols().get(at).cloned().unwrap_or_default())
            }
            seen::Value::Bin(bin) => {
                let real = match property.and_then(|property| self.0.property_kind(property)) {
                    Some(ValueKind::Real { resolution }) => Some(bin_middle(bin, *resolution)),
                    _ => None,
                };
                Value::Bin(Bin { bin, real: real.filter(|real| real.is_finite()) })
            }
        }
    }
}
