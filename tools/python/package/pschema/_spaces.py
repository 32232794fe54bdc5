"""What the spaces of Gymnasium are to a learner: the senses of an observation, the actions of an action space."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Optional

import numpy
from gymnasium import spaces

from . import _checked, _native
from .declare import ActionType, Observation, Sense, Values, action, boolean, integer, real, state, symbol
from .errors import DeclarationError
from .table import Table

__all__ = ["BINS", "Acts", "Part", "Perform", "Read", "acts", "acts_of", "as_name", "senses_of"]

#: How many bins a real is learnt in, between its bounds.
BINS = 20
#: How many values an action that is a real has.
ACTION_BINS = 5
#: How many numbers a box may have: more are an image, or should be one thing each.
BOX_MAX = 24
#: Bounds that are further apart say nothing of a number.
WIDE = 1e6
#: How many actions a random episode has that is looked at for what values there are.
SAMPLED = 200
#: The seed of these.
SAMPLED_SEED = 0
#: How many words of texts are told apart.
WORDS_MAX = 64


#: What the actions, and the numbers, of well-known environments are called; where they are not here they are numbered.
_ACTIONS: dict[str, tuple[str, ...]] = {
    "FrozenLake": ("left", "down", "right", "up"),
    "FrozenLake8x8": ("left", "down", "right", "up"),
    "CliffWalking": ("up", "right", "down", "left"),
    "Taxi": ("south", "north", "east", "west", "pick-up", "drop-off"),
    "Blackjack": ("stick", "hit"),
    "CartPole": ("push-left", "push-right"),
    "MountainCar": ("push-left", "coast", "push-right"),
    "Acrobot": ("push-left", "coast", "push-right"),
}
_OBSERVATIONS: dict[str, tuple[str, ...]] = {
    "FrozenLake": ("field",),
    "FrozenLake8x8": ("field",),
    "CliffWalking": ("field",),
    "Blackjack": ("sum", "dealer", "ace"),
    "CartPole": ("x", "speed", "angle", "turning"),
    "MountainCar": ("x", "speed"),
    "MountainCarContinuous": ("x", "speed"),
    "Pendulum": ("cosine", "sine", "turning"),
    "Acrobot": ("cosine-1", "sine-1", "cosine-2", "sine-2", "turning-1", "turning-2"),
}

Read = Callable[[Any], Iterable[Observation]]
Perform = Callable[[_native.Action], Any]


def as_name(name: object) -> str:
    """A name as a body may declare it."""
    return re.sub(r"[{}(),=$\s]+", "-", str(name)).strip("-")[:32] or "state"


@dataclass
class Part:
    """Some senses, and how an observation of the environment is put into them."""

    senses: list[Sense]
    read: Read


def _one(name: str, values: Values, convert: Callable[[Any], Any]) -> Part:
    return Part([state(name, {name: values})], lambda seen: [(name, (convert(seen),))])


def _all(parts: Sequence[Part], split: Callable[[Any], Iterable[Any]]) -> Part:
    def read(seen: Any) -> Iterator[Observation]:
        for part, of_part in zip(parts, split(seen)):
            yield from part.read(of_part)

    return Part([sense for part in parts for sense in part.senses], read)


def _whole(name: str, least: int, count: int) -> Part:
    return _one(name, integer(least, least + count - 1), int)


def _reals(name: str, low: float, high: float, seen: Sequence[float], bins: int) -> tuple[Values, Callable[[Any], float]]:
    """The values of a number between bounds; where there are none, between twice those that were seen."""
    if not high - low <= WIDE:
        least, most = (min(seen), max(seen)) if seen else (-1.0, 1.0)
        middle, half = (least + most) / 2, max(most - least, 1e-3)
        low = low if math.isfinite(low) and low > middle - half else middle - half
        high = high if math.isfinite(high) and high < middle + half else middle + half
    width = (high - low) / bins
    if width <= 0:
        width = 1.0
    return real(low, high, width), lambda given: min(max(float(given), low), high)


def _box(name: str, space: Any, samples: Sequence[Any], names: Sequence[str], bins: int) -> Part:
    count = int(numpy.prod(space.shape, dtype=int))
    if count > BOX_MAX:
        shape = "×".join(map(str, space.shape))
        kind = "an image" if len(space.shape) >= 2 else "a list"
        raise DeclarationError(
            f"{name}: it is {kind} of {shape} numbers, and at most {BOX_MAX} are taken one by one: what is learnt is about things with "
            "properties. Wrap the environment so that it tells things, or give attach() senses= and observe=, a function from an "
            "observation to what is sensed in it"
        )
    low, high = space.low.reshape(-1), space.high.reshape(-1)
    seen = [numpy.asarray(sample).reshape(-1) for sample in samples]
    parts = []
    for at in range(count):
        own = names[at] if at < len(names) else (name if count == 1 else f"{name}-{at}")
        if numpy.issubdtype(space.dtype, numpy.integer) and int(high[at]) - int(low[at]) < 1 << 20:
            parts.append(_whole(own, int(low[at]), int(high[at]) - int(low[at]) + 1))
        else:
            values, convert = _reals(own, float(low[at]), float(high[at]), [float(one[at]) for one in seen], bins)
            parts.append(_one(own, values, convert))
    return _all(parts, lambda given: numpy.asarray(given).reshape(-1))


def _text(name: str, samples: Sequence[Any]) -> Part:
    """The words of a text, each an observation; words that every text has say nothing."""

    def words(text: Any) -> list[str]:
        return sorted({as_name(word) for word in str(text).lower().split()})

    told = [set(words(text)) for text in samples]
    always = set.intersection(*told) if told else set()
    known = sorted(set().union(*told) - always)[:WORDS_MAX]
    if not known:
        return Part([], lambda _: [])
    senses = [state(name, {"word": symbol(*known, "other")})]

    def read(text: Any) -> Iterator[Observation]:
        told = {word if word in known else "other" for word in words(text) if word not in always}
        yield from ((name, (word,)) for word in sorted(told))

    return Part(senses, read)


def _space(name: str, space: Any, samples: Sequence[Any], names: Sequence[str], bins: int) -> Part:
    """The senses of a space; `samples` are observations of it that were made."""
    if isinstance(space, spaces.Discrete):
        return _whole(names[0] if names else name, int(space.start), int(space.n))
    if isinstance(space, (spaces.MultiDiscrete, spaces.MultiBinary)):
        if math.prod(space.shape) > BOX_MAX:
            raise DeclarationError(f"{name}: it has {math.prod(space.shape)} numbers, and at most {BOX_MAX} are taken one by one")
        if isinstance(space, spaces.MultiBinary):
            parts = [_one(f"{name}-{at}", boolean(), bool) for at in range(math.prod(space.shape))]
        else:
            counts, starts = space.nvec.reshape(-1), space.start.reshape(-1)
            parts = [_whole(f"{name}-{at}", int(start), int(count)) for at, (start, count) in enumerate(zip(starts, counts))]
        return _all(parts, lambda given: numpy.asarray(given).reshape(-1))
    if isinstance(space, spaces.Tuple):
        parts = []
        for at, one in enumerate(space.spaces):
            own = names[at] if at < len(names) else f"{name}-{at}"
            parts.append(_space(own, one, [sample[at] for sample in samples], (), bins))
        return _all(parts, lambda given: given)
    if isinstance(space, spaces.Dict):
        keys = list(space.spaces)
        parts = []
        for key in keys:
            own = as_name(key) if name == "state" else as_name(f"{name}-{key}")
            parts.append(_space(own, space[key], [sample[key] for sample in samples], (), bins))
        return _all(parts, lambda given: [given[key] for key in keys])
    if isinstance(space, spaces.Box):
        return _box(name, space, samples, names, bins)
    if isinstance(space, spaces.Text) or (samples and all(isinstance(sample, str) for sample in samples)):
        return _text(name, samples)
    raise DeclarationError(
        f"{name}: nothing is known of a space {type(space).__name__}: give attach() senses= and observe=, a function from an observation "
        "to what is sensed in it"
    )


def _is_minigrid(env: Any) -> bool:
    """Whether it shows what MiniGrid shows without wrappers: what is in each field of its view, by three numbers."""
    space = env.observation_space
    image = space.spaces.get("image") if isinstance(space, spaces.Dict) else None
    is_view = isinstance(image, spaces.Box) and len(image.shape) == 3 and image.shape[2] == 3 and image.shape[0] <= 15
    return is_view and any(kind.__name__ == "MiniGridEnv" for kind in type(env.unwrapped).__mro__)


def _minigrid(space: Any, samples: Sequence[Any], bins: int) -> Part:
    """What a MiniGrid environment shows: things in sight, where they are from the agent, and what it carries."""
    from minigrid.core.constants import IDX_TO_COLOR, IDX_TO_OBJECT, STATE_TO_IDX

    width, height, _ = space["image"].shape
    sides, aheads = integer(-(width // 2), width // 2, unit="fields"), integer(0, height - 1, unit="fields")
    colours = symbol(*sorted(set(IDX_TO_COLOR.values())))
    things = ("ball", "box", "goal", "key", "lava", "agent")
    door = {state: name for name, state in STATE_TO_IDX.items()}
    place = {"ahead": aheads, "side": sides}
    senses = [
        state("thing", {"thing": symbol(*things), "colour": colours, **place}),
        state("door", {"door": symbol(*door.values()), "colour": colours, **place}),
        state("wall", place),
        state("carried", {"thing": symbol(*things), "colour": colours}, own=True),
    ]

    def image(seen: Any) -> Iterator[Observation]:
        for column in range(width):
            for row in range(height):
                kind, colour, status = (int(number) for number in seen[column, row])
                name = IDX_TO_OBJECT[kind]
                where = (height - 1 - row, column - width // 2)
                if where == (0, 0):
                    if name in things:
                        yield "carried", (name, IDX_TO_COLOR[colour])
                elif name == "wall":
                    yield "wall", where
                elif name == "door":
                    yield "door", (door[status], IDX_TO_COLOR[colour], *where)
                elif name in things:
                    yield "thing", (name, IDX_TO_COLOR[colour], *where)

    parts, keys = [Part(senses, image)], ["image"]
    for key in space.spaces:
        if key != "image":
            parts.append(_space(as_name(key), space[key], [sample[key] for sample in samples], (), bins))
            keys.append(key)
    return _all(parts, lambda given: [given[key] for key in keys])


def _taxi(env: Any) -> Part:
    """A taxi's number stands for four things, which its own code tells apart."""
    counts = {"row": 5, "column": 5, "passenger": 5, "destination": 4}
    return _all([_whole(name, 0, count) for name, count in counts.items()], lambda given: env.unwrapped.decode(int(given)))


