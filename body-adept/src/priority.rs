//! The priority of a thread that must be on time.

#![allow(unsafe_code)]

use std::io;

/// Low among real-time priorities, and above everything that is not real-time.
const PRIORITY: libc::c_int = 10;
/// The niceness that is asked for when a real-time priority is not permitted.
const NICENESS: i32 = -15;

/// Lets this thread run before all ordinary ones, or at least before most, as far as this user may. It must sleep most
/// of the time.
///
/// # Errors
/// When neither is permitted. Nothing is changed then.
pub(crate) fn be_on_time() -> io::Result<()> {
    // SAFETY: this C structure consists of numbers, for which zero is a value.
    let mut wanted: libc::sched_param = unsafe { std::mem::zeroed() };
    wanted.sched_priority = PRIORITY;
    // Not passed on to processes that this thread might start.
    let policy = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
    // SAFETY: 0 is this thread; `wanted` outlives the call, which reads it alone.
    if unsafe { libc::sched_setscheduler(0, policy, &raw const wanted) } == 0 {
        return Ok(());
    }
    rustix::process::setpriority_process(None, NICENESS).map_err(io::Error::from)
}
