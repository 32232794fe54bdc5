//! The places of the fields in the cameras of the bodies. They are read off the first picture of each body; after that no
//! more pictures are asked for.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use pschema_inspect::{BodyState, BodyStatus};
use pschema_protocol::domain::Place;
use pschema_protocol::transport::pictures::PictureWatch;

use super::state::News;

/// The time after which a body without a picture is thought to have no camera. An arm may take its time for a move.
const PATIENCE: Duration = Duration::from_secs(60);
/// The time after which it is tried again when pictures can't be watched.
const RETRY_EVERY: Duration = Duration::from_secs(5);

/// The knowledge of a session's camera.
#[derive(Clone, Copy, Debug)]
enum Camera {
    /// No picture of it has come yet.
    Unseen {
        since: Instant,
    },
    Seen,
}

/// Looks for pictures while there are bodies whose camera is not known.
pub(super) struct Eyes {
    place: Place,
    watch: Option<PictureWatch>,
    cameras: BTreeMap<u64, Camera>,
    retry_at: Option<Instant>,
}

impl Eyes {
    pub(super) fn new(place: Place) -> Self {
        Self { place, watch: None, cameras: BTreeMap::new(), retry_at: None }
    }

    /// Whether the first picture of one of the bodies may still come.
    pub(super) fn is_looking(&self) -> bool {
        let unseen =
            |camera: &Camera| matches!(camera, Camera::Unseen { since } if since.elapsed() < PATIENCE);
        self.cameras.values().any(unseen)
    }

    /// Looks for a picture from one of `bodies`.
    pub(super) fn look(&mut self, bodies: &[BodyStatus]) -> Option<News> {
        let is_attached =
            |id: &u64| bodies.iter().any(|body| body.id == *id && body.state == BodyState::Attached);
        self.cameras.retain(|id, _| is_attached(id));
        for body in bodies.iter().filter(|body| body.state == BodyState::Attached) {
            self.cameras.entry(body.id).or_insert_with(|| Camera::Unseen { since: Instant::now() });
        }
        if !self.is_looking() {
            self.watch = None;
            return None;
        }
        self.try_look().unwrap_or_else(|problem| {
            self.watch = None;
            self.retry_at = Some(Instant::now() + RETRY_EVERY);
            Some(News::Blind(problem))
        })
    }

    fn try_look(&mut self) -> Result<Option<News>, String> {
        if self.watch.is_none() {
            if self.retry_at.is_some_and(|at| Instant::now() < at) {
                return Ok(None);
            }
            self.watch = Some(PictureWatch::open(&self.place).map_err(|error| error.to_string())?);
        }
        let Some(watch) = &self.watch else { return Ok(None) };
        let Some(picture) = watch.newest().map_err(|error| error.to_string())? else { return Ok(None) };
        // A body may have attached after the bodies were listed; its next picture is as good.
        let Some(camera) = self.cameras.get_mut(&picture.session) else { return Ok(None) };
        *camera = Camera::Seen;
        Ok(Some(News::Fields { session: picture.session, fields: picture.fields }))
    }
}
