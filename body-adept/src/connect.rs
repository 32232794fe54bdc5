//! An arm on a line: the line is opened, the controller that answers on it is met in the mode of the arm file, and a watch
//! is set over both.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use crate::arm::{Arm, Connect, Permissions};
use crate::config::{ArmSetup, LineMode};
use crate::controller::monitor::MonitorController;
use crate::controller::program::ProgramController;
use crate::controller::{Controller, GuardedLine};
use crate::line::record::RecordingLine;
use crate::line::recorder::LineRecorder;
use crate::line::serial::SerialLine;
use crate::line::{Line, LineError};
use crate::switch::StopSwitch;
use crate::v_plus;
use crate::watch::{Beat, Signs, Watch};

/// Opens a line anew with each call.
pub type OpenLine = Box<dyn FnMut() -> Result<Box<dyn Line>, LineError> + Send>;

pub(crate) fn serial(setup: &ArmSetup, port: PathBuf, recorder: LineRecorder) -> OpenLine {
    let baud = setup.file.line.baud.count() as u32;
    Box::new(move || {
        let line = SerialLine::open(&port, baud)?;
        Ok(Box::new(RecordingLine::new(Box::new(line), recorder.clone())))
    })
}

/// An arm on lines that `open` opens.
///
/// # Errors
/// When no thread can be started.
pub fn arm_on(
    setup: &Arc<ArmSetup>,
    open: OpenLine,
    recorder: LineRecorder,
    may: Permissions,
    stop: Arc<AtomicBool>,
    daemon: Option<Beat>,
) -> io::Result<Arm> {
    let switch = StopSwitch::default();
    let silence_max = Duration::from_secs_f64(setup.file.motion.heartbeat_ms.get() / 1000.0);
    let signs = Signs { driver: Beat::default(), daemon, stop, silence_max };
    let watch = Watch::begin(signs, switch.clone())?;
    let connect = connector(setup.clone(), open, recorder.clone(), watch.signs().driver.clone());
    Ok(Arm::new(setup.clone(), connect, switch, watch, recorder, may))
}

/// Connects to the controller in the mode that the arm file says.
fn connector(setup: Arc<ArmSetup>, mut open: OpenLine, recorder: LineRecorder, driver: Beat) -> Connect {
    Box::new(move |switch: &StopSwitch| {
        let line = open()?;
        let (touch, line_file) = (&setup.file.touch, &setup.file.line);
        let answer_wait = Duration::from_secs_f64(line_file.answer_ms.get() / 1000.0);
        let stop_bytes = match line_file.mode {
            LineMode::Server => v_plus::program::STOP,
            LineMode::Monitor => v_plus::monitor::STOP,
        };
        switch.connect(line.stopper()?, stop_bytes, recorder.clone());
        let line = GuardedLine::new(line, switch.clone(), driver.clone());
        Ok(match line_file.mode {
            LineMode::Server => {
                let joints = setup.gate.taught().joints();
                Box::new(ProgramController::new(line, joints, touch.inverted, answer_wait))
                    as Box<dyn Controller>
            }
            LineMode::Monitor => {
                let signals = touch.signals.map(|signal| signal.count() as u16);
                let tolerances = setup.gate.tolerances().to_vec();
                Box::new(MonitorController::new(line, tolerances, signals, touch.inverted, answer_wait))
            }
        })
    })
}
