//! The daemon with a data directory: killed at any instant, it comes back with everything that a body acted on.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::path::Path;

use std::time::Duration;

use common::ask;
use common::process::{BodyThread, Daemon, directory, place, recovered, served, status};
use pschema_inspect::{ReportQuery, SayOrder, StageOrder, StageState};
use pschema_learner::random::Random;
use pschema_protocol::client::Client;
use rustix::process::{Resource, Rlimit, Signal, kill_process, prlimit};

#[test]
fn one_memory_outlives_many_daemons_and_says_so() {
    let directory = directory();
    let place = place(directory.path());
    let data = directory.path().join("data");
    let data = data.to_str().unwrap();
    let body = BodyThread::start(&place);
    let mut random = Random::from_seed(3);
    for life in 0..6 {
        let acknowledged = body.acts();
        let mut daemon = served(directory.path(), data, 7, &[]);
        daemon.ready();
        let now = status(&place);
        let storage = now.storage.clone().unwrap();
        assert!(now.step >= acknowledged && now.durable_step >= Some(acknowledged), "life {life}: {now:?}");
        assert_eq!((storage.durability.as_str(), storage.directory.ends_with("data")), ("strict", true));
        body.past(acknowledged + 1 + random.below(200) as u64);
        let later = status(&place).storage.unwrap();
        assert!(later.journal_bytes > storage.journal_bytes);
        daemon.kill();
    }
}

#[test]
fn what_stands_in_the_way_of_keeping_memory_is_told() {
    let directory = directory();
    let data = directory.path().join("data");
    let data = data.to_str().unwrap();
    let mut first = served(directory.path(), data, 1, &["--durability", "relaxed"]);
    first.ready();
    assert_eq!(
        status(&place(directory.path())).storage.unwrap().durability,
        pschema_inspect::Durability::Relaxed
    );
    let second = Daemon::start(directory.path(), &["--name", "two", "--data", data]).failed();
    let holder = format!("in use by learner one, process {}", first.0.id());
    assert!(second.contains(&holder), "{second}");
    first.kill();

    let other_seed = served(directory.path(), data, 2, &[]).failed();
    assert!(other_seed.contains("begun with seed = 1, and 2 was given"), "{other_seed}");
    let file = directory.path().join("file");
    std::fs::write(&file, "").unwrap();
    let nowhere = served(directory.path(), file.join("data").to_str().unwrap(), 1, &[]).failed();
    assert!(nowhere.contains("cannot create") && nowhere.contains("file/data"), "{nowhere}");
    let journal = Path::new(data).join("journal");
    std::fs::remove_dir_all(&journal).unwrap();
    std::fs::write(&journal, "").unwrap();
    let unreadable = served(directory.path(), data, 1, &[]).failed();
    assert!(unreadable.contains("cannot read") && unreadable.contains("data/journal"), "{unreadable}");
}

/// Opening a pipe that nobody reads or writes takes without end, as with a disk that does not answer.
fn pipe(at: &Path) {
    let mode = rustix::fs::Mode::RWXU;
    rustix::fs::mknodat(rustix::fs::CWD, at, rustix::fs::FileType::Fifo, mode, 0).unwrap();
}

/// With a disk that took seconds to confirm, no question was answered, `status` neither.
#[test]
fn questions_are_answered_while_the_disk_is_at_work_and_orders_when_it_has_confirmed() {
    let directory = directory();
    let place = place(directory.path());
    let data = directory.path().join("data");
    // Under the profile of the paper the first change is one of these.
    let paper = ["--set", "learner.profile=paper"];
    let mut daemon = served(directory.path(), data.to_str().unwrap(), 1, &paper);
    daemon.ready();
    // The file of the first change.
    pipe(&data.join("journal/00000000000000000001.journal"));
    let within = |time| Client::connect(&place, time).unwrap();
    let unanswered = ask(&mut within(Duration::from_millis(100)), StageOrder::Hold).unwrap_err();
    assert!(unanswered.to_string().contains("waiting for a slow disk"), "{unanswered}");
    let mut client = within(Duration::from_secs(20));
    let report = ask(&mut client, ReportQuery {}).unwrap();
    assert_eq!(report.stage_state, StageState::Held, "it is obeyed before it is acknowledged");
    // No change of memory, so there is nothing to wait for.
    ask(&mut client, SayOrder { words: vec!["ball".to_owned()] }).unwrap();
    assert_eq!(status(&place).storage.unwrap().changes_waiting, 1);
    let unanswered = ask(&mut within(Duration::from_millis(100)), StageOrder::Resume);
    assert!(unanswered.is_err());
    assert_eq!(status(&place).storage.unwrap().changes_waiting, 2);
    daemon.kill();
}

