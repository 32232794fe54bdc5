"""Gymnasium's environments as bodies."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any, Optional

import pytest

import pschema

from .conftest import DEADLINE_S, Sandbox, finished, until

gymnasium = pytest.importorskip("gymnasium")
numpy = pytest.importorskip("numpy")
pytest.importorskip("minigrid")
import pschema.gym  # noqa: E402

ENVIRONMENTS = [
    "FrozenLake-v1",
    "Taxi-v4",
    "CliffWalking-v1",
    "Blackjack-v1",
    "CartPole-v1",
    "MountainCar-v0",
    "Pendulum-v1",
    "Acrobot-v1",
    "MiniGrid-Empty-5x5-v0",
    "MiniGrid-DoorKey-5x5-v0",
    "MiniGrid-FourRooms-v0",
]


def lived(body: pschema.gym.EnvironmentBody, steps: int) -> tuple[pschema.Learner, list[Any]]:
    """Lets a learner in this process live in an environment; returns what was sensed."""
    learner = pschema.Learner(1, profile="paper")
    learner.declare(body.describe())
    frames: list[Any] = []
    outcome: Optional[pschema.Outcome] = None
    for _ in range(steps):
        frames.append(list(body.sense()))
        action = learner.step(frames[-1], outcome)
        assert action is not None
        outcome = body.act(action)
    return learner, frames


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_an_environment_attaches_without_options(sandbox: Sandbox, name: str) -> None:
    with sandbox.daemon("gym", arguments=["--set", 'learner.profile="paper"']), pschema.connect("gym") as client:
        stop, acted = pschema.Stop(), 0
        env = gymnasium.make(name)

        class Enough(pschema.gym.EnvironmentBody):
            def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
                nonlocal acted
                acted += 1
                if acted == 30:
                    stop.set()
                return super().act(action)

        summary = pschema.run(Enough(env, "gym", 1), "gym", stop=stop)
        env.close()
        assert summary.orders == 30
        assert summary.refused == 0
        assert client.status()["step"] >= 30


def body_of(space: Any, action_space: Any = None, **options: Any) -> pschema.gym.EnvironmentBody:
    """A body in an environment that shows samples of a space."""

    class Samples(gymnasium.Env):  # type: ignore[misc, name-defined]
        observation_space = space
        steps = 0

        def __init__(self) -> None:
            self.action_space = action_space or gymnasium.spaces.Discrete(2)
            self.taken: list[Any] = []

        def reset(self, *, seed: Optional[int] = None, options: Any = None) -> Any:
            super().reset(seed=seed)
            if seed is not None:
                space.seed(seed)
            return space.sample(), {}

        def step(self, action: Any) -> Any:
            assert self.action_space.contains(action), action
            self.taken.append(action)
            self.steps += 1
            return space.sample(), 0.5, self.steps % 5 == 0, self.steps % 7 == 0, {}

    return pschema.gym.EnvironmentBody(Samples(), seed=3, **options)


S = gymnasium.spaces


@pytest.mark.parametrize(
    ("space", "senses"),
    [
        (S.Discrete(5, start=-2), ["state"]),
        (S.MultiDiscrete([3, 4]), ["state-0", "state-1"]),
        (S.MultiBinary(3), ["state-0", "state-1", "state-2"]),
        (S.Tuple([S.Discrete(3), S.MultiBinary(2)]), ["state-0", "state-1-0", "state-1-1"]),
        (S.Dict({"a b": S.Discrete(3), "of": S.Dict({"x": S.Box(0, 1)})}), ["a-b", "of-x"]),
        (S.Box(-1.0, 1.0, (3,)), ["state-0", "state-1", "state-2"]),
        (S.Box(-numpy.inf, numpy.inf, (2,)), ["state-0", "state-1"]),
        (S.Box(0, 9, (2, 2), numpy.int64), ["state-0", "state-1", "state-2", "state-3"]),
        (S.Text(8, charset="ab "), ["state"]),
    ],
)
def test_each_space_is_sensed(space: Any, senses: list[str]) -> None:
    body = body_of(space)
    learner, _ = lived(body, 60)
    assert [sense.name for sense in body.describe().senses] == [*senses, "reward", "end"]
    assert learner.steps == 60


@pytest.mark.parametrize(
    "space",
    [
        S.Discrete(3, start=1),
        S.Discrete(40),
        S.MultiDiscrete([3, 4]),
        S.MultiBinary(3),
        S.Box(-2.0, 2.0, (2,)),
        S.Tuple([S.Discrete(2), S.MultiBinary(2)]),
        S.Dict({"a": S.Discrete(2), "b c": S.Box(-1.0, 1.0, (1,))}),
    ],
)
def test_each_action_space_is_acted_in(space: Any) -> None:
    body = body_of(S.Discrete(2), space)
    lived(body, 40)
    assert len(body.env.taken) == 30


@pytest.mark.parametrize(
    ("space", "told"),
    [
        (S.Discrete(5000), "the action space Discrete(5000): it has 5,000 actions, and a body at most 4,096."),
        (
            S.Box(-1.0, 1.0, (6,)),
            "the action space Box(-1.0, 1.0, (6,), float32): it has 5 × 5 × 5 × 5 × 5 × 5 = 15,625 actions, each real in 5 values,",
        ),
        (S.MultiDiscrete([50, 50, 50]), "the action space MultiDiscrete([50 50 50]): it has 50 × 50 × 50 = 125,000 actions, and a body"),
        (S.MultiBinary(9), "the action space MultiBinary(9): an action of it has 9 numbers, and an action of a body at most 8 parameters."),
        (
            S.Dict({"a": S.Discrete(100), "b": S.Box(0, 1, (3,))}),
            "it has 100 × 5 × 5 × 5 = 12,500 actions, each real in 5 values, and a body",
        ),
        (S.Box(-numpy.inf, numpy.inf, (1,)), "act has no bounds, which gymnasium.wrappers.RescaleAction gives it."),
        (S.Graph(S.Discrete(3), S.Discrete(2)), "nothing is known of a space Graph."),
    ],
)
def test_an_action_space_that_is_too_large_is_refused_with_a_way_out(space: Any, told: str) -> None:
    with pytest.raises(pschema.DeclarationError) as refused:
        body_of(S.Discrete(2), space)
    assert told in str(refused.value)
    assert 'Give attach() actions=, which says by name what may be done and what each is to the environment, as {"left": 0' in str(
        refused.value
    )
    assert len(str(refused.value)) < 600


def test_actions_of_ones_own_by_their_names() -> None:
    """A walker with six joints has too many actions; it can be told which of them to try."""
    stand, step = numpy.zeros(6), [0.5, -0.5, 0.0, 0.5, -0.5, 0.0]
    body = body_of(S.Discrete(2), S.Box(-1.0, 1.0, (6,)), actions={"stand": stand, "step": step})
    assert [(one.name, one.parameters) for one in body.describe().actions] == [("stand", {}), ("step", {})]
    lived(body, 40)
    assert {tuple(taken) for taken in body.env.taken} == {tuple(stand), tuple(step)}
    body.env.taken[0][:] = 7
    assert not stand.any(), "what the environment does to an action does not change the next one"

    many = body_of(S.Discrete(2), S.Discrete(5000), actions={f"go-{place}": place for place in range(0, 5000, 100)})
    (act,) = many.describe().actions
    assert (act.name, list(act.parameters)) == ("act", ["do"])
    lived(many, 100)
    assert len(set(many.env.taken)) > 30
    assert all(taken % 100 == 0 for taken in many.env.taken)


def test_actions_of_ones_own_by_a_function() -> None:
    turn = pschema.action("turn", by=pschema.integer(-1, 1))

    def perform(asked: pschema.Action) -> Any:
        return numpy.full(6, asked["by"], numpy.float32)

    body = body_of(S.Discrete(2), S.Box(-1.0, 1.0, (6,)), actions=[turn], perform=perform)
    lived(body, 40)
    assert {taken[0] for taken in body.env.taken} == {-1, 0, 1}


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"actions": {}}, "actions={}: give at least one action"),
        ({"actions": {"left": 7}}, "actions['left']: 7 (int) is no action of the environment, whose action space is Discrete(2)"),
        ({"actions": {"left": 0.5}}, "actions['left']: 0.5 (float) is no action of the environment"),
        ({"actions": {3: 0}}, "actions: 3 is no name"),
        ({"actions": {"a{": 0}}, "holds '{'"),
        ({"actions": [pschema.action("go")]}, "and perform=, a function"),
        ({"perform": lambda _: 0}, "give actions= as a dict"),
        ({"actions": {"left": 0}, "perform": lambda _: 0}, "perform= is for actions= that are declared"),
        ({"actions": 5, "perform": lambda _: 0}, "actions=5: give a dict"),
        ({"actions": ["go"], "perform": lambda _: 0}, "actions[0]: 'go' is none of them; give action(…)"),
        ({"actions": [pschema.action("go")], "perform": 5}, "perform=5: give a function"),
        ({"bins": 0}, "bins=0: give a whole number from 1"),
        ({"bins": 2.5}, "bins=2.5: give a whole number from 1"),
        ({"bins": True}, "bins=True: give a whole number from 1"),
        ({"senses": [], "observe": 5}, "observe=5: give a function"),
    ],
)
def test_what_is_said_wrong_of_an_environment_is_named(given: dict[str, Any], told: str) -> None:
    with pytest.raises(pschema.DeclarationError) as refused:
        body_of(S.Discrete(2), **given).describe()
    assert told in str(refused.value)


@pytest.mark.parametrize(
    ("env", "given", "told"),
    [
        (5, {}, "env=5: give an environment of Gymnasium, or the id of one"),
        (None, {}, "env=None: give an environment"),
        ("FrozenLake-v1", {"bins": 0}, "bins=0: give a whole number from 1"),
        ("FrozenLake-v1", {"seed": -1}, "seed=-1: give a whole number from 0"),
        ("FrozenLake-v1", {"seed": "a"}, "seed='a': give a whole number from 0"),
        ("FrozenLake-v1", {"stop": True}, "stop=True: give a pschema.Stop"),
        ("FrozenLake-v1", {"body": 5}, "body=5: give a text"),
        ("FrozenLake-v1", {"name": 5}, "name=5: give a text"),
    ],
)
def test_what_can_not_be_attached_is_refused_before_it_is(env: Any, given: dict[str, Any], told: str) -> None:
    with pytest.raises(pschema.Error) as refused:
        pschema.gym.attach(env, **given)
    assert told in str(refused.value)


def test_more_environments_than_places_are_refused_before_one_attaches() -> None:
    """Eight of nine bodies lived, and the ninth waited for a place."""
    env = gymnasium.vector.SyncVectorEnv([lambda: gymnasium.make("FrozenLake-v1")] * 9)
    with pytest.raises(
        pschema.DeclarationError, match=r"at most 8 bodies at a time, and there are 9 environments, .*: give a SyncVectorEnv of"
    ):
        pschema.gym.attach(env, "nobody")
    env.close()


def test_an_image_is_refused_with_a_way_out() -> None:
    with pytest.raises(pschema.DeclarationError, match=r"an image of 8×8×3 numbers.*observe="):
        body_of(S.Box(0, 255, (8, 8, 3), numpy.uint8))
    with pytest.raises(pschema.DeclarationError, match="both, or neither"):
        body_of(S.Discrete(2), senses=[])

    def bright(seen: Any) -> Iterator[pschema.Observation]:
        if seen.mean() > 100:
            yield "bright"

    body = body_of(S.Box(0, 255, (8, 8, 3), numpy.uint8), senses=[pschema.state("bright")], observe=bright)
    _, frames = lived(body, 5)
    assert frames[0] == ["bright"]


def test_an_episode_ends_and_the_next_begins() -> None:
    body = body_of(S.Discrete(100))
    learner, frames = lived(body, 14)
    ends = [[one for one in frame if one[0] == "end"] for frame in frames]
    # Each fifth step terminates and each seventh is cut off; the frame after such a one begins an episode, in which nothing was done.
    steps = body.env.steps
    assert [end[0][1][0] for end in ends if end] == ["terminated", "truncated", "terminated"]
    assert steps == 14 - 3
    assert all(not any(one[0] == "reward" for one in frames[at + 1]) for at, end in enumerate(ends[:-1]) if end)
    assert body.done == 3
    assert learner.steps == 14


def test_a_world_is_told_from_one_with_the_same_spaces() -> None:
    def kind(name: str, **given: Any) -> str:
        return pschema.gym.kind_in(gymnasium.make(name, **given))

    slippery, firm = kind("FrozenLake-v1"), kind("FrozenLake-v1", is_slippery=False)
    assert slippery.startswith("gym@FrozenLake-v1-")
    assert firm.startswith("gym@FrozenLake-v1-")
    assert slippery != firm
    assert slippery == kind("FrozenLake-v1", render_mode="ansi"), "how it is drawn is not what it is"
    assert len({kind(name) for name in ENVIRONMENTS}) == len(ENVIRONMENTS)
    assert all(len(kind(name)) <= pschema.gym.NAME_BYTES_MAX for name in ENVIRONMENTS)


def test_events_are_told_once() -> None:
    body = body_of(S.Discrete(3))
    learner = pschema.Learner(1)
    learner.declare(body.describe())
    action = learner.step(body.sense())
    assert action is not None
    body.act(action)
    assert [one[0] for one in body.sense()] == ["state", "reward"]
    assert [one[0] for one in body.sense()] == ["state"]


def test_the_reward_is_a_value_that_is_brought_when_asked_for() -> None:
    body = pschema.gym.EnvironmentBody(gymnasium.make("FrozenLake-v1", is_slippery=False), seed=1)
    assert [sense.name for sense in body.describe().senses if sense.value] == ["reward"]
    learner, outcome = pschema.Learner(2), None
    learner.declare(body.describe())

    def live(while_it: Callable[[], bool]) -> None:
        nonlocal outcome
        while while_it():
            action = learner.step(body.sense(), outcome)
            assert action is not None
            outcome = body.act(action)

    live(lambda: body.done < 400 and learner.steps < 6000)
    for most in (False, True):
        if most:
            learner.achieve(actions_max=60, most="reward")
        else:
            learner.achieve("reward{}", actions_max=60)
        live(lambda: learner.pursuit()["state"] == "pursued")
        end = learner.pursuit()
        if most:
            assert end["came"] >= 5, end
        else:
            assert end["achieved"], end


def test_the_same_seed_is_the_same_life() -> None:
    lives = [lived(pschema.gym.EnvironmentBody(gymnasium.make("Blackjack-v1"), seed=seed), 100) for seed in (4, 4, 5)]
    assert lives[0][0].digest == lives[1][0].digest != lives[2][0].digest


def test_minigrid_shows_things() -> None:
    body = pschema.gym.EnvironmentBody(gymnasium.make("MiniGrid-DoorKey-5x5-v0"), seed=1)
    names = [sense.name for sense in body.describe().senses]
    assert names == ["thing", "door", "wall", "carried", "direction", "reward", "end"]
    assert [one.name for one in body.describe().actions] == ["left", "right", "forward", "pickup", "drop", "toggle", "done"]
    seen = list(body.sense())
    # In the first episode of this seed a key is ahead and a locked door at the left, both yellow.
    assert ("thing", ("key", "yellow", 1, 0)) in seen
    assert ("door", ("locked", "yellow", 0, -1)) in seen
    lived(body, 300)


def test_vector_environments_are_several_bodies(sandbox: Sandbox) -> None:
    env = gymnasium.vector.SyncVectorEnv([lambda: gymnasium.make("FrozenLake-v1")] * 3)
    with sandbox.daemon("gym"), pschema.connect("gym") as client:
        summary = pschema.gym.attach(env, "gym", seed=1, episodes=2)
        assert summary.sessions == 3
        assert {body["name"] for body in client.status()["bodies"]} == {f"FrozenLake-v1-{number}" for number in range(3)}
    env.close()


def test_a_game_has_a_body_for_each_player(sandbox: Sandbox) -> None:
    pytest.importorskip("pettingzoo")
    with sandbox.daemon("game", arguments=["--set", 'learner.profile="paper"']), pschema.connect("game") as client:
        summary = pschema.gym.attach("pettingzoo:classic/tictactoe-v3", "game", seed=1, episodes=3)
        assert summary.sessions == 2
        assert summary.refused == 0
        bodies = client.status()["bodies"]
        assert {body["name"] for body in bodies} == {"player_1", "player_2"}
        assert all(body["frames_refused"] == 0 for body in bodies)
        # Moves onto marks that are there were not made, and were said to be refused; an episode's end is no failure.
        failures = {(body["last_failure"]["outcome"], body["last_failure"]["reason"]) for body in bodies if body["last_failure"]}
        assert failures <= {("refused", "the rules of the game do not allow it here")}
        assert summary.orders >= 3 * 5


def test_from_an_environment_to_a_goal_in_one_command(sandbox: Sandbox) -> None:
    command = [sys.executable, "-m", "pschema.gym", "FrozenLake-v1", "--name", "lake", "--seed", "1", "--set", "is_slippery=False"]
    command += ["--episodes", "60", "--goal", "field{field=4}"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    assert told.returncode == 0, told.stdout + told.stderr
    assert "Goal field{field=4}: achieved" in told.stdout
    # The daemon that it started is gone.
    with pytest.raises(pschema.NoDaemonError):
        pschema.connect("lake")


def test_the_daemon_of_a_command_ends_with_it(sandbox: Sandbox) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "pschema.gym", "FrozenLake-v1", "--name", "lake"], stderr=subprocess.DEVNULL, text=True
    )
    sandbox.processes.append(process)

    def daemon() -> Optional[int]:
        try:
            with pschema.connect("lake") as client:
                return int(client.status()["pid"]) if client.status()["step"] else None
        except pschema.NoDaemonError:
            return None

    pid = until("it lives", daemon)
    sandbox.note()
    process.kill()
    until("its daemon is gone", lambda: not os.path.exists(f"/proc/{pid}") or None)
    assert sandbox.left() == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["FrozenLake-v1"],
        ["FrozenLake-v1", "--episodes", "100000", "--goal", "field{field=15}"],
        ["pettingzoo:classic/tictactoe-v3"],
    ],
)
def test_a_command_ends_when_its_daemon_is_killed(sandbox: Sandbox, arguments: list[str]) -> None:
    """It waited for another daemon, which nobody would start."""
    if arguments[0].startswith(pschema.gym.GAME):
        pytest.importorskip("pettingzoo")
    process = subprocess.Popen(
        [sys.executable, "-m", "pschema.gym", *arguments, "--name", "lake"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    sandbox.processes.append(process)

    def daemon() -> Optional[int]:
        try:
            with pschema.connect("lake") as client:
                return int(client.status()["pid"]) if client.status()["step"] else None
        except pschema.NoDaemonError:
            return None

    pid = until("it lives", daemon)
    sandbox.note()
    os.kill(pid, signal.SIGKILL)
    _, told = finished(process, 1)
    assert "the daemon that was started for lake was killed by signal 9" in told
    assert "its memory was in RAM only" in told
    assert "Traceback" not in told


def test_minigrid_is_found_by_its_id(sandbox: Sandbox) -> None:
    text = """
        import pschema.gym
        print(pschema.gym.attach("MiniGrid-Empty-5x5-v0", "grid", seed=1, episodes=1, max_episode_steps=20))
    """
    with sandbox.daemon("grid"):
        out, _ = finished(sandbox.python(text))
    assert "sessions=1" in out


def test_a_game_by_the_command(sandbox: Sandbox) -> None:
    pytest.importorskip("pettingzoo")
    command = [sys.executable, "-m", "pschema.gym", "pettingzoo:classic/tictactoe-v3", "--episodes", "1", "--seed", "1"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    assert told.returncode == 0, told.stdout + told.stderr
    assert "2 players" in told.stdout


def test_the_command_says_what_is_wrong(sandbox: Sandbox) -> None:
    command = [sys.executable, "-m", "pschema.gym", "FrozenLake-v1", "--goal", "x{}"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    assert told.returncode == 2
    assert "--episodes" in told.stderr
    for wrong, words in [
        (["FrozenLake-v1", "--episodes", "0"], "a whole number from 1"),
        (["FrozenLake-v1", "--seed", "-1"], "a whole number from 0"),
        (["FrozenLake-v1", "--episodes", "1", "--set", "nope=3"], "can't be made with nope=3"),
        (["NoSuchThing-v1", "--episodes", "1"], "NoSuchThing-v1 can't be made"),
        (["FrozenLake-v1", "--episodes", "1", "--goal", "nope{}"], "nope"),
        # Before the episodes are lived: so many would take hours.
        (["FrozenLake-v1", "--episodes", "100000", "--goal", "field{field=99}"], "body FrozenLake-v1 declares field of field as 0..=15"),
    ]:
        command = [sys.executable, "-m", "pschema.gym", *wrong]
        told = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=False)
        assert told.returncode != 0, wrong
        assert words in told.stderr, told.stderr
        assert "Traceback" not in told.stderr, told.stderr


def test_an_environment_that_raises_is_lived_in_no_longer(sandbox: Sandbox) -> None:
    class Broken(gymnasium.Env):  # type: ignore[misc, name-defined]
        observation_space = S.Discrete(3)
        action_space = S.Discrete(2)

        def reset(self, *, seed: Optional[int] = None, options: Any = None) -> tuple[int, dict[str, Any]]:
            return 0, {}

        def step(self, action: int) -> Any:
            raise RuntimeError("the ice broke")

    with sandbox.daemon("gym"), pytest.raises(RuntimeError, match="the ice broke"):
        pschema.gym.attach(Broken(), "gym", episodes=3)
    with pytest.raises(pschema.DeclarationError, match="episodes='a'"):
        pschema.gym.attach(Broken(), "gym", episodes="a")  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_the_senses_do_not_depend_on_the_seed(name: str) -> None:
    bodies = [pschema.gym.EnvironmentBody(gymnasium.make(name), seed=seed) for seed in (1, 2)]
    described = [body.describe()._plain() for body in bodies]
    assert described[0] == described[1], "a body that came back under another seed would be refused"


def test_without_a_seed_episodes_are_drawn() -> None:
    begun = [list(pschema.gym.EnvironmentBody(gymnasium.make("CartPole-v1")).sense()) for _ in range(2)]
    assert begun[0] != begun[1]


class Rewarding(gymnasium.Env):  # type: ignore[misc, name-defined]
    """Five actions an episode, each with this reward."""

    observation_space = gymnasium.spaces.Discrete(6)
    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self, reward: Any) -> None:
        self.reward, self.at = reward, 0

    def reset(self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None) -> tuple[int, dict[str, Any]]:
        self.at = 0
        return 0, {}

    def step(self, action: Any) -> tuple[int, Any, bool, bool, dict[str, Any]]:
        self.at += 1
        return self.at, self.reward, self.at == 5, False, {}


def test_a_reward_may_be_an_array_of_one_number() -> None:
    body = pschema.gym.EnvironmentBody(Rewarding(numpy.array([0.5])), seed=1, episodes=2)
    lived(body, 11)
    assert (body.done, body.total) == (2, 2.5)


@pytest.mark.parametrize("reward", [None, "a", numpy.zeros(2)])
def test_a_reward_that_is_no_number_ends_the_life_in_an_environment(reward: Any) -> None:
    body = pschema.gym.EnvironmentBody(Rewarding(reward), seed=1)
    with pytest.raises(pschema.Error, match="which is no number"):
        lived(body, 3)
    assert body.broken is not None
    assert body.stop.is_set()


def test_what_attach_can_not_take_is_said() -> None:
    env = Rewarding(0.0)
    with pytest.raises(pschema.DeclarationError, match="episode: no such argument"):
        pschema.gym.attach(env, "nobody", episode=3)
    with pytest.raises(pschema.DeclarationError, match="episodes=True"):
        pschema.gym.EnvironmentBody(env, episodes=True)
    body = pschema.gym.EnvironmentBody(env, senses=[pschema.state("x")], observe=lambda _: None)  # type: ignore[arg-type, return-value]
    with pytest.raises(pschema.DeclarationError, match=r"observe\(\) returned None"):
        list(body.sense())