@dataclass
class Acts:
    """The actions, and what each is to the environment."""

    actions: list[ActionType]
    put: Perform


def acts(env: Any, known: str) -> Acts:
    """The actions of an environment, which is ``known`` under this name."""
    if isinstance(env.unwrapped, Table):
        numbers = {meaning: number for number, meaning in enumerate(env.unwrapped.meanings)}
        return Acts(list(env.unwrapped.description.actions), lambda asked: numbers[asked])
    space = env.action_space
    if isinstance(space, spaces.Discrete) and space.n <= 16:
        start, count = int(space.start), int(space.n)
        meanings = getattr(env.unwrapped, "get_action_meanings", None)
        named: Iterable[object] = [f"action-{at}" for at in range(count)]
        if known in _ACTIONS and len(_ACTIONS[known]) == count:
            named = _ACTIONS[known]
        elif len(getattr(env.unwrapped, "actions", ())) == count:
            # The enumeration that MiniGrid's environments have.
            named = [getattr(one, "name", one) for one in env.unwrapped.actions]
        elif callable(meanings):
            named = [str(meaning).lower() for meaning in meanings()]
        names = [as_name(name) for name in named]
        places = {name: start + at for at, name in enumerate(names)}
        return Acts([action(name) for name in names], lambda asked: places[asked.name])
    parameters: dict[str, Values] = {}
    try:
        build = _parameters("act" if not isinstance(space, spaces.Dict) else "", space, parameters)
    except _OwnActionsError as wanted:
        raise DeclarationError(f"the action space {_brief(space)}: {wanted}. {_OWN_ACTIONS}") from None
    counts = [_count(values) for values in parameters.values()]
    if len(counts) > _native.PROPERTIES_MAX:
        told = f"an action of it has {len(counts)} numbers, and an action of a body at most {_native.PROPERTIES_MAX} parameters"
        raise DeclarationError(f"the action space {_brief(space)}: {told}. {_OWN_ACTIONS}")
    if math.prod(counts) > _native.PRIMITIVES_MAX:
        product = " × ".join(map(str, counts)) + " = " if len(counts) > 1 else ""
        told = f"it has {product}{math.prod(counts):,} actions{_cut(space)}, and a body at most {_native.PRIMITIVES_MAX:,}"
        raise DeclarationError(f"the action space {_brief(space)}: {told}. {_OWN_ACTIONS}")
    return Acts([action("act", parameters)], lambda asked: build(asked.parameters))


