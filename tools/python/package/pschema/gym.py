"""A Gymnasium environment as a body.

    >>> import pschema.gym
    >>> pschema.gym.attach("FrozenLake-v1", episodes=100)

``python -m pschema.gym FrozenLake-v1`` is the same from the command line, and starts a daemon if there is none.

What an environment's spaces become:

* ``Discrete`` is a whole number, ``MultiDiscrete``, ``MultiBinary``, ``Tuple`` and ``Dict`` are as many senses as they have parts,
  and a small ``Box`` one real for each number, in 20 bins between its bounds; where there are no bounds, between twice those of what
  random episodes showed. A ``Text`` is its words. An image is refused.
* MiniGrid's view is objects: each thing in sight with its kind, its colour and where it is from the agent.
* A reward other than zero is the event ``reward``. The end of an episode is the event ``end``; the action after it is not carried out but
  begins the next episode, as in Gymnasium's autoreset at the next step, and its outcome says so.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import math
import re
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Optional, Union

from . import _native
from .body import Body, Summary, run
from .client import connect
from .daemon import Daemon
from .declare import (
    ActionType,
    Description,
    Observation,
    Outcome,
    Sense,
    Values,
    action,
    boolean,
    event,
    integer,
    real,
    state,
    symbol,
)
from .errors import DeclarationError, Error, NoDaemonError

try:
    import gymnasium
    import numpy
    from gymnasium import spaces
except ImportError as missing:
    raise ImportError(f"pschema.gym needs gymnasium and numpy ({missing}): pip install 'pschema[gym]'") from missing

__all__ = ["EnvironmentBody", "attach", "main"]

#: What stands before the id of a game of PettingZoo.
GAME = "pettingzoo:"
#: How many bins a real is learnt in, between its bounds.
BINS = 20
#: How many values an action that is a real has.
ACTION_BINS = 5
#: How many numbers a box may have: more are an image, or should be one thing each.
BOX_MAX = 24
#: Rewards are told in these steps, up to this size.
REWARD_RESOLUTION = 0.1
REWARD_MAX = 1e6
#: Bounds that are further apart say nothing of a number.
WIDE = 1e6
#: How many actions a random episode has that is looked at for what values there are.
SAMPLED = 200
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


def _word(name: object) -> str:
    """A name as a body may declare it."""
    return re.sub(r"[{}(),=$\s]+", "-", str(name)).strip("-")[:32] or "state"


@dataclass
class _Part:
    """Some senses, and how an observation of the environment is put into them."""

    senses: list[Sense]
    read: Read


def _one(name: str, values: Values, convert: Callable[[Any], Any]) -> _Part:
    return _Part([state(name, {name: values})], lambda seen: [(name, (convert(seen),))])


def _all(parts: Sequence[_Part], split: Callable[[Any], Iterable[Any]]) -> _Part:
    def read(seen: Any) -> Iterator[Observation]:
        for part, of_part in zip(parts, split(seen)):
            yield from part.read(of_part)

    return _Part([sense for part in parts for sense in part.senses], read)


def _whole(name: str, least: int, count: int) -> _Part:
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


def _box(name: str, space: Any, samples: Sequence[Any], names: Sequence[str], bins: int) -> _Part:
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


def _text(name: str, samples: Sequence[Any]) -> _Part:
    """The words of a text, each an observation; words that every text has say nothing."""

    def words(text: Any) -> list[str]:
        return sorted({_word(word) for word in str(text).lower().split()})

    told = [set(words(text)) for text in samples]
    always = set.intersection(*told) if told else set()
    known = sorted(set().union(*told) - always)[:WORDS_MAX]
    if not known:
        return _Part([], lambda _: [])
    senses = [state(name, {"word": symbol(*known, "other")})]

    def read(text: Any) -> Iterator[Observation]:
        told = {word if word in known else "other" for word in words(text) if word not in always}
        yield from ((name, (word,)) for word in sorted(told))

    return _Part(senses, read)


def _space(name: str, space: Any, samples: Sequence[Any], names: Sequence[str], bins: int) -> _Part:
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
            own = _word(key) if name == "state" else _word(f"{name}-{key}")
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


def _minigrid(space: Any, samples: Sequence[Any], bins: int) -> _Part:
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

    parts, keys = [_Part(senses, image)], ["image"]
    for key in space.spaces:
        if key != "image":
            parts.append(_space(_word(key), space[key], [sample[key] for sample in samples], (), bins))
            keys.append(key)
    return _all(parts, lambda given: [given[key] for key in keys])


def _taxi(env: Any) -> _Part:
    """A taxi's number stands for four things, which its own code tells apart."""
    counts = {"row": 5, "column": 5, "passenger": 5, "destination": 4}
    return _all([_whole(name, 0, count) for name, count in counts.items()], lambda given: env.unwrapped.decode(int(given)))


