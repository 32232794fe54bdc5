"""A Gymnasium environment as a body.

    >>> import pschema.gym
    >>> pschema.gym.attach("FrozenLake-v1", episodes=100)

``python -m pschema.gym FrozenLake-v1`` is the same from the command line, and starts a daemon if there is none.

The other way round, this import registers ``pschema/Table-v0``, the simulated arm (`pschema.table.Table`), with Gymnasium.

What an environment's spaces become:

* ``Discrete`` is a whole number, ``MultiDiscrete``, ``MultiBinary``, ``Tuple`` and ``Dict`` are as many senses as they have parts,
  and a small ``Box`` one real for each number, in 20 bins between its bounds; where there are no bounds, between twice those of what
  random episodes showed. A ``Text`` is its words. An image is refused.
* An action space of at most 16 actions is as many actions; of others, up to 4,096, the action ``act`` with parameters, a real in five
  values. A larger one is refused: say the actions yourself then.
* MiniGrid's view is objects: each thing in sight with its kind, its colour and where it is from the agent.
* A reward other than zero is the value ``reward``: the learner does not live by it, and ``achieve(most="reward")`` brings as much of it
  as can be. The end of an episode is the event ``end``; the action after it is not carried out but
  begins the next episode, as in Gymnasium's autoreset at the next step, and its outcome says so.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import importlib
import json
import re
import secrets
import sys
import threading
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Optional, Union

from . import _checked, _native
from .body import Body, Summary, run
from .client import connect
from .daemon import Daemon
from .declare import ActionType, Description, Observation, Outcome, Sense, event, real, symbol, value
from .errors import DeclarationError, Error, NoDaemonError

try:
    import gymnasium
except ImportError as missing:
    wanted = f"pschema.gym needs gymnasium ({missing}): pip install 'pschema[gym]', or from a clone './tools/python[gym]'"
    if __name__ == "__main__":
        sys.exit(wanted)
    raise ImportError(wanted) from missing

from ._games import Game, RefusedByRules, Seat
from ._spaces import BINS, Part, Perform, Read, acts, acts_of, as_name, senses_of

#: The simulated arm as an environment, which this import registers.
TABLE = "pschema/Table-v0"
#: How many actions an episode of it has at most.
TABLE_ACTIONS_MAX = 20
if TABLE not in gymnasium.registry:
    gymnasium.register(TABLE, "pschema.table:Table", max_episode_steps=TABLE_ACTIONS_MAX)

__all__ = ["EnvironmentBody", "attach", "main"]

#: What stands before the id of a game of PettingZoo.
GAME = "pettingzoo:"
#: Rewards are told in these steps, up to this size.
REWARD_RESOLUTION = 0.1
REWARD_MAX = 1e6


#: More bins than numbers that a person would tell apart are a mistake.
BINS_MAX = 1_000_000
#: The longest name of a body's kind.
NAME_BYTES_MAX = 32


def kind_in(env: Any) -> str:
    """The kind of a body in an environment, with what tells its world from others: two of them may have the same spaces.

    It is `gym@`, the environment's id, as far as there is room, and a digest of the id and of the arguments that it was made with, but for
    how it is drawn. An environment that was not made by its id says no world.
    """
    spec = getattr(env, "spec", None)
    if spec is None:
        return "gym"
    made = {name: value for name, value in spec.kwargs.items() if name != "render_mode"}
    told = json.dumps([spec.id, made], sort_keys=True, default=lambda value: type(value).__name__)
    digest = hashlib.sha256(told.encode()).hexdigest()[:6]
    known = re.sub(r"[^A-Za-z0-9.-]", "-", spec.id.rpartition("/")[2])
    return f"gym@{known[: NAME_BYTES_MAX - len('gym@-') - len(digest)]}-{digest}"


@dataclass
class EnvironmentBody(Body):
    """A Gymnasium environment as a body. `attach` makes it and runs it.

    Args:
        env: the environment, whose episodes follow one another.
        name: of the body.
        seed: of the environment; the same seed and the same actions are the same episodes.
        episodes: how many to live; without end unless given.
        senses: what ``observe`` reports; those that the observation space says unless given.
        observe: from an observation of the environment to what is sensed in it.
        bins: how many bins a real is learnt in, between its bounds.
        stop: is set after the last episode.
        actions: what may be done: a dict from names to actions of the environment, or declared, with ``perform``; those that the
            action space says unless given.
        perform: from an action that is asked for to one of the environment.
    """

    env: Any
    name: str = "gym"
    seed: Optional[int] = None
    episodes: Optional[int] = None
    senses: Optional[Sequence[Sense]] = None
    observe: Optional[Read] = None
    bins: int = BINS
    stop: _native.Stop = field(default_factory=_native.Stop)
    actions: Union[Mapping[str, Any], Sequence[ActionType], None] = None
    perform: Optional[Perform] = None
    #: Episodes that are over, and how many actions and what sum of rewards the last of them had.
    done: int = 0
    length: int = 0
    total: float = 0.0
    #: What the environment raised, if it did: it is lived in no longer then.
    broken: Optional[Exception] = None
    #: Whether it was asked for an action, so that it is attached.
    asked: bool = False

    def __post_init__(self) -> None:
        whole = isinstance(self.episodes, int) and not isinstance(self.episodes, bool)
        if self.episodes is not None and (not whole or self.episodes < 1):
            raise DeclarationError(f"episodes={self.episodes!r}: give a whole number from 1, or nothing to live without end")
        if not hasattr(self.env, "action_space") or not callable(getattr(self.env, "step", None)):
            raise DeclarationError(f"env={_checked.shown(self.env)}: give an environment of Gymnasium, or the id of one")
        if isinstance(self.bins, bool) or not isinstance(self.bins, int) or not 1 <= self.bins <= BINS_MAX:
            raise DeclarationError(f"bins={_checked.shown(self.bins)}: give a whole number from 1 to {BINS_MAX:,}")
        _checked_seed(self.seed)
        if (self.senses is None) != (self.observe is None):
            raise DeclarationError("give senses= and observe= both, or neither: what is sensed, and how it is told from an observation")
        if self.observe is not None and not callable(self.observe):
            raise DeclarationError(f"observe={_checked.shown(self.observe)}: give a function from an observation to what is sensed in it")
        spec = getattr(self.env, "spec", None)
        known = re.sub(r"-v\d+$", "", spec.id.rpartition("/")[2]) if spec is not None else ""
        if self.actions is None and self.perform is None:
            self._acts = acts(self.env, known)
        else:
            self._acts = acts_of(self.env, self.actions, self.perform)
        if self.observe is not None and self.senses is not None:
            self._part = Part(list(self.senses), self.observe)
        else:
            self._part = senses_of(self.env, known, self.bins)
        self._begin()

    def _begin(self) -> None:
        # The seed is given once: the episodes after it follow from it. One is drawn where none is given, for the random episodes that
        # told the senses had one.
        first = secrets.randbits(31) if self.seed is None else self.seed
        self._seen, _ = self.env.reset(seed=first if self.done == 0 else None)
        self._reward, self._end, self._told = 0.0, "", False
        self._length, self._total = 0, 0.0

    def describe(self) -> Description:
        own = [
            value("reward", reward=real(-REWARD_MAX, REWARD_MAX, REWARD_RESOLUTION)),
            event("end", end=symbol("terminated", "truncated")),
        ]
        return Description(self.name, [*self._part.senses, *own], self._acts.actions, kind=kind_in(self.env))

    def sense(self) -> Iterator[Observation]:
        seen = self._part.read(self._seen)
        if isinstance(seen, str) or not hasattr(seen, "__iter__"):
            told = _checked.shown(seen)
            raise DeclarationError(
                f"observe() returned {told}: return what is sensed, each a sense with its values, or no values at all as []"
            )
        yield from seen
        # Events are of one frame: a learner that rests is sent the same state again.
        if self._told:
            return
        self._told = True
        if self._reward:
            yield "reward", (min(max(self._reward, -REWARD_MAX), REWARD_MAX),)
        if self._end:
            yield "end", (self._end,)

    def act(self, action: _native.Action) -> Optional[Outcome]:
        self.asked = True
        if self._end:
            outcome = Outcome.episode_ended() if self._end == "terminated" else Outcome.episode_cut()
            self._begin()
            return outcome
        try:
            self._seen, given, terminated, truncated, _ = self.env.step(self._acts.put(action))
            reward = _reward(given)
        except RefusedByRules as rules:
            return Outcome.refused(str(rules))
        except Exception as error:
            # A robot may fail and try again; an environment that raises is broken, and would do so for ever.
            self.broken = error
            self.stop.set()
            raise
        self._reward, self._told = reward, False
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


def _reward(given: Any) -> float:
    """The reward of a step; some environments give an array of one number."""
    try:
        return float(given.item() if hasattr(given, "item") else given)
    except (TypeError, ValueError) as error:
        raise Error(f"the environment's reward is {_checked.shown(given)}, which is no number") from error


def _made(name: str, options: Mapping[str, Any]) -> Any:
    """The environment, or the game, of this id."""
    try:
        if name.startswith(GAME):
            import pettingzoo

            return pettingzoo.make("aec", name[len(GAME) :], **options)
        if name.startswith(("MiniGrid-", "BabyAI-")):
            # It registers its environments when it is imported.
            importlib.import_module("minigrid")
        return gymnasium.make(name, **options)
    except ModuleNotFoundError as missing:
        raise DeclarationError(f"{name} needs the package {missing.name}: pip install {missing.name}") from missing
    except Exception as error:
        told = ", ".join(f"{key}={value!r}" for key, value in options.items())
        raise DeclarationError(f"{name} can't be made{' with ' + told if told else ''}: {error}") from error


def _lived(body: EnvironmentBody, name: str, flag: _native.Stop) -> Summary:
    """Runs a body until its episodes are over; raises what its environment raised."""
    summary = run(body, name, stop=flag)
    if body.broken is not None:
        raise body.broken
    return summary


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
    actions: Union[Mapping[str, Any], Sequence[ActionType], None] = None,
    perform: Optional[Perform] = None,
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
        actions: what may be done, if you say so yourself: a dict from names to actions of the environment, as
            ``{"left": 0, "right": 3}``; of more than 16 (at most 512) one action is made, ``act``, with the names as its parameter. Or a
            list of `pschema.action`, with ``perform``.
        perform: a function from an action that is asked for, with its parameters, to an action of the environment.

    Returns:
        What happened; of several bodies, in all.

    Raises:
        DeclarationError: no environment; an observation or action that can't be taken, as an image; more than 8 bodies.
        RefusedError: the learner knows the body otherwise, or has no place for another.
    """
    if body is not None:
        _checked.text("body", body)
    _checked.text("name", name)
    _checked_seed(seed)
    if stop is not None and not isinstance(stop, _native.Stop):
        raise DeclarationError(f"stop={_checked.shown(stop)}: give a pschema.Stop")
    flag = _native.Stop() if stop is None else stop
    if options and not isinstance(env, str):
        raise DeclarationError(f"{', '.join(options)}: no such argument; what an environment is made with goes with the id of one")
    made = _made(env, options) if isinstance(env, str) else env
    if hasattr(made, "possible_agents"):
        _places(len(made.possible_agents), "players, each of which is a body")
        game = Game(made, seed, flag)

        def player(seat: Seat) -> EnvironmentBody:
            return EnvironmentBody(seat, as_name(seat.player), None, episodes, senses, observe, bins, flag, actions, perform)

        try:
            # Only one player has the first turn: the others wait for it in their own threads.
            return _together([functools.partial(player, seat) for seat in game.seats], name, flag)
        finally:
            made.close()
    several = getattr(made, "envs", None)
    if several is None and hasattr(made, "num_envs"):
        raise DeclarationError(f"{type(made).__name__} has its environments elsewhere: give a gymnasium.vector.SyncVectorEnv")
    environments = [made] if several is None else list(several)
    _places(
        len(environments),
        "environments, each of which is a body: give a SyncVectorEnv of fewer, or attach the others to a learner of another name",
    )
    spec = getattr(environments[0], "spec", None)
    called = body or (as_name(spec.id) if spec is not None else "gym")
    try:
        bodies = []
        for number, one in enumerate(environments):
            own = called if len(environments) == 1 else f"{called[:29]}-{number}"
            own_seed = None if seed is None else seed + number
            own_flag = flag if len(environments) == 1 else _native.Stop()
            bodies.append(EnvironmentBody(one, own, own_seed, episodes, senses, observe, bins, own_flag, actions, perform))
        if len(bodies) == 1:
            return _lived(bodies[0], name, flag)
        return _together([functools.partial(_itself, one) for one in bodies], name, flag)
    finally:
        if isinstance(env, str):
            made.close()


