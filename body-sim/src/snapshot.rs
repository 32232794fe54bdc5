//! The camera's picture, with the visual fields and the recognised blobs drawn in.

use std::collections::BTreeSet;
use std::io::{BufWriter, Write};

use pschema_process::{OutputError, OutputFile};
use pschema_protocol::body::{Body, Outcome};
use pschema_protocol::description::{Action, Value};
use pschema_vision::blobs::Blob;
use pschema_vision::image::RgbImage;
use thiserror::Error;

use crate::body::SimBody;

/// The camera's picture is enlarged this much, so that lines drawn in stay fine.
const ZOOM: usize = 2;
const REACHABLE_RGB: [f64; 3] = [30.0, 110.0, 80.0];
const POINTING_RGB: [f64; 3] = [150.0, 80.0, 20.0];
const UNREACHED_RGB: [f64; 3] = [120.0, 120.0, 125.0];
const SEEN_RGB: [f64; 3] = [20.0, 20.0, 24.0];
const LIT_RGB: [f64; 3] = [255.0, 255.0, 255.0];

/// Why there is no picture.
#[derive(Debug, Error)]
pub enum SnapshotError {
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// The world has too few places or postures for a scene.
    #[error("cannot arrange the scene to be shown: {0}")]
    Scene(String),
}

/// Arranges a scene worth seeing - a block just touched, others waiting, one beyond reach - and writes it.
///
/// # Errors
/// When the scene cannot be arranged or the file not written.
pub fn snapshot(body: &mut SimBody, file: OutputFile) -> Result<(), SnapshotError> {
    arrange(body)?;
    write(body, file)
}

/// Writes the camera's picture of this moment, with the fields drawn in.
///
/// # Errors
/// When the file cannot be written.
pub fn write(body: &mut SimBody, file: OutputFile) -> Result<(), SnapshotError> {
    let (image, seen) = body.look();
    let mut canvas = Canvas::enlarged(image);
    let blobs: Vec<&Blob> = seen.finger.iter().chain(seen.objects.iter().map(|(_, blob)| blob)).collect();
    draw_fields(body, &blobs, &mut canvas);
    blobs.iter().for_each(|blob| draw_blob(blob, &mut canvas));
    let failed = file.refused();
    let mut buffered = BufWriter::new(file);
    canvas.encode(&mut buffered).map_err(|error| {
        failed(match error {
            png::EncodingError::IoError(error) => error,
            error => error.into(),
        })
    })?;
    let file = buffered.into_inner().map_err(|error| failed(error.into_error()))?;
    Ok(file.finish()?)
}

/// The first block in the middle of the picture and touched, the last beyond reach, others in between.
fn arrange(body: &mut SimBody) -> Result<(), SnapshotError> {
    let places = body.workspace().places.clone();
    let within = places.iter().filter(|place| place.within_reach).count();
    let middle = middle_place(body).ok_or_else(|| SnapshotError::Scene("no place is within reach".into()))?;
    let objects = body.world().block_count();
    for object in 0..objects {
        let position = match object {
            0 => middle,
            last if last + 1 == objects && within < places.len() => (within + places.len()) / 2,
            other => within * other / (objects + 1) * 2 % within,
        };
        let place = Action::new(body.ids().place, (Value::symbol(object), position as i64));
        expect_done(body.arrange(&place), "placing a block")?;
    }
    let taught = places.get(middle).and_then(|place| body.workspace().taught_for(place.field)).copied();
    let taught = taught.ok_or_else(|| SnapshotError::Scene("no posture is taught for a place".into()))?;
    let reach = Action::new(body.ids().move_to, [taught.joints.j1, taught.joints.j2]);
    expect_done(body.act(&reach), "reaching for a block")
}

/// The place within reach whose field is nearest the middle of the picture.
fn middle_place(body: &SimBody) -> Option<usize> {
    let workspace = body.workspace();
    let setup = workspace.camera.setup();
    let off = |field: usize| {
        let (u, v) = workspace.fields.centres_px()[field];
        let (du, dv) = (u - setup.width_px as f64 / 2.0, v - setup.height_px as f64 / 2.0);
        du * du + dv * dv
    };
    let within = workspace.places.iter().enumerate().filter(|(_, place)| place.within_reach);
    within.min_by(|(_, a), (_, b)| off(a.field).total_cmp(&off(b.field))).map(|(position, _)| position)
}

fn expect_done(outcome: Outcome, what: &str) -> Result<(), SnapshotError> {
    match outcome {
        Outcome::Done => Ok(()),
        other => Err(SnapshotError::Scene(format!("{what} ended as {other:?}"))),
    }
}

