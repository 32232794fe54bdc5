"""Arguments, looked at before they go anywhere: what is wrong with one is said by the names of the function and of the argument."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Iterable
from typing import Any, Optional

from .errors import ArgumentError

__all__ = ["choice", "number", "path", "shown", "text", "texts", "whole"]

#: The longest value that is told whole, in characters.
_SHOWN_MAX = 80
#: The most that a whole number may be where nothing else limits it: it travels in so many bits.
_WHOLE_MAX = 2**32 - 1


def shown(given: object) -> str:
    """What was given, for people: cut where it is long, and never an exception."""
    try:
        told = ascii(given) if isinstance(given, str) and _surrogate(given) else repr(given)
    except Exception:
        return f"a {type(given).__name__}"
    return told if len(told) <= _SHOWN_MAX else f"{told[:_SHOWN_MAX]}…"


def _surrogate(given: str) -> Optional[str]:
    return next((letter for letter in given if "\ud800" <= letter <= "\udfff"), None)


def _refused(place: str, given: object, wanted: str) -> ArgumentError:
    return ArgumentError(f"{place}={shown(given)}: give {wanted}")


def whole(place: str, given: Any, least: int = 0, most: int = _WHOLE_MAX) -> int:
    """A whole number from ``least`` to ``most``; numpy's are taken too."""
    try:
        told = None if isinstance(given, bool) else operator.index(given)
    except TypeError:
        told = None
    if told is None or not least <= told <= most:
        ends = most < _WHOLE_MAX or (told is not None and told > most)
        raise _refused(place, given, f"a whole number from {least}" + (f" to {most:,}" if ends else ""))
    return told


def number(place: str, given: Any, least: float = 0.0, *, above: bool = False) -> float:
    """A finite number from ``least``, or above it."""
    wanted = f"a finite number {'above' if above else 'from'} {least:g}"
    if isinstance(given, (bool, str, bytes)):
        raise _refused(place, given, wanted)
    try:
        told = float(given)
    except (TypeError, ValueError, OverflowError):
        raise _refused(place, given, wanted) from None
    if not math.isfinite(told) or told < least or (above and told == least):
        raise _refused(place, given, wanted)
    return told


def text(place: str, given: Any) -> str:
    """A text that can be sent."""
    if not isinstance(given, str):
        raise _refused(place, given, "a text")
    lone = _surrogate(given)
    if lone is not None:
        raise ArgumentError(f"{place}={shown(given)}: leave out U+{ord(lone):04X}, which is half of a character and can't be sent")
    return given


def texts(place: str, given: Iterable[Any]) -> list[str]:
    """Texts that can be sent."""
    return [text(f"{place}[{at}]", one) for at, one in enumerate(given)]


def wanted(goal: Iterable[Any], again: Any, most: Any) -> dict[str, Any]:
    """What is wanted: patterns, or most of a value."""
    if not isinstance(again, bool):
        raise _refused("again", again, "True or False")
    told: dict[str, Any] = {"goal": texts("goal", goal)}
    # What is not asked for is left out, so that an older daemon understands the rest.
    if again:
        told["again"] = True
    if most is not None:
        told["most"] = text("most", most)
    return told


def path(place: str, given: Any) -> str:
    """The path of a file."""
    if not isinstance(given, (str, os.PathLike)):
        raise _refused(place, given, "the path of a file")
    return text(place, os.fspath(given))


def choice(place: str, given: Any, among: Iterable[str]) -> str:
    """One of these."""
    if not isinstance(given, str) or given not in among:
        raise _refused(place, given, f"one of {', '.join(among)}")
    return given
