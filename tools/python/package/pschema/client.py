"""Looking into a learner, and giving it orders."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from typing import Any, Callable, Optional, Union

from . import _checked, _native
from .errors import AnswerError, ArgumentError, NoDaemonError
from .questions import _STEP_MAX, Answer, Explanation, Questions

__all__ = ["Client", "Excitation", "Past", "connect"]

#: How often a learner is asked how its goal is doing, in seconds.
_ASK_EVERY_S = 0.05


def _told(reply: bytes) -> Any:
    read = json.loads(reply)
    if "problem" in read:
        raise AnswerError(read["problem"])
    return read["answer"]


class Excitation(list[tuple[int, float]]):
    """Steps, each with the excitation of what excited most. A notebook shows it as a curve."""

    def _repr_svg_(self) -> str:
        width, height, edge = 640, 160, 28
        top = max((value for _, value in self), default=0.0) or 1.0
        first, last = (self[0][0], self[-1][0]) if self else (0, 1)
        across = (width - 2 * edge) / max(last - first, 1)
        points = " ".join(
            f"{edge + (step - first) * across:.1f},{height - edge - value / top * (height - 2 * edge):.1f}" for step, value in self
        )
        text = 'font-family="sans-serif" font-size="11" fill="currentColor"'
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" role="img">'
            f"<title>excitation, steps {first} to {last}, at most {top:.3g}</title>"
            f'<path d="M{edge},{edge} V{height - edge} H{width - edge}" fill="none" stroke="currentColor" opacity="0.4"/>'
            f'<polyline points="{points}" fill="none" stroke="#2a78d6" stroke-width="1.5"/>'
            f'<text x="{edge}" y="{edge - 8}" {text}>excitation, at most {top:.3g}</text>'
            f'<text x="{edge}" y="{height - 8}" {text}>step {first}</text>'
            f'<text x="{width - edge}" y="{height - 8}" text-anchor="end" {text}>step {last}</text></svg>'
        )


class Past(Questions):
    """The memory in a data directory as it was after step ``at``, or as it is; with a daemon on it or without. Nothing is changed."""

    def __init__(self, data: Union[str, os.PathLike[str]], at: Optional[int] = None) -> None:
        if not isinstance(data, (str, os.PathLike)):
            raise ArgumentError(f"data={_checked.shown(data)}: give the path of a data directory")
        self.data = _checked.text("data", os.fspath(data))
        self.at = None if at is None else _checked.whole("at", at, 0, _STEP_MAX)
        self._native = _native.Past(self.data)

    def _asked(self, kind: str, question: dict[str, Any]) -> Any:
        return _told(self._native.request(json.dumps({"question": {kind: question}}).encode(), self.at))

    def __repr__(self) -> str:
        return f"<memory in {self.data}{'' if self.at is None else f' after step {self.at}'}>"


class Client(Questions):
    """A running learner. Several threads may ask; a daemon that was started again is found again. `connect` makes it.

    All functions raise `pschema.NoDaemonError` when there is no daemon any more.
    """

    def __init__(self, name: str, timeout_s: float) -> None:
        self.name = _checked.text("name", name)
        self._timeout_s = _checked.number("timeout_s", timeout_s)
        self._native: Optional[_native.Client] = _native.Client(self.name, self._timeout_s)

    def _send(self, sort: str, kind: str, asked: Any) -> Any:
        if self._native is None:
            raise AnswerError(f"the connection to {self.name} was closed: connect again")
        return _told(self._native.request(json.dumps({sort: {kind: asked}}).encode()))

    def _asked(self, kind: str, question: dict[str, Any]) -> Any:
        return self._send("question", kind, question)

    def past(self, at: Optional[int] = None) -> Past:
        """Its memory as it was after step ``at``, from its data directory.

        Raises:
            AnswerError: its memory is in RAM only.
        """
        storage = self.status()["storage"]
        if storage is None:
            raise AnswerError(f"the memory of {self.name} is in RAM only, so it has no past: start its daemon with --data DIR")
        return Past(storage["directory"], at)

    def explain(self, step: Optional[int] = None, *, candidates: int = 5) -> Explanation:
        """Why the action of a step was chosen, term by term; of the last decision if no step is named.

        A daemon has the latest 64 decisions at hand; older ones are made again from its data directory, if it has one.
        """
        return Explanation(self._of_decision(step, lambda asked: asked.explain(step, candidates=candidates)))

    def why_not(self, schema: int, step: Optional[int] = None) -> Answer:
        """What stood in the way of a schema; of an earlier step as `explain`."""
        return self._of_decision(step, lambda asked: asked.why_not(schema, step))

    def _of_decision(self, step: Optional[int], ask: Callable[[Questions], Answer]) -> Answer:
        try:
            return ask(_Present(self))
        except AnswerError:
            status = self.status()
            if step is None or step > status["step"] or status["storage"] is None:
                raise
        return ask(Past(status["storage"]["directory"]))

    def say(self, *words: str) -> Answer:
        """Words are heard, together, in the learner's next frame."""
        return dict(self._send("order", "say", {"words": _checked.texts("words", words)}))

    def stage(self, order: Optional[str] = None) -> Answer:
        """Developmental control: ``"next"``, ``"hold"``, ``"resume"``, ``"step"``, or the name of a stage to enter; none only asks.

        Returns what the curriculum has done so far.
        """
        if order is None:
            return self.report()
        order = _checked.text("order", order)
        known = order in ("next", "hold", "resume", "step")
        return dict(self._send("order", "stage", order if known else {"set": order}))

    def achieve(
        self,
        *goal: str,
        again: bool = False,
        most: Optional[str] = None,
        actions_max: int = 50,
        wait_s: float = 60.0,
        seen: Optional[Callable[[Answer], None]] = None,
        stop: Optional[_native.Stop] = None,
    ) -> Answer:
        """The learner pursues a goal; waits until it is achieved, given up, or called off because the time is up.

        Args:
            goal: patterns as they print, ``"object{colour=blue, field=$x}"``; all are to hold at once, and a variable is the same value
                in all of them.
            again: that they hold already does not count; they are to be brought about.
            most: instead of patterns, the name of a value of which as much as can be is to come, a reward: ``achieve(most="reward")``. That
                goes on until ``actions_max`` actions were taken or the time is up.
            actions_max: how many actions may be taken for it; 1 to 100,000.
            wait_s: seconds to wait.
            seen: is called with the pursuit whenever it has moved on. An exception in it, or Ctrl-C, calls the goal off.
            stop: a flag that calls the goal off from another thread.

        Returns:
            How it ended: ``state``, ``achieved``, ``actions``, ``plans``; with ``most`` the sum that ``came``.

        Raises:
            AnswerError: a pattern that can't be read, a value outside the range that the body declares, or no body is attached.
        """
        order = {**_checked.wanted(goal, again, most), "actions_max": _checked.whole("actions_max", actions_max, 1)}
        wait_s = _checked.number("wait_s", wait_s)
        if seen is not None and not callable(seen):
            raise ArgumentError(f"seen={_checked.shown(seen)}: give a function that takes the pursuit")
        if stop is not None and not isinstance(stop, _native.Stop):
            raise ArgumentError(f"stop={_checked.shown(stop)}: give a pschema.Stop")
        now: Answer = self._send("order", "achieve", order)
        number, until, told = now["number"], time.monotonic() + wait_s, None
        try:
            while True:
                if seen is not None and told != (now["actions"], now["plans_made"], now["state"]):
                    told = (now["actions"], now["plans_made"], now["state"])
                    seen(now)
                if now["state"] != "pursued":
                    return now
                if time.monotonic() >= until or (stop is not None and stop.is_set()):
                    return self.cancel(number)
                time.sleep(_ASK_EVERY_S)
                now = self.pursuit()
                if now["number"] != number:
                    raise AnswerError(f"goal {number} is over and goal {now['number']} was taken up before its end was seen")
        except BaseException:
            if now["number"] == number and now["state"] == "pursued":
                self.cancel(number)
            raise

    def cancel(self, number: int) -> Answer:
        """Calls off the goal of this number; one that is over stays as it ended."""
        return dict(self._send("order", "cancel", {"number": _checked.whole("number", number, 0, _STEP_MAX)}))

    def shutdown(self) -> None:
        """Ends the daemon, cleanly."""
        self._send("order", "shutdown", {})

    def watch(self, *, rate: float = 10.0) -> Iterator[Answer]:
        """Every step from now on, in order: ``step``, ``perceived``, ``decision`` (its ``action``, ``schema``, ``excitation``), and more.

        The daemon is asked ``rate`` times a second at most. The iterator ends when the daemon does.
        """
        return self._watched(1.0 / _checked.number("rate", rate, above=True))

    def _watched(self, pause_s: float) -> Iterator[Answer]:
        after = self._asked("trace", {"from": 2**63})["total"]
        while True:
            try:
                page = self._asked("trace", {"from": after})
            except NoDaemonError:
                return
            yield from page["records"]
            after = page["from"] + len(page["records"])
            if not page["records"]:
                time.sleep(pause_s)

    def excitation(self, last: int = 200) -> Excitation:
        """How excited the learner was in the last of its steps: the curve of the paper's figure 6."""
        last = _checked.whole("last", last)
        total = self._asked("trace", {"from": 2**63})["total"]
        start, records = max(0, total - last), []
        while start < total:
            page = self._asked("trace", {"from": start})
            if not page["records"]:
                break
            records += page["records"]
            start = page["from"] + len(page["records"])
        decided = [(record["step"], record["decision"]) for record in records if record["decision"]]
        return Excitation((step, decision["excitation_top"] or 0.0) for step, decision in decided)

    def close(self) -> None:
        """Gives up the place that the connection takes in the daemon."""
        self._native = None

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<connection to {self.name}>"


class _Present(Questions):
    """The decisions that a daemon has at hand."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def _asked(self, kind: str, question: dict[str, Any]) -> Any:
        return self._client._asked(kind, question)


def connect(name: str = "default", *, timeout_s: float = 5.0) -> Client:
    """Connects to the daemon of the learner ``name``; each page of an answer may take ``timeout_s`` seconds.

    Raises:
        NoDaemonError: there is none.
        ArgumentError: no learner can have that name, or that is no time.
    """
    return Client(name, timeout_s)