#: The way out where an action space can't be taken as it is.
_OWN_ACTIONS = (
    'Give attach() actions=, which says by name what may be done and what each is to the environment, as {"left": 0, "right": 3}, or '
    "actions= and perform=, a function from what is asked for to an action of the environment"
)


class _OwnActionsError(Exception):
    """An action space that can't be taken as it is."""


def _brief(space: Any) -> str:
    """A space as it prints; what its bounds are in each place is left out where that is long."""
    return " ".join(_checked.shown(space).split())


def _count(values: Values) -> int:
    """How many values are told apart."""
    if values.kind == "integer":
        least, most = values.of_kind
        return int(most - least + 1)
    if values.kind == "real":
        least, most, resolution = values.of_kind
        widths: float = (most - least) / resolution
        return round(widths) + 1
    return len(values.of_kind[0]) if values.kind == "symbol" else 2


def _cut(space: Any) -> str:
    """What is to be said of a space that has reals."""
    parts = space.spaces.values() if isinstance(space, spaces.Dict) else space.spaces if isinstance(space, spaces.Tuple) else [space]
    return f", each real in {ACTION_BINS} values" if any(isinstance(part, spaces.Box) for part in parts) else ""


def acts_of(env: Any, actions: object, perform: Optional[Perform]) -> Acts:
    """The actions that somebody says for an environment: by name, each with what it is there; or declared, with a function."""
    if isinstance(actions, Mapping):
        if perform is not None:
            raise DeclarationError("perform= is for actions= that are declared: a dict says by itself what each action is")
        return _named(env.action_space, actions)
    if actions is None or perform is None:
        raise DeclarationError(
            "give actions= as a dict from names to actions of the environment; or actions= as a list of pschema.action(…), and perform=, a "
            "function from what is asked for to an action of the environment"
        )
    if isinstance(actions, (str, bytes)) or not isinstance(actions, Iterable):
        raise DeclarationError(f"actions={_checked.shown(actions)}: give a dict from names to actions, or a list of pschema.action(…)")
    if not callable(perform):
        raise DeclarationError(f"perform={_checked.shown(perform)}: give a function from what is asked for to an action of the environment")
    return Acts(list(actions), perform)


