//! A simulated body that acts in one scene after another, for what is measured on it.

use clap::Args;
use pschema_learner::random::Random;
use pschema_process::Stop;
use pschema_protocol::body::{Body, Outcome};
use pschema_protocol::description::{Action, Value};
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;
use pschema_tools::kit::{Bar, Failure};

/// The scenes to measure in.
#[derive(Debug, Args)]
pub(crate) struct ScenesArgs {
    /// The world that the body lives in: `wide`, `narrow`, `block-and-ball`, or a world file
    #[arg(long, value_name = "NAME|FILE", default_value = "wide")]
    pub(crate) world: String,
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// How many actions, each measured
    #[arg(long, default_value_t = 1_000, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=1_000_000))]
    pub(crate) rounds: u32,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// The body, and the lots that decide what it does and where the blocks lie.
pub(crate) struct Scenes<'a> {
    args: &'a ScenesArgs,
    pub(crate) body: SimBody,
    random: Random,
    repertoire: Vec<Action>,
}

impl<'a> Scenes<'a> {
    pub(crate) fn new(args: &'a ScenesArgs) -> Result<Self, Failure> {
        let file = WorldFile::load(&args.world).map_err(Failure::of)?;
        let body = SimBody::new("arm", file, &args.world, args.seed, false).map_err(Failure::of)?;
        let repertoire = body.describe().repertoire;
        if repertoire.is_empty() {
            return Err(Failure::Failed(format!("world {} has no repertoire", args.world)));
        }
        Ok(Self { args, body, random: Random::from_seed(args.seed), repertoire })
    }

    /// One round after another: `act` gets the body, an action of its repertoire, and whether the blocks were put elsewhere
    /// just before, as they are every `actions_a_scene` rounds.
    pub(crate) fn run(
        &mut self,
        actions_a_scene: u32,
        quiet: bool,
        mut act: impl FnMut(&mut SimBody, &Action, bool) -> Result<Outcome, Failure>,
    ) -> Result<(), Failure> {
        let stop = Stop::on_signals()?;
        let bar = Bar::count(quiet);
        for round in 0..self.args.rounds {
            stop.check()?;
            let new_scene = round.is_multiple_of(actions_a_scene);
            if new_scene {
                self.put_blocks();
            }
            let action = &self.repertoire[self.random.below(self.repertoire.len())];
            let outcome = act(&mut self.body, action, new_scene)?;
            if outcome != Outcome::Done {
                return Err(Failure::Failed(format!("an action of the repertoire ended as {outcome:?}")));
            }
            bar.show(u64::from(round), u64::from(self.args.rounds), "actions".to_owned());
        }
        Ok(())
    }

    /// Puts every block somewhere, each at a place that is free.
    fn put_blocks(&mut self) {
        /// Tries for each block: the table has far more places than there are blocks.
        const TRIES: usize = 20;
        let places = self.body.workspace().places.len();
        if places == 0 {
            return;
        }
        for object in 0..self.body.world().block_count() {
            for _ in 0..TRIES {
                let Ok(place) = i64::try_from(self.random.below(places)) else { continue };
                let put = Action::new(self.body.ids().place, (Value::symbol(object), place));
                if self.body.arrange(&put) == Outcome::Done {
                    break;
                }
            }
        }
    }
}
