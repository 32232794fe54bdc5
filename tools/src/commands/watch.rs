//! `pschema watch`.

use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};

use crate::cli::WatchArgs;
use crate::failure::Failure;
use crate::output;
use crate::watch::{once, watch};

pub(crate) fn run(name: &LearnerName, args: &WatchArgs) -> Result<(), Failure> {
    if let Some(data) = &args.data.data {
        let data = data.display();
        return Err(Failure::Usage(format!(
            "`watch` needs a learner that is running: start `pschema server --data {data}` and watch that. What was, \
             `pschema status`, `schemas`, `show` and `explain` tell with --data {data} --until N"
        )));
    }
    let place = Place::new(RuntimeDir::from_environment()?, name.clone());
    if args.once {
        return output::print(&once(&place, args.page, args.follow, args.width, args.height)?);
    }
    watch(place, args.rate, args.page, args.follow)
}
