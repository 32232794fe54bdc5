"""A learner in the program's own process, without a daemon: for sweeps, for tests, and for bodies that step themselves."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from typing import Any, Optional, Union

from . import _checked, _native
from .declare import Description, Observation, Outcome
from .errors import AnswerError, ArgumentError, DeclarationError, Error
from .questions import Questions

__all__ = ["Learner"]


class Learner(Questions):
    """A learner: frames go in, actions come out.

    It decides as a daemon's learner does that is sent the same frames, and its memory has the same digest. Nothing in it depends
    on the time, on other threads or on the machine. It belongs to one thread at a time, and the interpreter is free while it steps.

    Args:
        seed: decides its draws; 0 to 2⁶⁴ − 1.
        profile: ``"full"``, or ``"paper"`` for the learner of Sheldon & Lee (2011).
        curriculum: a built-in one, or the path of a file with one.
        settings: ``"learner.PARAMETER=VALUE"``, as ``pschema server --set`` takes them.

    Raises:
        ArgumentError: a profile, curriculum or setting that there is not.

    Example::

        learner = pschema.Learner(seed=7)
        learner.declare(lamp.describe())
        action = learner.step(lamp.sense())
        for _ in range(1000):
            action = learner.step(lamp.sense(), lamp.act(action))
    """

    def __init__(
        self,
        seed: int = 1,
        *,
        profile: str = "full",
        curriculum: str = "free",
        settings: Iterable[str] = (),
    ) -> None:
        if isinstance(settings, str):
            settings = [settings]
        self._native = _native.Learner(
            _checked.whole("seed", seed, 0, 2**64 - 1),
            _checked.text("profile", profile),
            _checked.text("curriculum", curriculum),
            _checked.texts("settings", settings),
        )
        self._bodies: dict[str, int] = {}

    @classmethod
    def load(cls, path: Union[str, os.PathLike[str]]) -> Learner:
        """The learner that `save` or ``pschema export`` wrote to ``path``, with its seed, profile and parameters.

        Its bodies declare themselves again, and their first frames answer nothing: an action that was under way is forgotten.

        Raises:
            OSError: the file can't be read.
            Error: it is no export, or is damaged; the line is named.
        """
        learner = cls.__new__(cls)
        learner._native = _native.Learner.load(_checked.path("path", path))
        learner._bodies = {}
        return learner

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes memory to ``path``, as ``pschema export`` does; a file there is replaced once all is written.

        ``pschema import PATH --data DIR`` makes a data directory of it, from which a daemon goes on.

        Raises:
            OSError: it can't be written.
        """
        self._native.save(_checked.path("path", path))

    def declare(self, description: Description) -> None:
        """Takes in what a body declares, before its first step.

        Raises:
            DeclarationError: it contradicts what was learnt, or another body of that name is declared.
        """
        if not isinstance(description, Description):
            raise DeclarationError(f"declare({_checked.shown(description)}): give a pschema.Description, which a body's describe() returns")
        self._bodies[description.name] = self._native.declare(description._plain())

    def step(
        self,
        observations: Iterable[Observation],
        outcome: Optional[Outcome] = None,
        *,
        body: Optional[str] = None,
    ) -> Optional[_native.Action]:
        """One step: what is perceived now goes in, the next action comes out.

        Args:
            observations: all that ``body`` senses now, as `pschema.Body.sense` returns it.
            outcome: how the last action went; none if it was carried out, or if none was asked for.
            body: the name of the body; it can be left out where one is declared.

        Returns:
            The action to carry out, whose outcome goes into the next step; none if there is nothing to do. Under a curriculum that arranges
            the surroundings it may be a scene command: ``action.scene`` is true then.

        Raises:
            FrameError: an observation that was not declared so. Nothing has changed then.
            DeclarationError: there is no such body.
            Error: another thread is using the learner.
        """
        if outcome is not None and not isinstance(outcome, Outcome):
            raise ArgumentError(f"outcome={_checked.shown(outcome)}: give a pschema.Outcome, or nothing where the action was carried out")
        kind, reason = (None, "") if outcome is None else (outcome.kind, outcome.reason)
        try:
            return self._native.step(self._body(body), observations, kind, reason)
        except RuntimeError as error:
            if "borrowed" not in str(error):
                raise
            raise Error("this learner is in use by another thread: it belongs to one at a time") from None

    def _body(self, name: Optional[str]) -> int:
        if name is None and len(self._bodies) == 1:
            return next(iter(self._bodies.values()))
        if name is None and self._bodies:
            raise ArgumentError(f"several bodies are declared, {', '.join(self._bodies)}: say which one is meant")
        return self._bodies.get(name or "", len(self._bodies))

    def say(self, *words: str) -> None:
        """Words are heard, together, in the next step.

        Raises:
            ArgumentError: one of them is no word.
        """
        self._native.say(_checked.texts("words", words))

    def achieve(
        self, *goal: str, again: bool = False, most: Optional[str] = None, actions_max: int = 50, body: Optional[str] = None
    ) -> None:
        """From the next step on a goal is pursued; `pursuit` tells how it is doing, and ``["state"]`` of that how it ended.

        Args:
            goal: patterns as they print, ``"lamp{lit=true}"``; all of them are to hold at once.
            again: that they hold already does not count; they are to be brought about.
            most: instead of patterns, the name of a value of which as much as can be is to come, a reward. That goes on until
                ``actions_max`` actions were taken; ``came`` of `pursuit` is the sum so far.
            actions_max: how many actions may be taken for it; 1 to 100,000.
            body: the name of the body that pursues it; it can be left out where one is declared.

        Raises:
            AnswerError: a pattern that can't be read, a value outside the range that the body declares, or another goal is pursued.
        """
        wanted, actions_max = _checked.wanted(goal, again, most), _checked.whole("actions_max", actions_max, 1)
        self._native.achieve(self._body(body), wanted["goal"], actions_max, again, most)

    def cancel(self) -> None:
        """Calls off the goal that is pursued.

        Raises:
            AnswerError: none is.
        """
        self._native.cancel()

    @property
    def digest(self) -> str:
        """The digest of memory: equal seeds and equal frames give equal digests, here and in a daemon."""
        return self._native.digest()

    @property
    def steps(self) -> int:
        """How many steps memory has taken in its life."""
        return self._native.steps()

    def _asked(self, kind: str, question: dict[str, Any]) -> Any:
        reply = json.loads(self._native.request(json.dumps({"question": {kind: question}}).encode()))
        if "problem" in reply:
            raise AnswerError(reply["problem"])
        return reply["answer"]

    def __repr__(self) -> str:
        bodies: Sequence[str] = list(self._bodies)
        return f"<Learner after {self.steps} steps; bodies {', '.join(bodies) or 'none'}>"