def _places(count: int, what: str) -> None:
    """Refuses more bodies than there are places for, before the first of them attaches."""
    if count > _native.BODIES_MAX:
        raise DeclarationError(f"a daemon takes at most {_native.BODIES_MAX} bodies at a time, and there are {count} {what}")


def _checked_seed(seed: Any) -> None:
    if seed is not None and (isinstance(seed, bool) or not hasattr(seed, "__index__") or seed < 0):
        raise DeclarationError(f"seed={_checked.shown(seed)}: give a whole number from 0, or nothing for one that is drawn")


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
            summaries.append(_lived(body, name, body.stop))
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


def _from(least: int) -> Callable[[str], int]:
    """Reads a whole number from ``least`` on the command line."""

    def whole(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r}: give a whole number from {least}")
        return int(text)

    return whole


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """``python -m pschema.gym``; returns the exit code: 1 if a goal was given and not achieved."""
    parser = argparse.ArgumentParser(
        prog="python -m pschema.gym",
        description="Live in a Gymnasium environment: attach it to a learner as a body.",
        epilog="Example: python -m pschema.gym FrozenLake-v1 --set is_slippery=False --episodes 200 --goal 'field{field=15}'",
    )
    parser.add_argument("env", help="the id of an environment")
    parser.add_argument("--name", default="default", help="the learner; a daemon is started for it if it has none [default: default]")
    parser.add_argument("--episodes", type=_from(1), help="how many to live; until Ctrl-C unless given")
    parser.add_argument("--seed", type=_from(0), help="of the environment, and of the learner that is started")
    parser.add_argument("--data", help="the directory that a learner which is started keeps its memory in")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="an option of the environment, as Python writes it")
    parser.add_argument("--goal", action="append", default=[], metavar="PATTERN", help="what to achieve after the episodes")
    parser.add_argument("--actions-max", type=_from(1), default=100, help="how many actions may be taken for the goal [default: 100]")
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
    daemon, stop = None, _native.Stop()
    try:
        try:
            with connect(given.name):
                pass
        except NoDaemonError:
            daemon = Daemon(given.name, seed=given.seed, data=given.data, arguments=["--quiet"])
            # Nobody starts it again: without this the body would wait for the next one for ever.
            threading.Thread(target=_ends_with, args=(daemon, stop), name="pschema-daemon", daemon=True).start()
        code = _live(given, options, stop)
        return _without(daemon) or code
    except Error as error:
        print(f"pschema.gym: {error}", file=sys.stderr)
        _without(daemon)
        return 1
    except Exception as error:
        # Of the environment: where it comes from is for who wrote that.
        traceback.print_exception(error)
        print(f"pschema.gym: {given.env} raised {type(error).__name__}: {error}", file=sys.stderr)
        return 1
    finally:
        if daemon is not None:
            daemon.end()


