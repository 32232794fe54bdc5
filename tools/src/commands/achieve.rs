//! `pschema achieve PATTERN...`: has the learner pursue a goal, and waits for the end of it.

use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use pschema_inspect::{AchieveOrder, CancelOrder, Pursuit, PursuitQuery, PursuitState};
use pschema_process::{Stop, say};

use crate::args::{General, OrderArgs, WantedArgs};
use crate::failure::Failure;
use crate::learner::Learner;
use crate::output;
use crate::render::{goals, schema};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema achieve 'touch{}'\n  \
    pschema achieve 'finger{field=17}' --actions-max 5 --wait 10\n  \
    pschema achieve --again 'lamp{lit=true}'\n  \
    pschema achieve --most reward --actions 200\n\n\
    It exits with 0 when the goal was achieved, else with 1; for most of something with 0 unless it was given up. Ctrl-C calls the \
    goal off.")]
pub(crate) struct AchieveArgs {
    #[command(flatten)]
    order: OrderArgs,
    #[command(flatten)]
    wanted: WantedArgs,
    /// Actions that it may take
    #[arg(long, visible_alias = "actions", default_value_t = 50, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    actions_max: u32,
    /// Seconds to wait for it before it is called off
    #[arg(long, default_value_t = 60, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    wait: u64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// How often the learner is asked how the goal is doing.
const ASK_EVERY: Duration = Duration::from_millis(50);

pub(crate) fn run(args: AchieveArgs, general: &General) -> Result<(), Failure> {
    let name = args.order.learner(general, "`achieve`")?;
    let stop = Stop::on_signals()?;
    // One goal is pursued at a time, so this takes one of the places of operators at most, however long it waits.
    let mut learner = Learner::connect_as_operator(&name)?;
    let WantedArgs { goal, again, most } = args.wanted;
    let begun = learner.ask(AchieveOrder { goal, again, most, actions_max: args.actions_max })?;
    let goal = AwaitedGoal { number: begun.number, until: Instant::now() + Duration::from_secs(args.wait) };
    let (end, why) = goal.follow(&mut learner, begun, &stop, general.quiet())?;
    // There is always more of which most is wanted: it is over when its actions or its time are, and that is no failure.
    let went_on = matches!(end.state, PursuitState::ActionsUsedUp | PursuitState::Cancelled);
    let is_well = end.achieved || end.came.is_some() && went_on;
    if args.json {
        output::print_json(&end)?;
    } else if is_well {
        output::print(&schema::wrapped(&format!("{}{why}.", goals::ending(&end)), ""))?;
    }
    if is_well { Ok(()) } else { Err(Failure::Failed(goals::ending(&end) + &why)) }
}

/// A goal whose end is waited for.
struct AwaitedGoal {
    number: u64,
    until: Instant,
}

impl AwaitedGoal {
    /// Tells of each plan as it is made. Returns how it ended, and why it was called off if it was from here.
    fn follow(
        &self,
        learner: &mut Learner,
        begun: Pursuit,
        stop: &Stop,
        quiet: bool,
    ) -> Result<(Pursuit, String), Failure> {
        let mut now = begun;
        let mut told = 0;
        let mut why = String::new();
        loop {
            if !quiet {
                tell(&now, &mut told);
            }
            if now.state != PursuitState::Pursued {
                return Ok((now, why));
            }
            if stop.is_raised() {
                now = self.call_off(learner)?;
                " because this command was interrupted".clone_into(&mut why);
            } else if Instant::now() >= self.until {
                now = self.call_off(learner)?;
                " because the time was up: allow more with --wait".clone_into(&mut why);
            } else {
                thread::sleep(ASK_EVERY);
                now = self.current(learner.ask(PursuitQuery {})?)?;
            }
        }
    }

    fn call_off(&self, learner: &mut Learner) -> Result<Pursuit, Failure> {
        self.current(learner.ask(CancelOrder { number: self.number })?)
    }

    /// What the learner says, if it is still about this goal.
    fn current(&self, said: Pursuit) -> Result<Pursuit, Failure> {
        if said.number == self.number {
            return Ok(said);
        }
        let (ours, other) = (self.number, said.number);
        Err(Failure::Failed(format!(
            "goal {ours} is over and goal {other} was taken up before its end was seen"
        )))
    }
}

/// Says what has not been told yet of the plans made.
fn tell(now: &Pursuit, told: &mut u32) {
    let first = now.plans_made.saturating_sub(u32::try_from(now.plans.len()).unwrap_or(u32::MAX));
    let before = std::mem::replace(told, now.plans_made);
    for (_, plan) in (first..).zip(&now.plans).filter(|(number, _)| *number >= before) {
        say(&goals::plan_made(plan));
    }
}
