//! The trait that the author of a body implements.

use super::Senses;
use crate::description::{Action, Description};
use crate::outcome::Outcome;
use crate::picture::Picture;

/// A body the learner can live in.
///
/// ```no_run
/// use pschema_protocol::prelude::*;
///
/// /// A coin on a table.
/// struct Coin {
///     description: Description,
///     side: SenseId,
///     heads: bool,
/// }
///
/// impl Coin {
///     fn new() -> Self {
///         let mut description = Description::new("coin", "coin");
///         let side = ObservationType::state("side").property(Property::boolean("heads"));
///         let side = description.observation(side);
///         description.action_with_primitives(ActionType::new("turn"));
///         Self { description, side, heads: true }
///     }
/// }
///
/// impl Body for Coin {
///     fn describe(&self) -> Description {
///         self.description.clone()
///     }
///
///     fn sense(&mut self, frame: &mut Senses) {
///         frame.observe(self.side, [self.heads]);
///     }
///
///     fn act(&mut self, _turn: &Action) -> Outcome {
///         self.heads = !self.heads;
///         Outcome::Done
///     }
/// }
///
/// fn main() -> std::process::ExitCode {
///     run_from_args(Coin::new())
/// }
/// ```
pub trait Body {
    /// The description of this body: what it senses, and what it can do. Asked for once, before the body attaches.
    fn describe(&self) -> Description;

    /// Reports everything that the body senses now, into `frame`. Called once before each decision.
    fn sense(&mut self, frame: &mut Senses);

    /// Carries `action` out, to its end, and says how it went. The action is one that the body declared, with one value for
    /// each parameter, of the declared kind and in the declared range.
    ///
    /// Where life comes in episodes, the last frame of one is reported like any other; the action after it is not carried out, begins the
    /// next and is [`Outcome::EpisodeEnded`], or [`Outcome::EpisodeCut`] if something led on from there.
    fn act(&mut self, action: &Action) -> Outcome;

    /// The picture that the body saw when it last sensed, for people to look at; none if it has no eye, as most bodies. Asked
    /// for only while a tool watches, some 30 times a second at most.
    fn picture(&mut self) -> Option<Picture<'_>> {
        None
    }

    /// Arranges the body's surroundings as a curriculum asks. A body that declared no scene commands never gets one.
    fn arrange(&mut self, command: &Action) -> Outcome {
        tracing::warn!(?command, "this body arranges nothing");
        Outcome::refused("this body arranges nothing")
    }
}

impl<B: Body + ?Sized> Body for Box<B> {
    fn describe(&self) -> Description {
        (**self).describe()
    }

    fn sense(&mut self, frame: &mut Senses) {
        (**self).sense(frame);
    }

    fn act(&mut self, action: &Action) -> Outcome {
        (**self).act(action)
    }

    fn picture(&mut self) -> Option<Picture<'_>> {
        (**self).picture()
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        (**self).arrange(command)
    }
}