@dataclass
class _Acts:
    """The actions, and what each is to the environment."""

    actions: list[ActionType]
    put: Callable[[_native.Action], Any]


class _Game:
    """A game of PettingZoo, whose players take turns; each is the environment of one body, in a thread of its own."""

    def __init__(self, env: Any, seed: Optional[int], stop: _native.Stop) -> None:
        if not hasattr(env, "agent_iter"):
            from pettingzoo.utils import parallel_to_aec

            env = parallel_to_aec(env)
        self.env = env
        self.stop = stop
        self.turn = threading.Condition()
        env.reset(seed=seed)
        self.seats = [_Seat(self, player) for player in env.possible_agents]


class _Seat:
    """One player's view of a game: an environment in which the moves of the others happen between two of its own."""

    render_mode = None
    spec = None

    def __init__(self, game: _Game, player: Any) -> None:
        self.game = game
        self.player = player
        space = game.env.observation_space(player)
        self.masked = isinstance(space, spaces.Dict) and "action_mask" in space.spaces
        self.observation_space = space["observation"] if self.masked else space
        self.action_space = game.env.action_space(player)
        self.unwrapped = game.env.unwrapped
        self.over = False

    def _turn(self) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Waits until it is this player's turn, and returns what is to be seen then. The lock is held."""
        env = self.game.env
        while not self.game.stop.is_set() and env.agent_selection != self.player:
            # The stop flag is not told of.
            self.game.turn.wait(0.05)
        if env.agent_selection == self.player:
            seen, reward, terminated, truncated, info = env.last()
        else:
            seen, reward, terminated, truncated, info = env.observe(self.player), 0.0, False, False, {}
        self.mask = seen["action_mask"] if self.masked else info.get("action_mask")
        self.over = bool(terminated or truncated)
        return (seen["observation"] if self.masked else seen), reward, terminated, truncated, info

    def reset(self, *, seed: Optional[int] = None) -> tuple[Any, dict[str, Any]]:
        with self.game.turn:
            if self.over and not self.game.stop.is_set():
                # A player whose game is over leaves, and the last one to leave begins the next.
                self.game.env.step(None)
                if not self.game.env.agents:
                    self.game.env.reset()
                self.game.turn.notify_all()
            seen, _, _, _, info = self._turn()
            return seen, info

    def step(self, move: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        with self.game.turn:
            if self.mask is not None and not self.mask[int(move) - int(self.action_space.start)]:
                raise _RefusedByRules("the rules of the game do not allow it here")
            self.game.env.step(move)
            self.game.turn.notify_all()
            return self._turn()


class _RefusedByRules(Exception):
    """An action that can't be taken where the game stands."""


def _acts(env: Any, known: str) -> _Acts:
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
        names = [_word(name) for name in named]
        places = {name: start + at for at, name in enumerate(names)}
        return _Acts([action(name) for name in names], lambda asked: places[asked.name])
    parameters: dict[str, Values] = {}
    build = _parameters("act" if not isinstance(space, spaces.Dict) else "", space, parameters)
    return _Acts([action("act", parameters)], lambda asked: build(asked.parameters))


def _parameters(name: str, space: Any, to: dict[str, Values]) -> Callable[[Mapping[str, Any]], Any]:
    """Adds the parameters of an action space, and returns what makes an action of their values."""
    if isinstance(space, spaces.Discrete):
        to[name] = integer(int(space.start), int(space.start + space.n - 1))
        return lambda given: given[name]
    if isinstance(space, spaces.Tuple):
        builds = [_parameters(f"{name}-{at}", one, to) for at, one in enumerate(space.spaces)]
        return lambda given: tuple(build(given) for build in builds)
    if isinstance(space, spaces.Dict):
        made = {key: _parameters(_word(f"{name}-{key}" if name else key), one, to) for key, one in space.spaces.items()}
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
                    raise DeclarationError(f"the action {own} has no bounds: wrap the environment in gymnasium.wrappers.RescaleAction")
                to[own] = real(low, high, (high - low) / (ACTION_BINS - 1) or 1.0)
        return lambda given: numpy.asarray([given[own] for own in names], dtype=space.dtype).reshape(space.shape)
    raise DeclarationError(f"nothing is known of an action space {type(space).__name__}")


def _is_open(space: Any) -> bool:
    """Whether a space does not say by itself what values it has."""
    if isinstance(space, spaces.Tuple):
        return any(map(_is_open, space.spaces))
    if isinstance(space, spaces.Dict):
        return any(map(_is_open, space.spaces.values()))
    if isinstance(space, spaces.Box):
        return not bool(numpy.all(space.high.astype(float) - space.low.astype(float) <= WIDE))
    return not isinstance(space, (spaces.Discrete, spaces.MultiDiscrete, spaces.MultiBinary))


def _sampled(env: Any, seed: Optional[int]) -> list[Any]:
    """What is observed in random episodes, for spaces that do not say what values they have."""
    seen, _ = env.reset(seed=seed)
    samples = [seen]
    env.action_space.seed(seed)
    for _ in range(SAMPLED):
        seen, _, terminated, truncated, _ = env.step(env.action_space.sample())
        samples.append(seen)
        if terminated or truncated:
            seen, _ = env.reset()
            samples.append(seen)
    return samples


@dataclass
class EnvironmentBody(Body):
    """A Gymnasium environment as a body. :func:`attach` makes it and runs it.

    Args:
        env: the environment, whose episodes follow one another.
        name: of the body.
        seed: of the environment; the same seed and the same actions are the same episodes.
        episodes: how many to live; without end unless given.
        senses: what ``observe`` reports; those that the observation space says unless given.
        observe: from an observation of the environment to what is sensed in it.
        bins: how many bins a real is learnt in, between its bounds.
        stop: is set after the last episode.
    """

    env: Any
    name: str = "gym"
    seed: Optional[int] = None
    episodes: Optional[int] = None
    senses: Optional[Sequence[Sense]] = None
    observe: Optional[Read] = None
    bins: int = BINS
    stop: _native.Stop = field(default_factory=_native.Stop)
    #: Episodes that are over, and how many actions and what sum of rewards the last of them had.
    done: int = 0
    length: int = 0
    total: float = 0.0

    def __post_init__(self) -> None:
        if (self.senses is None) != (self.observe is None):
            raise DeclarationError("give senses= and observe= both, or neither: what is sensed, and how it is told from an observation")
        spec = getattr(self.env, "spec", None)
        known = re.sub(r"-v\d+$", "", spec.id.rpartition("/")[2]) if spec is not None else ""
        self._acts = _acts(self.env, known)
        if self.observe is not None and self.senses is not None:
            self._part = _Part(list(self.senses), self.observe)
        else:
            self._part = self._senses_of(known)
        self._begin()

    def _senses_of(self, known: str) -> _Part:
        space = self.env.observation_space
        names = _OBSERVATIONS.get(known, ())
        if known == "Taxi":
            return _taxi(self.env)
        samples = _sampled(self.env, self.seed) if _is_open(space) and not isinstance(self.env, _Seat) else []
        if _is_minigrid(self.env):
            return _minigrid(space, samples, self.bins)
        return _space("state", space, samples, names, self.bins)

    def _begin(self) -> None:
        # The seed is given once: the episodes after it follow from it.
        self._seen, _ = self.env.reset(seed=self.seed if self.done == 0 else None)
        self._reward, self._end, self._told = 0.0, "", False
        self._length, self._total = 0, 0.0

    def describe(self) -> Description:
        own = [
            event("reward", reward=real(-REWARD_MAX, REWARD_MAX, REWARD_RESOLUTION)),
            event("end", end=symbol("terminated", "truncated")),
        ]
        return Description(self.name, [*self._part.senses, *own], self._acts.actions, kind="gymnasium")

    def sense(self) -> Iterator[Observation]:
        yield from self._part.read(self._seen)
        # Events are of one frame: a learner that rests is sent the same state again.
        if self._told:
            return
        self._told = True
        if self._reward:
            yield "reward", (min(max(self._reward, -REWARD_MAX), REWARD_MAX),)
        if self._end:
            yield "end", (self._end,)

    def act(self, action: _native.Action) -> Optional[Outcome]:
        if self._end:
            outcome = Outcome.episode_ended() if self._end == "terminated" else Outcome.episode_cut()
            self._begin()
            return outcome
        try:
            self._seen, reward, terminated, truncated, _ = self.env.step(self._acts.put(action))
        except _RefusedByRules as rules:
            return Outcome.refused(str(rules))
        self._reward, self._told = float(reward), False
        self._length += 1
        self._total += self._reward
        if terminated or truncated:
            self._end = "terminated" if terminated else "truncated"
            self.done, self.length, self.total = self.done + 1, self._length, self._total
            if self.episodes is not None and self.done >= self.episodes:
                self.stop.set()
        return None

    def picture(self) -> Any:
        if getattr(self.env, "render_mode", None) != "rgb_array":
            return None
        return self.env.render()


def _made(name: str, options: Mapping[str, Any]) -> Any:
    """The environment, or the game, of this id."""
    if name.startswith(GAME):
        import pettingzoo

        return pettingzoo.make("aec", name[len(GAME) :], **options)
    if name.startswith(("MiniGrid-", "BabyAI-")):
        # It registers its environments when it is imported.
        importlib.import_module("minigrid")
    return gymnasium.make(name, **options)


def attach(
    env: Union[str, Any],
    name: str = "default",
    *,
    body: Optional[str] = None,
    seed: Optional[int] = None,
    episodes: Optional[int] = None,
    senses: Optional[Sequence[Sense]] = None,
    observe: Optional[Read] = None,
    bins: int = BINS,
    stop: Optional[_native.Stop] = None,
    **options: Any,
) -> Summary:
    """Attaches an environment to the learner ``name``, and lives in it until ``episodes`` are over, or Ctrl-C.

    Args:
        env: an environment, or the id of one, which is made with ``options`` as ``gymnasium.make`` takes them; or a
            ``SyncVectorEnv``, whose environments are bodies beside each other, at most 8; or a game of PettingZoo, or the id of
            one (``"pettingzoo:classic/tictactoe-v3"``), whose players are bodies that take turns.
        name: of the learner.
        body: the name of the body; by default that of the environment, and of a player in a game. A body that comes back under its
            name goes on.
        seed: of the environment.
        episodes: how many to live, each body by itself; without end unless given.
        senses: what ``observe`` reports, if you tell yourself what is sensed.
        observe: a function from an observation of the environment to what is sensed in it.
        bins: how many bins a real is learnt in.
        stop: a flag that ends it from another thread.

    Returns:
        What happened; of several bodies, in all.

    Raises:
        DeclarationError: an observation or action that can't be taken, as an image.
        RefusedError: the learner knows the body otherwise.
    """
    flag = _native.Stop() if stop is None else stop
    made = _made(env, options) if isinstance(env, str) else env
    if hasattr(made, "possible_agents"):
        game = _Game(made, seed, flag)

        def player(seat: _Seat) -> EnvironmentBody:
            return EnvironmentBody(seat, _word(seat.player), None, episodes, senses, observe, bins, flag)

        try:
            # Only one player has the first turn: the others wait for it in their own threads.
            return _together([functools.partial(player, seat) for seat in game.seats], name, flag)
        finally:
            made.close()
    several = getattr(made, "envs", None)
    if several is None and hasattr(made, "num_envs"):
        raise DeclarationError(f"{type(made).__name__} has its environments elsewhere: give a gymnasium.vector.SyncVectorEnv")
    environments = [made] if several is None else list(several)
    spec = getattr(environments[0], "spec", None)
    called = body or (_word(spec.id) if spec is not None else "gym")
    try:
        bodies = []
        for number, one in enumerate(environments):
            own = called if len(environments) == 1 else f"{called[:29]}-{number}"
            own_seed = None if seed is None else seed + number
            own_flag = flag if len(environments) == 1 else _native.Stop()
            bodies.append(EnvironmentBody(one, own, own_seed, episodes, senses, observe, bins, own_flag))
        if len(bodies) == 1:
            return run(bodies[0], name, stop=flag)
        return _together([functools.partial(_itself, one) for one in bodies], name, flag)
    finally:
        if isinstance(env, str):
            made.close()


def _itself(body: EnvironmentBody) -> EnvironmentBody:
    return body


def _together(makes: Sequence[Callable[[], EnvironmentBody]], name: str, flag: _native.Stop) -> Summary:
    """Makes bodies and runs them side by side, each in a thread of its own, until all have ended."""
    bodies: list[EnvironmentBody] = []
    summaries: list[Summary] = []
    raised: list[BaseException] = []

    def live(make: Callable[[], EnvironmentBody]) -> None:
        try:
            body = make()
            bodies.append(body)
            summaries.append(run(body, name, stop=body.stop))
        except BaseException as error:
            raised.append(error)
            flag.set()

    threads = [threading.Thread(target=live, args=(make,), name="pschema-body") for make in makes]
    for thread in threads:
        thread.start()
    interrupted = False
    while any(thread.is_alive() for thread in threads):
        try:
            for thread in threads:
                thread.join(0.05)
        except KeyboardInterrupt:
            if interrupted:
                raise
            interrupted = True
            flag.set()
        if flag.is_set():
            for body in list(bodies):
                body.stop.set()
    if raised:
        raise raised[0]
    counts = [[getattr(one, count) for one in summaries] for count in ("sessions", "frames", "orders", "refused")]
    return Summary(summaries[0].ending, *(sum(count) for count in counts))


def _told(body: EnvironmentBody, stop: threading.Event) -> None:
    """Tells of episodes as they end, on stderr."""
    told = 0
    while not stop.wait(1.0):
        if body.done > told:
            told = body.done
            print(f"{told} episodes; the last took {body.length} actions, for a reward of {body.total:g}", file=sys.stderr)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """``python -m pschema.gym``; returns the exit code: 1 if a goal was given and not achieved."""
    parser = argparse.ArgumentParser(
        prog="python -m pschema.gym",
        description="Live in a Gymnasium environment: attach it to a learner as a body.",
        epilog="Example: python -m pschema.gym FrozenLake-v1 --set is_slippery=False --episodes 200 --goal 'field{field=15}'",
    )
    parser.add_argument("env", help="the id of an environment")
    parser.add_argument("--name", default="default", help="the learner; a daemon is started for it if it has none [default: default]")
    parser.add_argument("--episodes", type=int, help="how many to live; until Ctrl-C unless given")
    parser.add_argument("--seed", type=int, help="of the environment, and of the learner that is started")
    parser.add_argument("--data", help="the directory that a learner which is started keeps its memory in")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="an option of the environment, as Python writes it")
    parser.add_argument("--goal", action="append", default=[], metavar="PATTERN", help="what to achieve after the episodes")
    parser.add_argument("--actions-max", type=int, default=100, help="how many actions may be taken for the goal [default: 100]")
    parser.add_argument("--render", action="store_true", help="show it in a window")
    parser.add_argument("--picture", action="store_true", help="show it in `pschema view`")
    given = parser.parse_args(arguments)
    if given.goal and given.env.startswith(GAME):
        parser.error("--goal is for one body, and a game has several: order `pschema achieve` beside it")
    if given.goal and given.episodes is None:
        parser.error("--goal is for after the episodes: say how many with --episodes")
    import ast

    options: dict[str, Any] = {}
    for setting in given.set:
        key, _, text = setting.partition("=")
        try:
            options[key] = ast.literal_eval(text)
        except (ValueError, SyntaxError):
            options[key] = text
    if given.render or given.picture:
        options["render_mode"] = "human" if given.render else "rgb_array"
    try:
        with connect(given.name):
            daemon = None
    except NoDaemonError:
        daemon = Daemon(given.name, seed=given.seed, data=given.data, arguments=["--quiet"])
    try:
        return _live(given, options)
    except Error as error:
        print(f"pschema.gym: {error}", file=sys.stderr)
        return 1
    finally:
        if daemon is not None:
            daemon.end()


