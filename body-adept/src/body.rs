//! The Adept arm as a body: the same senses, actions and scene commands as the simulated one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_arm::{ArmIds, JointPositions, Percept, Side, field_marks, object_symbol};
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Description, Value};
use pschema_protocol::picture::{FieldMark, Picture};
use pschema_vision::eye::{Eye, Sighting};
use pschema_vision::image::RgbImage;

use crate::arm::{Arm, Phase};
use crate::config::ArmSetup;
use crate::operator::{Operator, OperatorError, Wish};
use crate::sight::{FrameSource, SightError};

/// How long an action waits for a person before it is refused.
const PERSON_WAIT: Duration = Duration::from_secs(1);
/// How often a person is asked again about the same thing.
const ASK_EVERY: Duration = Duration::from_secs(30);
/// Pause between two tries to sense.
const SENSE_PAUSE: Duration = Duration::from_millis(50);
/// Shortest time between two reports of trouble with the senses.
const TELL_EVERY: Duration = Duration::from_secs(5);

/// An arm with its camera, its eye and the person beside it.
pub struct AdeptBody {
    description: Description,
    ids: ArmIds,
    setup: Arc<ArmSetup>,
    arm: Arm,
    source: Box<dyn FrameSource>,
    eye: Eye,
    operator: Operator,
    stop: Arc<AtomicBool>,
    last: Percept,
    /// The last picture, and the places of the visual fields in it, for people who look at it.
    seen: Option<RgbImage>,
    /// How often the arm had moved before the last picture.
    seen_after: u64,
    /// When it was last told that pictures do not change.
    frozen_told_at: Option<Instant>,
    marks: Vec<FieldMark>,
    asked_at: Option<Instant>,
    told_at: Option<Instant>,
}

/// The place where the arm is expected while a picture is taken.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sight {
    /// Where the camera sees it.
    InView,
    /// Anywhere: a calibration goes to points that the camera does not see, and an emulated one then gives equal pictures.
    Anywhere,
}

impl AdeptBody {
    /// A body made of these parts. `stop` ends all its waits.
    pub fn new(
        name: &str,
        arm: Arm,
        source: Box<dyn FrameSource>,
        operator: Operator,
        stop: Arc<AtomicBool>,
    ) -> Self {
        let setup = arm.setup().clone();
        let (description, ids) = setup.declaration(name).declare();
        Self {
            description,
            ids,
            marks: field_marks(&setup.fields),
            eye: setup.eye.clone(),
            setup,
            arm,
            source,
            operator,
            stop,
            last: Percept::default(),
            seen: None,
            seen_after: 0,
            frozen_told_at: None,
            asked_at: None,
            told_at: None,
        }
    }

    /// The arm.
    pub fn arm(&mut self) -> &mut Arm {
        &mut self.arm
    }

    /// The person beside the arm.
    pub(crate) fn operator(&self) -> &Operator {
        &self.operator
    }

    /// Takes a picture. Returns the position of the finger in it, in pixels, if it is in sight: it may be anywhere.
    ///
    /// # Errors
    /// When there is no picture.
    pub fn find_finger(&mut self) -> Result<Option<(f64, f64)>, SightError> {
        Ok(self.look(Sight::Anywhere)?.finger.map(|blob| blob.centre_px))
    }

    /// Takes a picture and looks for blobs in it.
    fn look(&mut self, sight: Sight) -> Result<Sighting, SightError> {
        let image = self.source.frame()?;
        let seen = self.eye.look(&image);
        let moved = self.arm.displacements() > self.seen_after;
        let is_repeated = moved && self.seen.as_ref() == Some(&image);
        if is_repeated && (sight == Sight::InView || seen.finger.is_some()) {
            self.tell_of_frozen_pictures();
        }
        self.seen_after = self.arm.displacements();
        self.seen = Some(image);
        Ok(seen)
    }

    /// A camera's noise alone makes each picture another, so that one which is repeated is an old one. It is told and not refused:
    /// an emulated camera has no noise, and the arm may be out of its sight.
    fn tell_of_frozen_pictures(&mut self) {
        if self.frozen_told_at.is_none_or(|told| told.elapsed() > TELL_EVERY) {
            tracing::warn!(
                "the arm moved, and the picture is the same to the last pixel: see whether the camera is frozen, or cannot \
                 see the arm"
            );
            self.frozen_told_at = Some(Instant::now());
        }
    }