def _ends_with(daemon: Daemon, stop: _native.Stop) -> None:
    daemon.wait()
    stop.set()


def _without(daemon: Optional[Daemon]) -> int:
    """Says that the daemon which was started here has ended by itself, if it has; returns the exit code that this means."""
    code = None if daemon is None else daemon.exit_code
    if daemon is None or code is None:
        return 0
    how = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
    kept = "what it kept with --data is there, and the next run goes on from it" if daemon.data else "its memory was in RAM only"
    print(f"pschema.gym: the daemon that was started for {daemon.name} {how}, so there is nothing more to do: {kept}", file=sys.stderr)
    return int(code != 0)


def _live(given: argparse.Namespace, options: dict[str, Any], stop: _native.Stop) -> int:
    if given.env.startswith(GAME):
        summary = attach(given.env, given.name, seed=given.seed, episodes=given.episodes, stop=stop, **options)
        print(f"{summary.sessions} players, {summary.orders} actions.")
        return 0
    env = _made(given.env, options)
    body = EnvironmentBody(env, as_name(given.env), given.seed, None if given.goal else given.episodes, stop=stop)
    over, called_off = threading.Event(), _native.Stop()
    achieved: list[Any] = []
    raised: list[Exception] = []

    def pursue() -> None:
        try:
            while not body.asked and not over.wait(0.02):
                pass
            if over.is_set():
                return
            with connect(given.name) as learner:
                # What is wrong with a goal is said before the episodes are lived, and not after.
                learner.plan(*given.goal)
            while body.done < given.episodes and not over.wait(0.02):
                pass
            if over.is_set():
                return
            with connect(given.name) as learner:
                achieved.append(learner.achieve(*given.goal, actions_max=given.actions_max, wait_s=600, stop=called_off))
        except Exception as error:
            raised.append(error)
        finally:
            body.stop.set()

    workers = [threading.Thread(target=_told, args=(body, over), daemon=True)]
    if given.goal:
        workers.append(threading.Thread(target=pursue))
    for worker in workers:
        worker.start()
    try:
        summary = _lived(body, given.name, body.stop)
    finally:
        # Without the body nobody acts for the goal: who waits for it is told.
        over.set()
        called_off.set()
        workers[-1].join()
        env.close()
    print(f"{body.done} episodes, {summary.orders} actions.")
    if not given.goal:
        return 0
    if raised:
        raise raised[0]
    if not achieved:
        print("The goal was not pursued.")
        return 1
    print(f"Goal {' & '.join(given.goal)}: {achieved[0]['state']}, after {achieved[0]['actions']} actions.")
    return 0 if achieved[0]["achieved"] else 1


if __name__ == "__main__":
    sys.exit(main())