def _live(given: argparse.Namespace, options: dict[str, Any]) -> int:
    if given.env.startswith(GAME):
        summary = attach(given.env, given.name, seed=given.seed, episodes=given.episodes, **options)
        print(f"{summary.sessions} players, {summary.orders} actions.")
        return 0
    env = _made(given.env, options)
    body = EnvironmentBody(env, _word(given.env), given.seed, None if given.goal else given.episodes)
    over, achieved = threading.Event(), []

    def pursue() -> None:
        while body.done < given.episodes and not over.wait(0.02):
            pass
        if not over.is_set():
            with connect(given.name) as learner:
                try:
                    achieved.append(learner.achieve(*given.goal, actions_max=given.actions_max, wait_s=600))
                finally:
                    body.stop.set()

    workers = [threading.Thread(target=_told, args=(body, over), daemon=True)]
    if given.goal:
        workers.append(threading.Thread(target=pursue))
    for worker in workers:
        worker.start()
    try:
        summary = run(body, given.name, stop=body.stop)
    finally:
        over.set()
        workers[-1].join()
        env.close()
    print(f"{body.done} episodes, {summary.orders} actions.")
    if not given.goal:
        return 0
    if not achieved:
        print("The goal was not pursued.")
        return 1
    print(f"Goal {' & '.join(given.goal)}: {achieved[0]['state']}, after {achieved[0]['actions']} actions.")
    return 0 if achieved[0]["achieved"] else 1


if __name__ == "__main__":
    sys.exit(main())