def _named(space: Any, actions: Mapping[Any, Any]) -> Acts:
    """Actions by their names; where a body can't have so many, one with the names as its parameter."""
    if not actions:
        raise DeclarationError("actions={}: give at least one action")
    meanings: dict[str, Any] = {}
    for name, given in actions.items():
        if not isinstance(name, str):
            raise DeclarationError(f"actions: {_checked.shown(name)} is no name")
        meanings[name] = _as_action(space, given)
        if not space.contains(meanings[name]):
            told = f"{_checked.shown(given)} ({type(given).__name__})"
            raise DeclarationError(f"actions[{name!r}]: {told} is no action of the environment, whose action space is {_brief(space)}")
    # The environment may change what it is given.
    if len(actions) <= _native.ACTIONS_MAX:
        return Acts([action(name) for name in actions], lambda asked: copy.deepcopy(meanings[asked.name]))
    if len(actions) > _native.SYMBOLS_MAX:
        raise DeclarationError(
            f"actions: {len(actions):,} are named, and at most {_native.SYMBOLS_MAX} can be: declare some with parameters instead, and "
            "give perform=, a function from what is asked for to an action of the environment"
        )
    return Acts([action("act", do=symbol(*actions))], lambda asked: copy.deepcopy(meanings[asked["do"]]))