/// Tools said that it was stopped or very busy.
#[test]
fn a_daemon_that_is_still_looking_for_its_memory_is_said_to_be_starting() {
    let directory = directory();
    let data = directory.path().join("data");
    std::fs::create_dir(&data).unwrap();
    pipe(&data.join("manifest"));
    let daemon = served(directory.path(), data.to_str().unwrap(), 1, &[]);
    while !data.join("LOCK").exists() {
        std::thread::yield_now();
    }
    let error = Client::connect(&place(directory.path()), Duration::from_millis(50)).unwrap_err();
    let told = format!("process {}, is still starting", daemon.0.id());
    assert!(error.is_no_daemon() && error.to_string().contains(&told), "{error}");
    daemon.kill();
}

/// A disk that does not answer kept a daemon that was asked to end until a second signal came.
#[test]
fn a_daemon_that_is_still_looking_for_its_memory_ends_when_it_is_asked_to() {
    let directory = directory();
    let data = directory.path().join("data");
    std::fs::create_dir(&data).unwrap();
    pipe(&data.join("manifest"));
    let daemon = served(directory.path(), data.to_str().unwrap(), 1, &[]);
    // It has its lock when it begins to look.
    while !data.join("LOCK").exists() {
        std::thread::yield_now();
    }
    kill_process(daemon.pid(), Signal::TERM).unwrap();
    let (code, said) = daemon.ended();
    assert!(code == Some(0) && said.contains("ended before memory was found"), "{code:?}: {said}");
}

/// A weeks-old memory must be able to enter another curriculum, and must not do so by mistake.
#[test]
fn it_goes_on_as_it_is_unless_it_is_told_to_change() {
    let directory = directory();
    let place = place(directory.path());
    let data = directory.path().join("data");
    let started = |more: &[&str]| {
        let arguments = [&["--name", "one", "--data", data.to_str().unwrap()], more].concat();
        Daemon::start(directory.path(), &arguments)
    };
    let asked = ["--seed", "7", "--curriculum", "exp1-s1"];
    let lived = |mut daemon: Daemon, curriculum: &str| {
        daemon.ready();
        let now = status(&place);
        assert_eq!(now.curriculum, curriculum);
        daemon.kill();
        now
    };
    let born = lived(started(&asked), "exp1-s1");
    // Said again, or not said: the same.
    for more in [&asked[..], &[], &["--seed", "7"], &["--curriculum", "exp1-s1"], &["--change"]] {
        assert_eq!(lived(started(more), "exp1-s1").memory_digest, born.memory_digest, "{more:?}");
    }
    let refused = started(&["--curriculum", "free", "--set", "learner.attention=false"]).failed();
    for part in [
        "curriculum.name: \"exp1-s1\" there, \"free\" given",
        "parameters.attention: true there, false given",
        "Add --change to go on under what is given",
    ] {
        assert!(refused.contains(part), "{refused}");
    }
    let mut changed = started(&["--curriculum", "free", "--set", "learner.attention=false", "--change"]);
    changed.ready();
    let body = BodyThread::start(&place);
    body.past(50);
    changed.kill();
    let acknowledged = body.acts();
    drop(body);
    // The change is kept, through the journal and through a snapshot.
    for _ in 0..2 {
        let mut daemon = started(&[]);
        daemon.ready();
        let now = status(&place);
        assert_eq!((now.curriculum.as_str(), now.stage.as_str()), ("free", "free"));
        assert!(now.step >= acknowledged, "{now:?}");
        kill_process(daemon.pid(), Signal::TERM).unwrap();
        assert_eq!(daemon.ended().0, Some(0));
    }
    let seed = started(&["--seed", "8", "--change"]).failed();
    assert!(seed.contains("begun with seed = 7, and 8 was given"), "{seed}");
}

