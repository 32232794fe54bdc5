"""A body: describe yourself, sense, act. `run` is the whole life of a body's process around it."""

from __future__ import annotations

import contextlib
import logging
import math
import signal
import socket
import sys
import threading
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, NamedTuple, Optional, Union

from . import _checked, _native
from .declare import Description, Observation, Outcome
from .errors import ArgumentError, DeclarationError

if TYPE_CHECKING:
    import numpy

__all__ = ["Body", "Summary", "run"]

_log = logging.getLogger("pschema")

#: Places in pictures are numbers of 32 bits.
_PIXELS_FAR = 1e30

#: The signals by which a person or another program asks a process to end.
_TO_END = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Body:
    """A body that the learner can live in. Write a class with these functions, and hand it to `run`.

    A lamp::

        class Lamp(pschema.Body):
            lit = False

            def describe(self):
                lamp = pschema.state("lamp", lit=pschema.boolean())
                return pschema.Description("lamp", senses=[lamp], actions=[pschema.action("press")])

            def sense(self):
                yield "lamp", {"lit": self.lit}

            def act(self, action):
                self.lit = not self.lit
    """

    def describe(self) -> Description:
        """What the body senses and can do. Asked for once, before it attaches."""
        raise NotImplementedError(f"{type(self).__name__} has no describe()")

    def sense(self) -> Iterable[Observation]:
        """Everything that the body senses now, once before each decision: a list of observations, or a generator of them.

        An observation is ``(name, {property: value, …})``, ``(name, (value, …))`` in declared order, or the name alone where the
        sense has no properties. What is wrong with one ends the run with a `pschema.FrameError`; so does an exception.
        """
        raise NotImplementedError(f"{type(self).__name__} has no sense()")

    def act(self, action: _native.Action) -> Optional[Outcome]:
        """Carries an action out, to its end: ``action.name``, and its parameters as ``action["reach"]``.

        Returns how it went; nothing when it was carried out. An exception is an action that failed, with its text as the reason: it
        goes to the log ``pschema`` and the body goes on. ``KeyboardInterrupt`` and ``SystemExit`` end the run.
        """
        raise NotImplementedError(f"{type(self).__name__} has no act()")

    def arrange(self, command: _native.Action) -> Optional[Outcome]:
        """Arranges the body's surroundings as a curriculum asks. A body that declared no scene commands never gets one."""
        return Outcome.refused("this body arranges nothing")

    def picture(
        self,
    ) -> Union[numpy.ndarray[Any, Any], tuple[numpy.ndarray[Any, Any], Iterable[tuple[float, float, float]]], None]:
        """What the body saw when it last sensed, for ``pschema view``; ``None`` if it has no eye, as most bodies.

        An array of height × width × 3 bytes (red, green, blue; ``uint8``; at most 2,304,000 pixels), or that and its visual fields as
        (x, y, radius) in pixels, in the order in which observations number them. Asked for only while somebody watches.

        Nothing is learnt of a picture, so a body does not end for one: an exception, or anything else than such an array, goes to the log
        ``pschema`` once, and is not shown.
        """
        return None


@dataclass(frozen=True)
class Summary:
    """What happened in a run."""

    #: Why it ended: ``stopped`` (by Ctrl-C, a signal, or its flag), ``detached`` (the daemon sent the body
    #: away, as it does when it is ended), or ``daemon-gone``.
    ending: str
    #: Sessions opened: one, and one more each time the daemon was found again.
    sessions: int
    #: Frames that were replied to.
    frames: int
    #: Actions and scene commands that the body was given.
    orders: int
    #: Frames that the daemon refused.
    refused: int


#: What a picture is when it is handed over: width, height, the bytes of its pixels, its fields.
_PlainPicture = tuple[int, int, bytes, list[tuple[float, float, float]]]


class _Calls(NamedTuple):
    sense: Callable[[], Iterable[Observation]]
    act: Callable[[_native.Action], Optional[Outcome]]
    arrange: Callable[[_native.Action], Optional[Outcome]]
    picture: Callable[[], Optional[_PlainPicture]]
    failed: Callable[[BaseException], None]


def _failures(what: str, body: Body) -> Callable[[BaseException], None]:
    """What logs the exceptions of a body: with their trace, but one that comes again and again only once."""
    last: Optional[tuple[type[BaseException], str]] = None

    def failed(raised: BaseException) -> None:
        nonlocal last
        try:
            this = (type(raised), str(raised))
        except Exception:
            this = (type(raised), "")
        if this != last:
            last = this
            trace = (type(raised), raised, raised.__traceback__)
            _log.error("%s of %s failed; said once until it fails otherwise", what, type(body).__name__, exc_info=trace)

    return failed


class _NoPictureError(Exception):
    """What a body returned is no picture."""


