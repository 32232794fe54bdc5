"""A runtime directory for each test, and nothing of it left in shared memory."""

from __future__ import annotations

import contextlib
import glob
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Callable, Optional, TypeVar

import pytest

import pschema

T = TypeVar("T")

#: How long anything may take before a test gives up on it, in seconds. What is waited for takes moments; this is for machines under load.
DEADLINE_S = 120.0


def until(what: str, look: Callable[[], Optional[T]]) -> T:
    """Calls `look` again and again until it returns something."""
    end = time.monotonic() + DEADLINE_S
    while True:
        seen = look()
        if seen is not None:
            return seen
        assert time.monotonic() < end, f"{what}: not within {DEADLINE_S} s"
        time.sleep(0.01)


class Sandbox:
    """A private runtime directory, in which everything is started that a test starts."""

    def __init__(self, runtime: Path) -> None:
        self.runtime = runtime
        self.processes: list[subprocess.Popen[str]] = []
        self.prefixes: set[str] = set()

    def note(self) -> None:
        """Notes which shared memory belongs to this sandbox, before the daemon that says so ends."""
        for record in self.runtime.glob("*/domain"):
            for line in record.read_text().splitlines():
                if line.startswith("prefix = "):
                    self.prefixes.add(line.removeprefix("prefix = ").strip())

    def daemon(self, name: str, **options: Any) -> pschema.Daemon:
        started = pschema.Daemon(name, **options)
        self.note()
        return started

    def python(self, text: str, *arguments: str) -> subprocess.Popen[str]:
        """Starts a program in Python."""
        command = [sys.executable, "-c", textwrap.dedent(text), *arguments]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.processes.append(process)
        return process

    def command(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Runs the command `pschema`."""
        command = [pschema.program(), *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=False)

    def left(self) -> list[str]:
        return [path for prefix in self.prefixes for path in glob.glob(f"/dev/shm/{prefix}*")]

    def clear(self) -> None:
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.communicate()
        self.note()
        for path in self.left():
            os.unlink(path)


def finished(process: subprocess.Popen[str], code: int = 0) -> tuple[str, str]:
    """What a program said until it ended by itself."""
    out, err = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == code, f"exit code {process.returncode}\n{out}\n{err}"
    return out, err


def steps(learner: pschema.Client, more_than: int = 0) -> int:
    """Waits until a learner has taken more steps."""

    def taken() -> Optional[int]:
        step = int(learner.status()["step"])
        return step if step > more_than else None

    return until(f"{learner} is past step {more_than}", taken)


@pytest.fixture
def sandbox(monkeypatch: pytest.MonkeyPatch) -> Iterator[Sandbox]:
    # In /tmp whatever TMPDIR is: sockets need short paths.
    runtime = Path(tempfile.mkdtemp(prefix="pyt-", dir="/tmp"))
    monkeypatch.setenv("PSCHEMA_RUNTIME_DIR", str(runtime))
    box = Sandbox(runtime)
    yield box
    box.clear()
    shutil.rmtree(runtime)


@pytest.fixture(autouse=True)
def signals_are_as_before() -> Iterator[None]:
    before = [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    yield
    assert [signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)] == before


@contextlib.contextmanager
def running(body: pschema.Body, name: str) -> Iterator[None]:
    """A body that runs in a thread of its own meanwhile; whatever it raises is raised at the end."""
    import threading

    stop, raised = pschema.Stop(), []

    def work() -> None:
        try:
            pschema.run(body, name, stop=stop)
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join(DEADLINE_S)
        assert not thread.is_alive()
    if raised:
        raise raised[0]


class Lamp(pschema.Body):
    """A lamp that a button switches."""

    def __init__(self, name: str = "lamp") -> None:
        self.name = name
        self.lit = False
        self.pressed = 0

    def describe(self) -> pschema.Description:
        lamp = pschema.state("lamp", lit=pschema.boolean())
        return pschema.Description(self.name, senses=[lamp], actions=[pschema.action("press"), pschema.action("rest")])

    def sense(self) -> list[pschema.Observation]:
        return [("lamp", {"lit": self.lit})]

    def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
        if action.name == "press":
            self.lit = not self.lit
            self.pressed += 1
        return None