/// As on a full disk: the kernel takes no more bytes.
#[test]
fn when_no_more_can_be_written_nothing_is_done_any_more() {
    let directory = directory();
    let data = directory.path().join("data");
    let mut daemon = served(directory.path(), data.to_str().unwrap(), 5, &[]);
    daemon.ready();
    let body = BodyThread::start(&place(directory.path()));
    body.past(10);
    // The journal is made longer a megabyte at a time.
    let most = Some(1_100_000);
    prlimit(Some(daemon.pid()), Resource::Fsize, Rlimit { current: most, maximum: most }).unwrap();
    let said = daemon.failed();
    assert!(said.contains("memory could not be written, so the daemon ends"), "{said}");
    assert!(
        said.contains("cannot write") && said.contains("data/journal") && said.contains("os error 27"),
        "{said}"
    );
    let acknowledged = body.acts();
    drop(body);
    let step = recovered(&data, 5).content().step;
    assert!(step == acknowledged || step == acknowledged + 1, "{step} steps, {acknowledged} acted on");
    // With room again it goes on.
    let mut daemon = served(directory.path(), data.to_str().unwrap(), 5, &[]);
    daemon.ready();
    let body = BodyThread::start(&place(directory.path()));
    body.past(10);
    assert!(status(&place(directory.path())).durable_step >= Some(step + 10));
}

#[test]
fn a_directory_taken_away_under_it_ends_it() {
    let directory = directory();
    let data = directory.path().join("data");
    let mut daemon = served(directory.path(), data.to_str().unwrap(), 5, &[]);
    daemon.ready();
    let body = BodyThread::start(&place(directory.path()));
    body.past(10);
    std::fs::remove_dir_all(&data).unwrap();
    let said = daemon.failed();
    assert!(said.contains("was moved or removed. Every step that was acknowledged"), "{said}");
}

#[test]
fn a_place_that_takes_no_files_is_told_of() {
    let directory = directory();
    let said = served(directory.path(), "/proc/pschema", 5, &[]).failed();
    assert!(said.contains("cannot create /proc/pschema"), "{said}");
    // A directory that lets nobody write, to anybody but root.
    let data = directory.path().join("data");
    std::fs::create_dir(&data).unwrap();
    let closed = |mode| {
        let permissions = std::os::unix::fs::PermissionsExt::from_mode(mode);
        std::fs::set_permissions(&data, permissions).unwrap();
    };
    closed(0o500);
    let mut daemon = served(directory.path(), data.to_str().unwrap(), 5, &[]);
    if rustix::process::geteuid().is_root() {
        println!("root may write anywhere, so the daemon must begin");
        daemon.ready();
    } else {
        let said = daemon.failed();
        assert!(said.contains("cannot open") && said.contains("data/LOCK"), "{said}");
    }
    closed(0o700);
}

/// The end is asked for while steps are taken as fast as they can be.
#[test]
fn an_end_in_the_middle_of_it_all_keeps_everything() {
    let directory = directory();
    let place = place(directory.path());
    let data = directory.path().join("data");
    let mut step = 0;
    for life in 0..4 {
        let mut daemon = served(directory.path(), data.to_str().unwrap(), 5, &["--snapshot-every", "20KiB"]);
        daemon.ready();
        let now = status(&place);
        assert_eq!(now.step, step, "life {life}");
        // A clean end leaves a snapshot and nothing after it.
        assert_eq!(now.storage.unwrap().snapshot_step, (life > 0).then_some(step), "life {life}");
        let body = BodyThread::start(&place);
        body.past(400);
        kill_process(daemon.pid(), Signal::TERM).unwrap();
        let (code, said) = daemon.ended();
        assert!(code == Some(0) && said.contains("ended"), "{said}");
        drop(body);
        step = recovered(&data, 5).content().step;
        assert!(step >= 400 * (life + 1), "life {life}: {step}");
    }
}