def _as_action(space: Any, given: Any) -> Any:
    """What somebody wrote for an action, with the type of number that the space has."""
    if isinstance(space, (spaces.Box, spaces.MultiDiscrete, spaces.MultiBinary)):
        try:
            numbers = numpy.asarray(given)
            whole = numpy.issubdtype(space.dtype, numpy.integer)
            # Where whole numbers are wanted, a fraction is none of them.
            return numbers.astype(space.dtype, casting="same_kind" if whole else "unsafe") if numbers.shape == space.shape else given
        except (TypeError, ValueError, OverflowError):
            return given
    return given


def _parameters(name: str, space: Any, to: dict[str, Values]) -> Callable[[Mapping[str, Any]], Any]:
    """Adds the parameters of an action space, and returns what makes an action of their values."""
    if isinstance(space, spaces.Discrete):
        to[name] = integer(int(space.start), int(space.start + space.n - 1))
        return lambda given: given[name]
    if isinstance(space, spaces.Tuple):
        builds = [_parameters(f"{name}-{at}", one, to) for at, one in enumerate(space.spaces)]
        return lambda given: tuple(build(given) for build in builds)
    if isinstance(space, spaces.Dict):
        made = {key: _parameters(as_name(f"{name}-{key}" if name else key), one, to) for key, one in space.spaces.items()}
        return lambda given: {key: build(given) for key, build in made.items()}
    if isinstance(space, (spaces.MultiDiscrete, spaces.MultiBinary, spaces.Box)):
        names = [f"{name}-{at}" if math.prod(space.shape) > 1 else name for at in range(math.prod(space.shape))]
        for at, own in enumerate(names):
            if isinstance(space, spaces.MultiBinary):
                to[own] = boolean()
            elif isinstance(space, spaces.MultiDiscrete):
                start = int(space.start.reshape(-1)[at])
                to[own] = integer(start, start + int(space.nvec.reshape(-1)[at]) - 1)
            else:
                low, high = float(space.low.reshape(-1)[at]), float(space.high.reshape(-1)[at])
                if not (math.isfinite(low) and math.isfinite(high)):
                    raise _OwnActionsError(f"{own} has no bounds, which gymnasium.wrappers.RescaleAction gives it")
                to[own] = real(low, high, (high - low) / (ACTION_BINS - 1) or 1.0)
        return lambda given: numpy.asarray([given[own] for own in names], dtype=space.dtype).reshape(space.shape)
    raise _OwnActionsError(f"nothing is known of a space {type(space).__name__}")


def _is_open(space: Any) -> bool:
    """Whether a space does not say by itself what values it has."""
    if isinstance(space, spaces.Tuple):
        return any(map(_is_open, space.spaces))
    if isinstance(space, spaces.Dict):
        return any(map(_is_open, space.spaces.values()))
    if isinstance(space, spaces.Box):
        return not bool(numpy.all(space.high.astype(float) - space.low.astype(float) <= WIDE))
    return not isinstance(space, (spaces.Discrete, spaces.MultiDiscrete, spaces.MultiBinary))


def _sampled(env: Any) -> list[Any]:
    """What is observed in random episodes, for spaces that do not say what values they have.

    They are the same episodes each time: a body whose senses came out otherwise than before would be refused.
    """
    seen, _ = env.reset(seed=SAMPLED_SEED)
    samples = [seen]
    env.action_space.seed(SAMPLED_SEED)
    for _ in range(SAMPLED):
        seen, _, terminated, truncated, _ = env.step(env.action_space.sample())
        samples.append(seen)
        if terminated or truncated:
            seen, _ = env.reset()
            samples.append(seen)
    return samples


def senses_of(env: Any, known: str, bins: int) -> Part:
    """The senses of an environment, which is ``known`` under this name."""
    space = env.observation_space
    if isinstance(env.unwrapped, Table):
        # Its own senses, in which a block's field resembles the finger's.
        return Part(list(env.unwrapped.description.senses), lambda _: env.unwrapped.sensed)
    if known == "Taxi":
        return _taxi(env)
    # A player's seat in a game has no random episodes of its own.
    samples = _sampled(env) if _is_open(space) and not getattr(env, "is_seat", False) else []
    if _is_minigrid(env):
        return _minigrid(space, samples, bins)
    return _space("state", space, samples, _OBSERVATIONS.get(known, ()), bins)
