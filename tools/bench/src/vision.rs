//! How long it takes from a scene to what is seen in it: the picture rendered, its pixels told apart by colour, blobs found;
//! against copying such a picture once, and against looking at all of it when only a part has changed.

use std::hint::black_box;
use std::time::Instant;

use pschema_protocol::body::Body;
use pschema_sim::body::SimBody;
use pschema_tools::kit::{Columns, Failure, show, wrapped};
use serde::Serialize;

use crate::scenes::{Scenes, ScenesArgs};
use crate::times::Times;

/// What the product promises of a frame at the paper's 780x580 pixels, in milliseconds.
const FRAME_MS_WANTED: f64 = 4.0;
/// Actions after which the blocks are put elsewhere.
const ACTIONS_A_SCENE: u32 = 10;

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct VisionMeasurement {
    world: String,
    seed: u64,
    width_px: usize,
    height_px: usize,
    blocks: usize,
    frames: usize,
    /// Blobs seen, on the average: an empty table is seen quickly.
    blobs_mean: f64,
    /// Rendered and looked at, as the body does.
    frame_ms_p50: f64,
    frame_ms_p99: f64,
    frame_ms_wanted: f64,
    within: bool,
    render_ms_p50: f64,
    render_ms_p99: f64,
    look_ms_p50: f64,
    look_ms_p99: f64,
    /// All of the same picture looked at, as of a camera that does not say what has changed.
    look_at_all_ms_p50: f64,
    look_at_all_ms_p99: f64,
    /// The picture copied once.
    copy_ms_p50: f64,
    copy_ms_p99: f64,
    /// To the copy: of the frame, and of looking at all of it.
    ratio_p50: f64,
    ratio_p99: f64,
    ratio_look_at_all_p50: f64,
}

/// Times of each picture.
#[derive(Default)]
struct PictureTimes {
    frame: Times,
    render: Times,
    look: Times,
    all: Times,
    copy: Times,
    blobs: usize,
}

pub(crate) fn run(args: &ScenesArgs, quiet: bool) -> Result<(), Failure> {
    let mut scenes = Scenes::new(args)?;
    let mut times = PictureTimes::default();
    scenes.run(ACTIONS_A_SCENE, quiet, |body, action, _| {
        let outcome = body.act(action);
        times.picture(body)?;
        Ok(outcome)
    })?;
    show(args.json, &times.measurement(args, &scenes.body), text)
}

impl PictureTimes {
    /// One picture of what is there now.
    fn picture(&mut self, body: &mut SimBody) -> Result<(), Failure> {
        let began = Instant::now();
        body.render();
        let rendered = began.elapsed();
        let seen = body.look_at_picture();
        let looked = began.elapsed();
        self.render.push(rendered);
        self.look.push(looked - rendered);
        self.frame.push(looked);
        self.blobs += seen.objects.len() + usize::from(seen.finger.is_some());
        let began = Instant::now();
        let all = body.look_at_all();
        self.all.push(began.elapsed());
        if all != seen {
            return Err(Failure::Failed("what is seen depends on how it is looked at".to_owned()));
        }
        let began = Instant::now();
        let copy = black_box(body.image()).clone();
        self.copy.push(began.elapsed());
        drop(black_box(copy));
        Ok(())
    }

    fn measurement(&self, args: &ScenesArgs, body: &SimBody) -> VisionMeasurement {
        let p50 = |times: &Times| times.p50() / 1e3;
        let p99 = |times: &Times| times.p99() / 1e3;
        VisionMeasurement {
            world: args.world.clone(),
            seed: args.seed,
            width_px: body.image().width_px(),
            height_px: body.image().height_px(),
            blocks: body.world().block_count(),
            frames: self.frame.len(),
            blobs_mean: self.blobs as f64 / self.frame.len().max(1) as f64,
            frame_ms_p50: p50(&self.frame),
            frame_ms_p99: p99(&self.frame),
            frame_ms_wanted: FRAME_MS_WANTED,
            within: p50(&self.frame) <= FRAME_MS_WANTED,
            render_ms_p50: p50(&self.render),
            render_ms_p99: p99(&self.render),
            look_ms_p50: p50(&self.look),
            look_ms_p99: p99(&self.look),
            look_at_all_ms_p50: p50(&self.all),
            look_at_all_ms_p99: p99(&self.all),
            copy_ms_p50: p50(&self.copy),
            copy_ms_p99: p99(&self.copy),
            ratio_p50: p50(&self.frame) / p50(&self.copy),
            ratio_p99: p99(&self.frame) / p99(&self.copy),
            ratio_look_at_all_p50: p50(&self.all) / p50(&self.copy),
        }
    }
}

fn text(f: &VisionMeasurement) -> String {
    let mut table = Columns::new(&["", "p50", "p99"]).figures(&[1, 2]);
    for (name, p50, p99) in [
        ("a frame", f.frame_ms_p50, f.frame_ms_p99),
        ("  rendered", f.render_ms_p50, f.render_ms_p99),
        ("  looked at where it changed", f.look_ms_p50, f.look_ms_p99),
        ("all of it looked at", f.look_at_all_ms_p50, f.look_at_all_ms_p99),
        ("copied once", f.copy_ms_p50, f.copy_ms_p99),
    ] {
        table.row([name.to_owned(), format!("{p50:.3} ms"), format!("{p99:.3} ms")]);
    }
    let told = format!(
        "{} pictures of {}x{} pixels in world {}, {} blocks, {:.1} blobs each, seed {}. A frame takes {:.1} times what \
         copying it does (99th percentiles {:.1}), all of it looked at {:.1} times. Wanted: a frame within {} ms.",
        f.frames,
        f.width_px,
        f.height_px,
        f.world,
        f.blocks,
        f.blobs_mean,
        f.seed,
        f.ratio_p50,
        f.ratio_p99,
        f.ratio_look_at_all_p50,
        f.frame_ms_wanted
    );
    format!("{}\n{}", table.text(&[0]), wrapped(&told, ""))
}
