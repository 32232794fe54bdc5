"""A body whose senses and actions are functions, each of which says beside itself what it senses or does."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Callable, Optional, TypeVar, Union

from . import _native
from .body import Body, Summary, run
from .declare import ActionType, Description, Observation, Outcome, Sense, Value, Values, action, event, state, value
from .errors import DeclarationError

__all__ = ["FunctionBody"]

F = TypeVar("F", bound=Callable[..., Any])


class FunctionBody(Body):
    """A body in functions: decorators say what they are.

    A lamp::

        lamp, lit = pschema.FunctionBody("lamp"), False

        @lamp.state(lit=pschema.boolean())
        def light():
            return {"lit": lit}

        @lamp.action()
        def press():
            global lit
            lit = not lit

        lamp.run()

    A sense or an action is called as its function is; ``name=`` says otherwise. Declarations are checked when the body runs, or when
    `describe` is called.

    Args:
        name: of the body.
        kind: of the body, for people; the name unless given.
    """

    def __init__(self, name: str, *, kind: Optional[str] = None) -> None:
        self.name = name
        self.kind = kind
        self._senses: dict[str, tuple[Sense, Callable[[], Any]]] = {}
        self._actions: dict[str, tuple[ActionType, Callable[..., Optional[Outcome]]]] = {}
        self._picture: Optional[Callable[[], Any]] = None

    def state(
        self, properties: Optional[Mapping[str, Values]] = None, *, name: Optional[str] = None, own: bool = False, **named: Values
    ) -> Callable[[F], F]:
        """What the function returns holds until it changes. It takes no arguments, and is called once before each decision.

        It returns the values, as a dict or a tuple; or nothing while there is nothing to sense. A generator yields any number of such.
        Where there are no properties it returns whether it is so. ``properties`` and ``own`` are as `pschema.state` takes them.
        """
        return self._sense(name, lambda called: state(called, properties, own=own, **named))

    def event(
        self, properties: Optional[Mapping[str, Values]] = None, *, name: Optional[str] = None, own: bool = False, **named: Values
    ) -> Callable[[F], F]:
        """What the function returns holds for the one frame that reports it; otherwise it is as `state`."""
        return self._sense(name, lambda called: event(called, properties, own=own, **named))

    def value(
        self, properties: Optional[Mapping[str, Values]] = None, *, name: Optional[str] = None, own: bool = False, **named: Values
    ) -> Callable[[F], F]:
        """The decorated function tells a value, a number that comes with the frame: a reward. See `pschema.value`."""
        return self._sense(name, lambda called: value(called, properties, own=own, **named))

    def _sense(self, name: Optional[str], declare: Callable[[str], Sense]) -> Callable[[F], F]:
        def decorate(function: F) -> F:
            declared = declare(name or function.__name__)
            _once(self._senses, declared.name, "sense")
            self._senses[declared.name] = (declared, function)
            return function

        return decorate

    def action(
        self,
        parameters: Optional[Mapping[str, Values]] = None,
        *,
        name: Optional[str] = None,
        primitives: Optional[Iterable[Union[Mapping[str, Value], Sequence[Value]]]] = None,
        **named: Values,
    ) -> Callable[[F], F]:
        """The function carries the action out; it takes its parameters by their names, and returns what `Body.act` does."""

        def decorate(function: F) -> F:
            declared = action(name or function.__name__, parameters, primitives=primitives, **named)
            _once(self._actions, declared.name, "action")
            try:
                inspect.signature(function).bind(**dict.fromkeys(declared.parameters))
            except TypeError as wrong:
                raise DeclarationError(f"action {declared.name}: {function.__name__}() does not take its parameters: {wrong}") from None
            self._actions[declared.name] = (declared, function)
            return function

        return decorate

    def seen(self, function: F) -> F:
        """The function returns what `Body.picture` does."""
        self._picture = function
        return function

    def run(self, name: Optional[str] = None, **options: Any) -> Summary:
        """Runs it, as `pschema.run` does."""
        return run(self, name, **options)

    def describe(self) -> Description:
        senses = [sense for sense, _ in self._senses.values()]
        return Description(self.name, senses, [declared for declared, _ in self._actions.values()], kind=self.kind)

    def sense(self) -> Iterator[Observation]:
        for name, (declared, function) in self._senses.items():
            told = function()
            if inspect.isgenerator(told):
                values: Any
                for values in told:
                    yield name, values
            elif not declared.properties:
                if told:
                    yield name
            elif told is not None:
                yield name, told

    def act(self, action: _native.Action) -> Optional[Outcome]:
        return self._actions[action.name][1](**action.parameters)

    def picture(self) -> Any:
        return None if self._picture is None else self._picture()


def _once(known: Mapping[str, Any], name: str, what: str) -> None:
    if name in known:
        raise DeclarationError(f"{what} {name} is declared twice: give one of them another name=")