    fn stopping(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Reports trouble with the senses, not too often.
    fn tell(&mut self, trouble: &dyn std::fmt::Display) {
        if self.told_at.is_none_or(|told| told.elapsed() > TELL_EVERY) {
            tracing::warn!(%trouble, "cannot sense; waiting");
            self.told_at = Some(Instant::now());
        }
    }

    /// Reads the touch inputs and looks at a picture.
    fn try_sense(&mut self) -> Result<Percept, Box<dyn std::error::Error>> {
        let signals = self.arm.signals()?;
        let seen = self.look(Sight::InView)?;
        Ok(sensed(&self.setup, signals, &seen))
    }

    /// Whether the arm may be moved. If not, asks the person who can change that, and waits a moment.
    fn attended(&mut self) -> bool {
        if *self.arm.phase() == Phase::Active {
            return true;
        }
        if let Err(fault) = self.arm.ensure_connected() {
            tracing::debug!(%fault, "not connected");
            self.rest(PERSON_WAIT);
            return *self.arm.phase() == Phase::Active;
        }
        let phase = self.arm.phase().clone();
        let wish = match &phase {
            Phase::Active => return true,
            Phase::Latched(why) => Wish::Reset(why),
            Phase::Inactive | Phase::Unconnected => Wish::Enable("the arm is not enabled"),
        };
        if self.asked_at.is_some_and(|asked| asked.elapsed() < ASK_EVERY) || !self.operator.is_there() {
            self.rest(PERSON_WAIT);
            return false;
        }
        match self.operator.ask(&wish, ASK_EVERY, &self.stop) {
            Ok(()) => match self.arm.enable() {
                Ok(()) => return true,
                Err(fault) => tracing::error!(%fault, "not enabled"),
            },
            Err(OperatorError::Stopped) => {}
            Err(error) => tracing::warn!(%error, "the arm stays as it is"),
        }
        self.asked_at = Some(Instant::now());
        false
    }

    /// Waits, unless the body is to end.
    fn rest(&self, time: Duration) {
        let end = Instant::now() + time;
        while !self.stopping() && Instant::now() < end {
            std::thread::sleep(SENSE_PAUSE.min(time));
        }
    }

    fn place(&mut self, object: u32, position: i64) -> Outcome {
        let setup = self.setup.clone();
        let place =
            usize::try_from(position).ok().and_then(|at| Some((at, setup.file.places.at_mm.get(at)?)));
        let (Some(object), Some((position, [x, y]))) = (setup.file.objects.names.get(object as usize), place)
        else {
            return Outcome::refused("there is no such object or position");
        };
        self.arrange_by_hand(&Wish::Place { object, position, at_mm: (x.get(), y.get()) })
    }

    fn remove(&mut self, object: u32) -> Outcome {
        let setup = self.setup.clone();
        let Some(object) = setup.file.objects.names.get(object as usize) else {
            return Outcome::refused("there is no such object");
        };
        self.arrange_by_hand(&Wish::Remove { object })
    }

    fn park(&mut self) -> Outcome {
        if self.attended() { self.arm.park() } else { self.arm.refuse() }
    }

    /// Parks the arm, and has a person arrange the objects.
    fn arrange_by_hand(&mut self, wish: &Wish<'_>) -> Outcome {
        let parked = self.park();
        if parked != Outcome::Done {
            return parked;
        }
        match self.operator.arrange(wish, &self.stop) {
            Ok(()) => Outcome::Done,
            Err(error) => {
                // The person's hands may still be in the work space.
                self.arm.stand_down();
                tracing::warn!(%error, ?wish, "not arranged; the arm moves again once a person enables it");
                Outcome::refused(error)
            }
        }
    }
}

impl Body for AdeptBody {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    /// A body that cannot sense does not report: it waits until it can, or until it is to end.
    fn sense(&mut self, frame: &mut Senses) {
        while !self.stopping() {
            match self.try_sense() {
                Ok(sensed) => {
                    self.last = sensed;
                    break;
                }
                Err(trouble) => {
                    self.tell(&trouble);
                    self.rest(SENSE_PAUSE);
                }
            }
        }
        self.last.report(self.ids, frame);
    }

    fn picture(&mut self) -> Option<Picture<'_>> {
        let seen = self.seen.as_ref()?;
        Some(Picture {
            width_px: u32::try_from(seen.width_px()).ok()?,
            height_px: u32::try_from(seen.height_px()).ok()?,
            rgb: seen.as_rgb_bytes(),
            fields: &self.marks,
        })
    }

    fn act(&mut self, action: &Action) -> Outcome {
        self.arm.ordered();
        match action.parameters[..] {
            [Value::Real(j1), Value::Real(j2)] if action.id == self.ids.move_to => {
                if self.attended() {
                    self.arm.go(JointPositions { j1, j2 })
                } else {
                    self.arm.refuse()
                }
            }
            _ => {
                tracing::warn!(?action, "refused: not an action this body declared");
                Outcome::refused("not an action this body declared")
            }
        }
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        self.arm.ordered();
        match command.parameters[..] {
            [Value::Symbol(object), Value::Integer(position)] if command.id == self.ids.place => {
                self.place(object, position)
            }
            [Value::Symbol(object)] if command.id == self.ids.remove => self.remove(object),
            [] if command.id == self.ids.park => self.park(),
            _ => {
                tracing::warn!(?command, "refused: not a scene command this body declared");
                Outcome::refused("not a scene command this body declared")
            }
        }
    }
}

impl Drop for AdeptBody {
    fn drop(&mut self) {
        self.arm.finish();
    }
}

/// The percept that follows from touch inputs and a picture.
fn sensed(setup: &ArmSetup, signals: u8, seen: &Sighting) -> Percept {
    let touch = &setup.file.touch;
    let signals = if touch.inverted { !signals & 0b1111 } else { signals & 0b1111 };
    let felt =
        |side: &Side| touch.sides.iter().enumerate().any(|(bit, of)| of == side && signals & (1 << bit) != 0);
    let field = |(u, v): (f64, f64)| setup.fields.field_at(u, v);
    let object = |(colour, blob): &(usize, pschema_vision::blobs::Blob)| {
        Some((object_symbol(*colour, setup.finger_colour())?, field(blob.centre_px)?))
    };
    Percept {
        finger: seen.finger.as_ref().and_then(|blob| field(blob.centre_px)),
        objects: seen.objects.iter().filter_map(object).collect(),
        touching: signals != 0,
        sides: Side::ALL.into_iter().filter(felt).collect(),
    }
}