def _plain_picture(taken: Any) -> _PlainPicture:
    import numpy

    pixels, fields = taken if isinstance(taken, tuple) and len(taken) == 2 else (taken, ())
    pixels = numpy.asarray(pixels)
    told = f"picture() returned {pixels.dtype} of the shape {pixels.shape}"
    if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != numpy.uint8:
        raise _NoPictureError(f"{told}: height × width × 3 of uint8 are wanted")
    height, width, _ = pixels.shape
    if not 1 <= height * width <= _native.PICTURE_PIXELS_MAX:
        raise _NoPictureError(f"{told}: 1 to {_native.PICTURE_PIXELS_MAX:,} pixels are wanted, height × width; show it smaller")
    marks = []
    for number, field in enumerate(fields):
        try:
            x, y, radius = (float(at) for at in field)
        except (TypeError, ValueError):
            raise _NoPictureError(f"picture(): field {number} is {_checked.shown(field)}: (x, y, radius) are wanted, in pixels") from None
        if not all(math.isfinite(at) and abs(at) <= _PIXELS_FAR for at in (x, y, radius)):
            raise _NoPictureError(f"picture(): field {number} is {_checked.shown(field)}, which is nowhere")
        marks.append((x, y, radius))
    if len(marks) > _native.PICTURE_FIELDS_MAX:
        raise _NoPictureError(f"picture(): it has {len(marks):,} fields, and at most {_native.PICTURE_FIELDS_MAX:,} are shown")
    return width, height, numpy.ascontiguousarray(pixels).tobytes(), marks


def _pictures(body: Body) -> Callable[[], Optional[_PlainPicture]]:
    failed = _failures("a picture", body)

    def picture() -> Optional[_PlainPicture]:
        # For people alone: a body that has lived for a week does not end for what one of them would have looked at.
        try:
            taken = body.picture()
            return None if taken is None else _plain_picture(taken)
        except Exception as wrong:
            failed(wrong)
            return None

    return picture


@contextlib.contextmanager
def _ended_by_signals(stop: _native.Stop) -> Iterator[None]:
    """While the run lasts, the signals that ask a process to end set the flag, however long the run waits for its daemon.

    Python looks at signals between two of its own instructions, and there are none while the run waits. So the interpreter is
    asked to write the number of each signal into a socket, which a thread reads.
    """
    if threading.current_thread() is not threading.main_thread():
        # Signals are the main thread's; it stops this run by the flag.
        yield
        return

    asked = False

    def end(_number: int, _frame: object) -> None:
        nonlocal asked
        if asked:
            # Asked again: an action that does not come to its end shall not keep a person from ending the program.
            raise KeyboardInterrupt
        asked = True
        stop.set()

    # Handlers that the program chose stay, and are heard as soon as the run is over; what it ignores stays ignored.
    before = {one: signal.getsignal(one) for one in _TO_END}
    usual = [one for one, handler in before.items() if handler in (signal.SIG_DFL, signal.default_int_handler)]
    for one in usual:
        signal.signal(one, end)
    handled = {int(one) for one, handler in before.items() if handler is not signal.SIG_IGN}
    reader, writer = socket.socketpair()
    writer.setblocking(False)
    woken_before = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)

    def watch() -> None:
        while numbers := reader.recv(64):
            if handled.intersection(numbers):
                stop.set()

    watcher = threading.Thread(target=watch, name="pschema-signals", daemon=True)
    watcher.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(woken_before)
        # The thread reads the end of the stream and ends.
        writer.close()
        watcher.join()
        reader.close()
        for one in usual:
            if signal.getsignal(one) is end:
                signal.signal(one, before[one])


def run(
    body: Body,
    name: Optional[str] = None,
    *,
    exit_when_daemon_gone: bool = False,
    stop: Optional[_native.Stop] = None,
) -> Summary:
    """Runs a body until Ctrl-C, SIGTERM or ``stop``, or until the daemon sends it away.

    It waits for the daemon, attaches, senses, acts, and attaches again when the daemon comes back. It leaves with a farewell.
    The interpreter is free while the body waits, so that other threads go on.

    Args:
        body: the body.
        name: of the learner; by default what follows ``--name`` on the command line, else ``default``.
        exit_when_daemon_gone: end when the daemon has been gone for 3 s, instead of waiting for it.
        stop: a flag that ends the run from another thread. Signals reach the main thread alone: a run in another needs it.

    Returns:
        What happened, also after Ctrl-C.

    Raises:
        DeclarationError: the description is not allowed.
        FrameError: the body sensed what it did not declare.
        RefusedError: the daemon does not take the body; with code 21, because one of its name is attached already; with code 0, because as
            many are as it takes.
        ArgumentError: something else is given than a body, the name of a learner, or a flag.
        Exception: whatever ``describe`` or ``sense`` raise.
    """
    if isinstance(body, type):
        raise ArgumentError(f"body={_checked.shown(body)}: give an object of the class, as {body.__name__}(), and not the class")
    missing = [name for name in ("describe", "sense", "act", "arrange", "picture") if not callable(getattr(body, name, None))]
    if missing:
        raise ArgumentError(f"body={_checked.shown(body)}: it has no {missing[0]}(); give an object of a class made of pschema.Body")
    if stop is not None and not isinstance(stop, _native.Stop):
        raise ArgumentError(f"stop={_checked.shown(stop)}: give a pschema.Stop")
    description = body.describe()
    if not isinstance(description, Description):
        raise DeclarationError(f"describe() returned {_checked.shown(description)}: return a pschema.Description")
    flag = _native.Stop() if stop is None else stop
    calls = _Calls(body.sense, body.act, body.arrange, _pictures(body), _failures("an action", body))
    learner = _named() if name is None else _checked.text("name", name)
    with _ended_by_signals(flag):
        return Summary(*_native.run(calls, description._plain(), learner, bool(exit_when_daemon_gone), flag))


def _named() -> str:
    """The learner that the command line names, as bodies in Rust have it."""
    arguments = sys.argv[1:]
    for place, argument in enumerate(arguments):
        if argument == "--name" and place + 1 < len(arguments):
            return arguments[place + 1]
        if argument.startswith("--name="):
            return argument[len("--name=") :]
    return "default"