/// Draws all fields, each in the colour that says whether the arm touches, points or does not reach there, and rings
/// those with a blob in them.
fn draw_fields(body: &SimBody, blobs: &[&Blob], canvas: &mut Canvas) {
    let workspace = body.workspace();
    let zoom = ZOOM as f64;
    let radius = workspace.fields.radius_px() * zoom;
    let lit = |blob: &&Blob| workspace.fields.field_at(blob.centre_px.0, blob.centre_px.1);
    for field in blobs.iter().filter_map(lit).collect::<BTreeSet<_>>() {
        let (u, v) = workspace.fields.centres_px()[field];
        for inset in [1.5, 2.5, 3.5] {
            canvas.circle(u * zoom, v * zoom, radius - inset, LIT_RGB, 0.9);
        }
    }
    for (field, &(u, v)) in workspace.fields.centres_px().iter().enumerate() {
        let (rgb, opacity) = match workspace.taught_for(field) {
            Some(taught) if taught.flat => (REACHABLE_RGB, 0.55),
            Some(_) => (POINTING_RGB, 0.6),
            None => (UNREACHED_RGB, 0.25),
        };
        canvas.circle(u * zoom, v * zoom, radius, rgb, opacity);
    }
}

fn draw_blob(blob: &Blob, canvas: &mut Canvas) {
    let zoom = ZOOM as f64;
    let margin = 2.0;
    let from = (f64::from(blob.from_px.0) * zoom - margin, f64::from(blob.from_px.1) * zoom - margin);
    let to = (f64::from(blob.to_px.0 + 1) * zoom + margin, f64::from(blob.to_px.1 + 1) * zoom + margin);
    canvas.frame(from, to, SEEN_RGB);
    let (u, v) = (blob.centre_px.0 * zoom, blob.centre_px.1 * zoom);
    canvas.bar((u - 5.0, v - 0.75), (u + 5.0, v + 0.75), [255.0; 3]);
    canvas.bar((u - 0.75, v - 5.0), (u + 0.75, v + 5.0), [255.0; 3]);
}

/// A picture to draw on.
struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Canvas {
    fn enlarged(image: &RgbImage) -> Self {
        let (width, height) = (image.width_px() * ZOOM, image.height_px() * ZOOM);
        let source = |at: usize| image.pixels()[(at / width / ZOOM) * image.width_px() + (at % width) / ZOOM];
        Self { width, height, pixels: (0..width * height).map(source).collect() }
    }

    fn blend(&mut self, column: usize, row: usize, rgb: [f64; 3], opacity: f64) {
        let pixel = &mut self.pixels[row * self.width + column];
        for (channel, paint) in pixel.iter_mut().zip(rgb) {
            *channel = (f64::from(*channel) * (1.0 - opacity) + paint * opacity).round() as u8;
        }
    }

    /// Columns and rows from one corner to the other, as far as they are on the canvas.
    fn area(&self, from: (f64, f64), to: (f64, f64)) -> impl Iterator<Item = (usize, usize)> + use<> {
        let clip = |x: f64, side: usize| x.clamp(0.0, side as f64) as usize;
        let columns = clip(from.0, self.width)..clip(to.0.ceil(), self.width);
        let rows = clip(from.1, self.height)..clip(to.1.ceil(), self.height);
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
    }

    /// A circle's line, one and a half pixels wide with soft edges.
    fn circle(&mut self, u: f64, v: f64, radius: f64, rgb: [f64; 3], opacity: f64) {
        let reach = radius + 2.0;
        for (column, row) in self.area((u - reach, v - reach), (u + reach, v + reach)) {
            let (du, dv) = (column as f64 + 0.5 - u, row as f64 + 0.5 - v);
            let off = ((du * du + dv * dv).sqrt() - radius).abs();
            let cover = (1.25 - off).clamp(0.0, 1.0);
            if cover > 0.0 {
                self.blend(column, row, rgb, opacity * cover);
            }
        }
    }

    fn bar(&mut self, from: (f64, f64), to: (f64, f64), rgb: [f64; 3]) {
        for (column, row) in self.area(from, to) {
            self.blend(column, row, rgb, 1.0);
        }
    }

    fn frame(&mut self, from: (f64, f64), to: (f64, f64), rgb: [f64; 3]) {
        let line = 1.0;
        self.bar(from, (to.0, from.1 + line), rgb);
        self.bar((from.0, to.1 - line), to, rgb);
        self.bar(from, (from.0 + line, to.1), rgb);
        self.bar((to.0 - line, from.1), to, rgb);
    }

    fn encode(&self, to: impl Write) -> Result<(), png::EncodingError> {
        let side = |pixels: usize| u32::try_from(pixels).map_err(|_| png::EncodingError::LimitsExceeded);
        let mut encoder = png::Encoder::new(to, side(self.width)?, side(self.height)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()
    }
}
