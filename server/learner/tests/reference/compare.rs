//! Both learners side by side, and the first difference between them told well.

use proptest::test_runner::TestCaseError;
use pschema_learner::effect::Effect;
use pschema_learner::observation::Pattern;
use pschema_learner::probability::Count;
use pschema_learner::progress::{StageCommand, StageEffect};
use pschema_learner::pursuit::PursuitEffect;
use pschema_learner::schema::{Form, PostCondition};
use pschema_learner::{Frame, Learner, Output};

use super::learner::Reference;
use super::plans::{GoalOrder, Setup};
use super::schema::Post;

pub(crate) struct Pair {
    indexed: Learner,
    plain: Reference,
}

fn difference(reason: String) -> TestCaseError {
    TestCaseError::fail(reason)
}

impl Pair {
    pub(crate) fn new(setup: &Setup) -> Result<Self, TestCaseError> {
        let (seed, parameters) = (setup.plan.seed, setup.parameters.clone());
        let indexed = Learner::new(seed, parameters.clone(), setup.curriculum.clone());
        let mut indexed = indexed.map_err(|error| difference(error.to_string()))?;
        let mut plain = Reference::new(seed, parameters, setup.curriculum.clone());
        for declaration in setup.plan.declarations() {
            indexed.declare(declaration.clone()).map_err(|error| difference(error.to_string()))?;
            plain.declare(declaration);
        }
        Ok(Self { indexed, plain })
    }

    pub(crate) fn command(&mut self, at: usize, command: &StageCommand) -> Result<(), TestCaseError> {
        let (indexed, plain) = (self.indexed.stage(command), self.plain.command(command));
        let same = match (&indexed, &plain) {
            (Err(indexed), Err(plain)) => std::mem::discriminant(indexed) == std::mem::discriminant(plain),
            _ => indexed == plain,
        };
        if !same {
            let reason = format!("before frame {at}, {command:?}:\n indexed {indexed:?}\n plain   {plain:?}");
            return Err(difference(reason));
        }
        Ok(())
    }

    /// Has memory full, or gives it room.
    pub(crate) fn full(&mut self, full: bool) {
        for effect in self.indexed.set_full(full) {
            self.plain.memory.apply(&effect);
        }
    }

    /// Takes a goal up, or calls it off.
    pub(crate) fn goal(&mut self, at: usize, order: &GoalOrder) -> Result<(), TestCaseError> {
        let indexed = match order.clone() {
            Some((body, goal, actions_max)) => self.indexed.pursue(body, goal, actions_max),
            None => self.indexed.cancel_goal(),
        };
        let plain = self.plain.order(order.clone());
        if indexed.as_ref().ok() != plain.as_ref() {
            let reason = format!("before frame {at}, {order:?}:\n indexed {indexed:?}\n plain   {plain:?}");
            return Err(difference(reason));
        }
        Ok(())
    }

    /// One step of both. Both must do and change the same.
    pub(crate) fn step(&mut self, at: usize, frame: &Frame) -> Result<Output, TestCaseError> {
        let before = format!("{:?}", self.plain.memory.pending);
        let mut step = self.indexed.step(frame);
        step.effects.iter_mut().for_each(without_wording);
        let (output, effects) = self.plain.step(frame);
        if step.output == output && step.effects == effects {
            return Ok(output);
        }
        let first = step.effects.iter().zip(&effects).take_while(|(a, b)| a == b).count();
        let told = |output: &Output, effects: &[Effect]| {
            let rest: Vec<_> = effects[first..].iter().map(|e| format!("    {e:?}")).collect();
            format!("{output:?}\n{}", rest.join("\n"))
        };
        let same: Vec<_> = effects[..first].iter().map(|e| format!("    {e:?}")).collect();
        let schemas = &self.plain.memory.schemas;
        let schemas: Vec<_> = schemas.iter().map(|s| format!("    {s:?}")).collect();
        Err(difference(format!(
            "frame {at} ({frame:?}), pending {before}:\n  both:\n{}\n  indexed: {}\n  plain: {}\n  schemas \
             (plain):\n{}\n attention {:?}\n attempts {:?}\n standing {:?}\n decision (indexed): {:?}",
            same.join("\n"),
            told(&step.output, &step.effects),
            told(&output, &effects),
            schemas.join("\n"),
            self.plain.memory.attention,
            self.plain.memory.attempts,
            self.plain.memory.standing,
            step.decision,
        )))
    }

    /// Both must have made the same of the effects.
    pub(crate) fn same_memory(&self) -> Result<(), TestCaseError> {
        let content = self.indexed.memory().content();
        let plain = &self.plain.memory;
        let wrong = |what: &str| Err(difference(format!("{what} differs at the end")));
        if content.schemas.len() != plain.schemas.len() {
            return wrong("the number of schemas");
        }
        for (indexed, plain) in content.schemas.iter().zip(&plain.schemas) {
            let (pre, action, post) = match &indexed.form {
                Form::Concrete(concrete) => {
                    let pattern = |id| Pattern::from(content.observation(id));
                    let post = concrete.post.iter().map(|p| posted(p, pattern(p.what)));
                    let pre = concrete.pre.iter().map(|id| pattern(*id)).collect();
                    (pre, Some(concrete.action), post.collect::<Vec<_>>())
                }
                Form::Generalised(generalised) => {
                    let lists = [&generalised.examples, &generalised.counter_examples];
                    if lists != [&plain.examples, &plain.counter_examples]
                        || generalised.retired != plain.retired
                        || *generalised.target != *plain.target
                    {
                        return wrong(&format!("{indexed:?} and {plain:?}"));
                    }
                    let post = generalised.post.iter().map(|p| posted(p, p.what.clone()));
                    (generalised.pre.to_vec(), None, post.collect())
                }
            };
            let associations: Vec<_> = indexed
                .associations
                .iter()
                .map(|a| (content.observation(a.observation).clone(), a.count, a.since_step))
                .collect();
            if (pre, action, post) != (plain.pre.clone(), plain.action, plain.post.clone())
                || associations != plain.associations
                || indexed.executions != plain.executions
            {
                return wrong(&format!("{indexed:?} and {plain:?}"));
            }
        }
        for (observation, n) in &plain.attention {
            if self.indexed.memory().attention(observation) != *n {
                return wrong(&format!("N({observation:?})"));
            }
        }
        let attempts: Vec<Count> = content.attempts.iter().copied().collect();
        if attempts != plain.attempts || content.random != plain.random {
            return wrong("reliability or the generator");
        }
        Ok(())
    }
}

fn posted<T>(post: &PostCondition<T>, what: Pattern) -> Post {
    Post { what, absent: post.absent, count: post.count }
}

/// Why the curriculum can't go on is told in prose, which is nobody's to repeat; and whether a search came to its
/// budget is the searcher's own affair.
fn without_wording(effect: &mut Effect) {
    if let Effect::Stage(StageEffect::Stuck(reason)) = effect {
        reason.clear();
    }
    if let Effect::Pursuit(PursuitEffect::Planned(plan)) = effect {
        plan.truncated = false;
    }
}
