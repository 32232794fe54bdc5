//! What a page costs the learner, measured by hand on a machine that has nothing else to do:
//! `PSCHEMA_MEASURE_VIEW=ROUNDS cargo test --release -p pschema-tools --test view what_a_page_costs -- --nocapture`.

use std::time::{Duration, Instant};

use crate::browser::Browser;
use crate::house::{House, Process};

/// How long each measurement takes.
const EACH: Duration = Duration::from_secs(8);
/// How long things settle before each: browsers start slowly.
const BEFORE: Duration = Duration::from_secs(2);

/// A learner at full speed, over a while.
#[derive(Clone, Copy, Default)]
struct Speed {
    steps_per_s: f64,
    /// Processor time of daemon and body together: also on a machine that has other things to do.
    cpu_us_per_step: f64,
}

impl Speed {
    fn of(house: &House, processes: [&Process; 2]) -> Self {
        let step = || house.json(&["status"]).unwrap()["step"].as_f64().unwrap();
        let cpu_s = || processes.iter().map(|process| process.cpu_s()).sum::<f64>();
        std::thread::sleep(BEFORE);
        let (begun, first, cpu) = (Instant::now(), step(), cpu_s());
        std::thread::sleep(EACH);
        let steps = step() - first;
        let wall_s = begun.elapsed().as_secs_f64();
        Self { steps_per_s: steps / wall_s, cpu_us_per_step: (cpu_s() - cpu) / steps * 1e6 }
    }

    fn mean(of: &[Self]) -> Self {
        let count = f64::from(u32::try_from(of.len()).unwrap());
        let mean = |field: fn(&Self) -> f64| of.iter().map(field).sum::<f64>() / count;
        Self { steps_per_s: mean(|one| one.steps_per_s), cpu_us_per_step: mean(|one| one.cpu_us_per_step) }
    }
}

/// What a page changed.
fn told(alone: Speed, watched: Speed) -> String {
    let more = |with: f64, without: f64| (with / without - 1.0) * 100.0;
    format!(
        "{:.0} steps/s without, {:.0} with a page ({:+.1} %); {:.0} and {:.0} us of processor a step ({:+.1} %)",
        alone.steps_per_s,
        watched.steps_per_s,
        more(watched.steps_per_s, alone.steps_per_s),
        alone.cpu_us_per_step,
        watched.cpu_us_per_step,
        more(watched.cpu_us_per_step, alone.cpu_us_per_step)
    )
}

#[test]
fn what_a_page_costs() {
    let rounds: u32 =
        std::env::var("PSCHEMA_MEASURE_VIEW").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(0);
    if rounds == 0 {
        println!("skipped: PSCHEMA_MEASURE_VIEW says no number of rounds");
        return;
    }
    let mut browser = Browser::launch().expect("a browser");
    let house = House::new();
    let daemon = house.start(&["server", "--seed", "7"]);
    let body = house.start(&["sim", "--seed", "7"]);
    let (_view, at) = house.view(&[]);
    house.until(|status| status["step"].as_u64() > Some(500));
    let frames = "Number(document.documentElement.dataset.frames ?? 0)";
    let (mut without, mut with) = (Vec::new(), Vec::new());
    for round in 1..=rounds {
        browser.go("about:blank");
        let alone = Speed::of(&house, [&daemon, &body]);
        browser.go(&at.url);
        browser.until(&format!("{frames} > 5"));
        let (begun, first) = (Instant::now(), browser.eval(frames).as_f64().unwrap());
        let watched = Speed::of(&house, [&daemon, &body]);
        let shown = (browser.eval(frames).as_f64().unwrap() - first) / begun.elapsed().as_secs_f64();
        println!("round {round}: {}; {shown:.1} pictures/s", told(alone, watched));
        without.push(alone);
        with.push(watched);
    }
    println!("mean: {}", told(Speed::mean(&without), Speed::mean(&with)));
}
