"""What a body declares of itself: its senses, its actions, and the values that they have.

Mistakes are found where the declaration is made, and are named with their place::

    >>> import pschema
    >>> pschema.Description("lamp", senses=[pschema.state("lamp", lit=pschema.integer(9, 0))])
    Traceback (most recent call last):
    pschema.errors.DeclarationError: observation type lamp: property lit: its minimum 9 is above its maximum 0
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

from . import _checked, _native
from .errors import DeclarationError

__all__ = [
    "ActionType",
    "Description",
    "Observation",
    "Outcome",
    "Sense",
    "Value",
    "Values",
    "action",
    "boolean",
    "event",
    "integer",
    "real",
    "state",
    "symbol",
    "value",
]

#: A value of a property, or of a parameter.
Value = Union[int, str, bool, float]

#: One observation: the name of a sense, with the values of its properties by name or in declared order; or the name alone.
Observation = Union[str, tuple[str], tuple[str, Mapping[str, Any]], tuple[str, Sequence[Any]]]


@dataclass(frozen=True)
class Values:
    """The values that a property or a parameter has. `integer`, `symbol`, `boolean` and `real` make it."""

    kind: str
    of_kind: tuple[Any, ...] = ()
    unit: str = ""


def _is_integer(given: object) -> bool:
    return hasattr(given, "__index__") and not isinstance(given, bool)


def _text(place: str, given: object) -> str:
    """A name, a unit or a symbol, which may be any text that can be sent."""
    if not isinstance(given, str):
        raise DeclarationError(f"{place}: {_checked.shown(given)} is no text")
    if any("\ud800" <= letter <= "\udfff" for letter in given):
        raise DeclarationError(f"{place}: {_checked.shown(given)} holds half of a character, which can't be sent")
    return given


def integer(least: int, most: int, *, unit: str = "") -> Values:
    """A whole number from ``least`` to ``most``, both included and within 64 bits.

    Raises:
        DeclarationError: when they are no whole numbers. That ``least`` is above ``most`` is said where the property gets its name.
    """
    for given in (least, most):
        if not _is_integer(given):
            raise DeclarationError(f"integer({least!r}, {most!r}): {given!r} is no whole number")
        if not -(2**63) <= int(given) < 2**63:
            raise DeclarationError(f"integer({least!r}, {most!r}): {given!r} does not fit into 64 bits")
    return Values("integer", (int(least), int(most)), _text(f"integer({least!r}, {most!r}): its unit", unit))


def symbol(*symbols: str, unit: str = "") -> Values:
    """One of ``symbols``, which are texts of at most 32 bytes; a body has at most 512 of them in all.

    Raises:
        DeclarationError: when one is no text.
    """
    for given in symbols:
        if not isinstance(given, str):
            raise DeclarationError(f"symbol(): {given!r} is no text; give each symbol as one argument")
        _text("symbol()", given)
    return Values("symbol", (list(symbols),), _text("symbol(): its unit", unit))


def boolean() -> Values:
    """``True`` or ``False``."""
    return Values("boolean")


def real(least: float, most: float, resolution: float, *, unit: str = "") -> Values:
    """A finite number from ``least`` to ``most``, in ``unit``.

    ``resolution`` is the width of the bins in which it is compared and learnt, in the same unit: numbers less than about that far apart are
    the same to the learner.

    Raises:
        DeclarationError: when one of them is no number.
    """
    place, numbers = f"real({least!r}, {most!r}, {resolution!r})", []
    for given in (least, most, resolution):
        if isinstance(given, (bool, str, bytes)):
            raise DeclarationError(f"{place}: {given!r} is no number")
        try:
            numbers.append(float(given))
        except (TypeError, ValueError, OverflowError):
            raise DeclarationError(f"{place}: {_checked.shown(given)} is no number") from None
    return Values("real", tuple(numbers), _text(f"{place}: its unit", unit))


def _properties(of: str, given: Optional[Mapping[str, Values]], named: Mapping[str, Values]) -> dict[str, Values]:
    if given is not None and not isinstance(given, Mapping):
        raise DeclarationError(f"{of}: {_checked.shown(given)} is no dict; give properties by name, or in a dict from names to values")
    both = {**(given or {}), **named}
    if given and len(both) != len(given) + len(named):
        raise DeclarationError(f"{of}: a property is given twice, in the dict and by its name")
    for name, values in both.items():
        if not isinstance(name, str):
            raise DeclarationError(f"{of}: {name!r} is no name of a property")
        if not isinstance(values, Values):
            raise DeclarationError(
                f"{of}: property {name}: {values!r} says nothing of its values; give integer(…), symbol(…), boolean() or real(…)"
            )
    return both


@dataclass(frozen=True)
class Sense:
    """A sense of a body: one type of observation. `state`, `event` and `value` make it."""

    name: str
    properties: Mapping[str, Values]
    own: bool = False
    transient: bool = False
    value: bool = False


def state(name: str, properties: Optional[Mapping[str, Values]] = None, *, own: bool = False, **named: Values) -> Sense:
    """A sense of something that holds as long as frames report it: where a thing is, what colour it has.

    ``own`` says that the body itself causes it, as where its own finger is seen: such an observation is an effect of actions and,
    unless the learner is told otherwise, never a condition. Properties are given by their names, or in a dict where a name is no
    Python name. A property of one name is comparable in all senses of all bodies, so it has one kind everywhere, and a real one
    resolution.
    """
    return _sense("state", name, properties, named, own=own, transient=False)


def event(name: str, properties: Optional[Mapping[str, Values]] = None, *, own: bool = False, **named: Values) -> Sense:
    """A sense of what holds for the one frame that reports it: a touch, a sound. It is otherwise as `state`."""
    return _sense("event", name, properties, named, own=own, transient=True)


def value(name: str, properties: Optional[Mapping[str, Values]] = None, *, own: bool = False, **named: Values) -> Sense:
    """A number that comes with a frame and may be wanted: a reward, a cost, a score.

    It has one property, `integer` or `real`. The learner does not live by it: what it does is the same with it and without it. But it
    foretells it, and ``achieve(most=NAME)`` brings as much of it as can be.

        >>> value("reward", reward=real(-1, 1, 0.01)).value
        True
    """
    return _sense("value", name, properties, named, own=own, transient=True, value=True)


def _sense(
    maker: str,
    name: str,
    properties: Optional[Mapping[str, Values]],
    named: Mapping[str, Values],
    *,
    own: bool,
    transient: bool,
    value: bool = False,
) -> Sense:
    _text(f"{maker}(): the name of a sense", name)
    if not isinstance(own, bool):
        raise DeclarationError(f"sense {name}: own={_checked.shown(own)}: give True or False")
    return Sense(name, _properties(f"sense {name}", properties, named), own, transient, value)


@dataclass(frozen=True)
class ActionType:
    """An action that a body can carry out, or a scene command that it obeys. `action` makes it."""

    name: str
    parameters: Mapping[str, Values]
    primitives: Optional[Sequence[Union[Mapping[str, Value], Sequence[Value]]]] = None


def action(
    name: str,
    parameters: Optional[Mapping[str, Values]] = None,
    *,
    primitives: Optional[Iterable[Union[Mapping[str, Value], Sequence[Value]]]] = None,
    **named: Values,
) -> ActionType:
    """An action, with its parameters as `state` takes properties.

    ``primitives`` are the combinations of parameters that the learner may ask for, each a dict or a tuple in declared order; without it,
    each combination that the learner tells apart. A body has at most 4096 of them in all.
    """
    _text("action(): the name of an action", name)
    if primitives is not None and (isinstance(primitives, (str, bytes)) or not isinstance(primitives, Iterable)):
        raise DeclarationError(f"action {name}: primitives={_checked.shown(primitives)}: give a list, of a dict or a tuple for each")
    listed = None if primitives is None else list(primitives)
    return ActionType(name, _properties(f"action {name}", parameters, named), listed)


@dataclass(frozen=True)
class Outcome:
    """How an action went, for `pschema.Body.act` to return; ``None`` is the same as `done`.

    Only what was done teaches what an action does. ``reason`` is for people, and is cut after 256 bytes.
    """

    kind: str
    reason: str = ""

    @classmethod
    def done(cls) -> Outcome:
        """Carried out."""
        return cls("done")

    @classmethod
    def refused(cls, reason: str) -> Outcome:
        """Not begun, for a reason that lies in the order itself: a place that cannot be reached. One that is refused is chosen less."""
        return cls("refused", _plain_text(reason))

    @classmethod
    def failed(cls, reason: str) -> Outcome:
        """Begun and not completed, which is a fault of the body. An exception in ``act`` is the same."""
        return cls("failed", _plain_text(reason))

    @classmethod
    def timed_out(cls) -> Outcome:
        """Not completed in the time that the body allows."""
        return cls("timed-out")

    @classmethod
    def episode_ended(cls) -> Outcome:
        """Not carried out: the episode had ended, and this frame begins a new one."""
        return cls("episode-ended")

    @classmethod
    def episode_cut(cls) -> Outcome:
        """Not carried out: the episode was cut off from outside, and this frame begins a new one."""
        return cls("episode-cut")


def _plain_text(reason: object) -> str:
    """What is given as a reason, as text that can be sent."""
    return str(reason).encode("utf-8", "backslashreplace").decode()


def _plain_properties(properties: Mapping[str, Values]) -> list[tuple[str, str, str, tuple[Any, ...]]]:
    return [(name, values.unit, values.kind, values.of_kind) for name, values in properties.items()]


def _plain_primitives(declared: ActionType) -> Optional[list[list[Any]]]:
    if declared.primitives is None:
        return None
    plain: list[list[Any]] = []
    for number, given in enumerate(declared.primitives):
        place = f"action {declared.name}: primitive {number}"
        if isinstance(given, Mapping):
            if set(given) != set(declared.parameters):
                wanted = ", ".join(declared.parameters)
                raise DeclarationError(f"{place}: {dict(given)!r} should have the parameters {wanted}, and no others")
            plain.append([given[name] for name in declared.parameters])
        elif isinstance(given, str) or not isinstance(given, Iterable):
            raise DeclarationError(f"{place}: {given!r} is neither a dict nor a tuple of parameters")
        else:
            plain.append(list(given))
    return plain


def _plain_actions(declared: Iterable[ActionType]) -> list[tuple[str, list[Any], Optional[list[list[Any]]]]]:
    return [(one.name, _plain_properties(one.parameters), _plain_primitives(one)) for one in declared]


class Description:
    """What a body is: its ``name``, by which it comes back and goes on, its ``kind`` for people, and what it senses and can do.

    Args:
        name: of the body; at most 32 bytes, as all names here.
        senses: at most 32, each with at most 8 properties.
        actions: at most 16, each with at most 8 parameters.
        scene_commands: actions by which a curriculum may arrange the body's surroundings; at most 16.
        kind: of the body, for people; the name unless given.

    Raises:
        DeclarationError: the first thing that is not allowed, with its place.
    """

    def __init__(
        self,
        name: str,
        senses: Iterable[Sense] = (),
        actions: Iterable[ActionType] = (),
        scene_commands: Iterable[ActionType] = (),
        *,
        kind: Optional[str] = None,
    ) -> None:
        self.name = _text("the body's name", name)
        self.kind = name if kind is None else _text("the body's kind", kind)
        for what, given in (("senses", senses), ("actions", actions), ("scene_commands", scene_commands)):
            if not isinstance(given, Iterable):
                raise DeclarationError(f"{what}={_checked.shown(given)}: give a list of them")
        self.senses = tuple(senses)
        self.actions = tuple(actions)
        self.scene_commands = tuple(scene_commands)
        for what, listed, sort in (
            ("senses", self.senses, Sense),
            ("actions", self.actions, ActionType),
            ("scene_commands", self.scene_commands, ActionType),
        ):
            for number, one in enumerate(listed):
                if not isinstance(one, sort):
                    makers = "state(…), event(…) or value(…)" if sort is Sense else "action(…)"
                    raise DeclarationError(f"{what}[{number}]: {one!r} is none of them; give {makers}")
                _text(f"{what}[{number}]: its name", one.name)
        try:
            _native.check(self._plain())
        except DeclarationError:
            raise
        except (TypeError, ValueError, OverflowError) as wrong:
            # Made by hand, without the functions that look at each part.
            raise DeclarationError(f"the description of {self.name}: {wrong}") from wrong

    @classmethod
    def _of(cls, plain: _native.PlainDescription) -> Description:
        """That of a body which is written in Rust."""
        name, kind, senses, actions, scene_commands = plain

        def properties(given: list[Any]) -> dict[str, Values]:
            return {name: Values(kind, of_kind, unit) for name, unit, kind, of_kind in given}

        def action_types(given: list[Any]) -> list[ActionType]:
            return [ActionType(name, properties(parameters), primitives) for name, parameters, primitives in given]

        declared = [Sense(name, properties(of), own, transient, value) for name, own, transient, value, of in senses]
        return cls(name, declared, action_types(actions), action_types(scene_commands), kind=kind)

    def _plain(self) -> _native.PlainDescription:
        senses = [(one.name, one.own, one.transient, one.value, _plain_properties(one.properties)) for one in self.senses]
        return self.name, self.kind, senses, _plain_actions(self.actions), _plain_actions(self.scene_commands)

    def __repr__(self) -> str:
        senses = ", ".join(one.name for one in self.senses)
        actions = ", ".join(one.name for one in self.actions)
        return f"<Description {self.name}: senses {senses}; actions {actions}>"
