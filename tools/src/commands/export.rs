//! `pschema export`: a memory as JSON Lines.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use pschema_inspect::StatusQuery;
use pschema_process::{Occupied, OutputError, OutputFile, Stop, say};
use pschema_protocol::domain::LearnerName;
use pschema_store::past::Past;
use pschema_store::past::export::{ExportError, ExportSummary};

use crate::args::{General, MeantMemory, MemoryArgs};
use crate::bar::Bar;
use crate::failure::Failure;
use crate::learner::Learner;
use crate::output;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema export --data ~/arm -o arm.jsonl\n  \
    pschema export --name arm | jq -r 'select(.schema.generalised) | .schema.id'")]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    memory: MemoryArgs,
    /// Write to this file, which must not be there yet, or to this pipe; to stdout unless named
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the file if it is there
    #[arg(long, requires = "output")]
    overwrite: bool,
}

/// How often a person is told how far it is, in lines.
const TELL_EVERY: u64 = 1_024;

pub(crate) fn run(args: ExportArgs, general: &General) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let path = output::named(args.output.as_deref().unwrap_or(Path::new("-")));
    // What a learner knows is its owner's.
    let mut file =
        OutputFile::prepare(path, Occupied::overwritten(args.overwrite), &stop.flag())?.private()?;
    let (directory, until) = match args.memory.meant(general)? {
        MeantMemory::OnDisk(directory, until) => (directory.to_owned(), until),
        MeantMemory::Running(name) => (served(&name)?, None),
    };
    let past = Past::open(&directory)?;
    let moment = past.moment(until)?;
    let step = moment.step();
    let bar = Bar::count(general.quiet());
    let told = |lines: u64| {
        if lines.is_multiple_of(TELL_EVERY) {
            bar.show(lines, lines, "lines".to_owned());
        }
    };
    let written = past.export(&moment, &mut BufWriter::new(Stoppable { to: &mut file, stop: &stop }), told);
    stop.check()?;
    let failed = |error| match error {
        ExportError::Write(source) => Failure::from(OutputError::Io { path: path.to_owned(), source }),
        error => Failure::of(error),
    };
    let ExportSummary { lines, memory_digest } = written.map_err(failed)?;
    file.finish()?;
    drop(bar);
    if let Some(file) = args.output.as_ref().filter(|file| !general.quiet() && !output::is_stdout(file)) {
        say(&format!("{}: {lines} lines, memory of step {step}, digest {memory_digest}", file.display()));
    }
    Ok(())
}

/// The data directory of a running daemon.
fn served(name: &LearnerName) -> Result<PathBuf, Failure> {
    match Learner::connect(name)?.ask(StatusQuery {})?.storage {
        Some(storage) => Ok(PathBuf::from(storage.directory)),
        None => Err(Failure::Failed(format!(
            "the memory of {name} is in RAM only, so it can't be exported: start its daemon with --data DIR"
        ))),
    }
}

/// Stops writing when this process is asked to stop.
struct Stoppable<'a> {
    to: &'a mut OutputFile,
    stop: &'a Stop,
}

impl Write for Stoppable<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.stop.is_raised() { Err(io::Error::other("stopped")) } else { self.to.write(bytes) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}
