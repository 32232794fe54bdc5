"""A daemon that a program starts for itself."""

from __future__ import annotations

import os
import shutil
import subprocess
import sysconfig
import time
from collections.abc import Iterable
from typing import Optional, Union

from . import _checked
from .client import connect
from .errors import ArgumentError, Error, NoDaemonError

__all__ = ["Daemon", "program"]

#: How long a daemon may take to answer, with memory on disk to read, and to end.
_READY_S = 60.0
_ENDED_S = 30.0


def program() -> str:
    """The path of the ``pschema`` command: that which came with this package, else the first in ``PATH``.

    Raises:
        Error: there is none.
    """
    beside = os.path.join(sysconfig.get_path("scripts"), "pschema")
    found = beside if os.access(beside, os.X_OK) else shutil.which("pschema")
    if not found:
        raise Error(f"there is no program pschema in {os.path.dirname(beside)} or in PATH: install the package again")
    return found


class Daemon:
    """A learner's daemon, as a process of its own, for as long as a ``with`` lasts::

        with pschema.Daemon("lamp"):
            pschema.run(Lamp(), "lamp")

    It ends when this program does, however that ends. The kernel sees to it by the thread: start it in one that lives as long, as the main
    thread does.

    Args:
        name: of the learner; 1 to 32 of ``a-z 0-9 _ -``.
        data: the directory that memory is kept in; without it, memory ends with the daemon.
        seed: what the learner's draws begin from; 1, or that of the memory in ``data``.
        curriculum: a built-in one, or a file.
        arguments: more of ``pschema server``.

    Raises:
        ArgumentError: one of these is of another kind.
        Error: it could not be started; with what it said.
    """

    def __init__(
        self,
        name: str = "default",
        *,
        data: Union[str, os.PathLike[str], None] = None,
        seed: Optional[int] = None,
        curriculum: Optional[str] = None,
        arguments: Iterable[str] = (),
    ) -> None:
        self.name = _checked.text("name", name)
        if data is not None and not isinstance(data, (str, os.PathLike)):
            raise ArgumentError(f"data={_checked.shown(data)}: give the path of a data directory")
        self.data = data
        if seed is not None:
            _checked.whole("seed", seed, 0, 2**64 - 1)
        if curriculum is not None:
            _checked.text("curriculum", curriculum)
        if isinstance(arguments, str):
            raise ArgumentError(
                f"arguments={_checked.shown(arguments)}: give a list of texts, as they stand on the command line one by one"
            )
        arguments = _checked.texts("arguments", arguments)
        command = [program(), "server", "--name", name, "--parent", str(os.getpid())]
        command += [] if data is None else ["--data", os.fspath(data)]
        command += [] if seed is None else ["--seed", str(seed)]
        command += [] if curriculum is None else ["--curriculum", curriculum]
        self._process = subprocess.Popen([*command, *arguments], stdin=subprocess.DEVNULL, start_new_session=True)
        try:
            self._await()
        except BaseException:
            self.end()
            raise

    def _await(self) -> None:
        until = time.monotonic() + _READY_S
        while True:
            if self._process.poll() is not None:
                raise Error(f"the daemon of {self.name} ended with exit code {self._process.returncode}; it said why on stderr")
            try:
                with connect(self.name) as learner:
                    pid = learner.status()["pid"]
            except NoDaemonError:
                pid = None
            if pid == self._process.pid:
                return
            if time.monotonic() > until:
                raise Error(f"the daemon of {self.name} did not answer within {_READY_S:.0f} s")
            time.sleep(0.01)

    @property
    def pid(self) -> int:
        """The number of its process."""
        return self._process.pid

    @property
    def exit_code(self) -> Optional[int]:
        """How it ended: 0 if cleanly, the number of a signal below zero if it was killed; none while it runs."""
        return self._process.poll()

    def wait(self) -> int:
        """Waits until it has ended, whoever ends it, and returns its `exit_code`."""
        return self._process.wait()

    def end(self) -> None:
        """Ends it, cleanly, and waits for it."""
        if self._process.poll() is None:
            self._process.terminate()
        try:
            self._process.wait(_ENDED_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def __enter__(self) -> Daemon:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()
