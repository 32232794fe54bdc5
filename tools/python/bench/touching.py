"""How soon learners touch a block on the simulated table (``pschema/Table-v0``), and how often then.

    python tools/python/bench/touching.py [--seeds 5] [--steps 100 300 1000 3000] [--only pschema q-learning random ppo] [--json]

A block lies at a place that is drawn anew in each episode, which ends when it is touched or after 20 actions. After so many actions of
learning, each learner is measured in the same 50 episodes, in which nothing is learnt:

* ``random`` takes any posture;
* ``ppo`` is Stable-Baselines3's, with its defaults but ``n_steps=256``, so that it learns before 2048 actions; measured by the actions
  that it draws;
* ``q-learning`` has a table of the fields in which objects are seen (ε = 0.1, α = 0.5, γ = 0.9); measured by its best action, any of
  them where several are;
* ``pschema`` lives by its own choices, and is measured by what it does when it is told ``achieve touch{}``, each
  time by a copy of its memory.

``ppo`` needs ``pip install stable-baselines3``, which brings torch; without it the others are measured.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, Callable, Optional

import gymnasium
import numpy

import pschema
import pschema.gym

#: The seed of the episodes in which all are measured.
MEASURED = 90_000
#: How many actions an episode has at most.
ACTIONS_MAX = 20

#: From an observation to an action.
Policy = Callable[[dict[str, Any]], int]
#: After so many actions: the share of the episodes in which the block was touched, and the mean number of actions of those.
Measured = tuple[int, float, float]


def table() -> Any:
    return gymnasium.make("pschema/Table-v0")


def measured(policy: Policy, episodes: int) -> tuple[float, float]:
    env, lengths = table(), []
    seen, _ = env.reset(seed=MEASURED)
    for _ in range(episodes):
        for action in range(ACTIONS_MAX):
            seen, _, touched, cut, _ = env.step(policy(seen))
            if touched:
                lengths.append(action + 1)
            if touched or cut:
                break
        seen, _ = env.reset()
    return len(lengths) / episodes, statistics.fmean(lengths) if lengths else float("nan")


def by_chance(seed: int, points: list[int], episodes: int) -> Iterator[Measured]:
    random, actions = numpy.random.default_rng(seed), int(table().action_space.n)
    share, length = measured(lambda _: int(random.integers(actions)), episodes)
    yield from ((point, share, length) for point in points)


def q_learning(seed: int, points: list[int], episodes: int) -> Iterator[Measured]:
    random, env = numpy.random.default_rng(seed), table()
    actions = int(env.action_space.n)
    values: dict[bytes, Any] = {}

    def of(seen: dict[str, Any]) -> Any:
        return values.setdefault(seen["objects"].tobytes(), numpy.zeros(actions))

    def best(seen: dict[str, Any]) -> int:
        own = of(seen)
        return int(random.choice(numpy.flatnonzero(own == own.max())))

    seen, _ = env.reset(seed=seed)
    taken = 0
    for point in points:
        while taken < point:
            action = int(random.integers(actions)) if random.random() < 0.1 else best(seen)
            then, reward, ended, cut, _ = env.step(action)
            target = float(reward) + (0.0 if ended else 0.9 * of(then).max())
            of(seen)[action] += 0.5 * (target - of(seen)[action])
            seen = env.reset()[0] if ended or cut else then
            taken += 1
        yield (point, *measured(best, episodes))


def ppo(seed: int, points: list[int], episodes: int) -> Iterator[Measured]:
    import torch
    from stable_baselines3 import PPO

    torch.set_num_threads(1)
    env = table()
    model = PPO("MultiInputPolicy", env, seed=seed, n_steps=256, device="cpu")
    for point in points:
        model.learn(point - model.num_timesteps, reset_num_timesteps=False)
        yield (point, *measured(lambda seen: int(model.predict(seen, deterministic=False)[0]), episodes))


def of_pschema(seed: int, points: list[int], episodes: int) -> Iterator[Measured]:
    body = pschema.gym.EnvironmentBody(table(), seed=seed)
    learner = pschema.Learner(seed)
    learner.declare(body.describe())
    outcome: Optional[pschema.Outcome] = None
    taken = 0
    for point in points:
        while taken < point:
            outcome = body.act(chosen(learner, body, outcome))
            # What begins an episode is no action.
            taken += outcome is None
        yield (point, *achieved(learner, episodes))


def chosen(learner: pschema.Learner, body: pschema.Body, outcome: Optional[pschema.Outcome]) -> pschema.Action:
    action = learner.step(body.sense(), outcome)
    assert action is not None, "a learner that lives by its own choices always acts"
    return action


def achieved(learner: pschema.Learner, episodes: int) -> tuple[float, float]:
    lengths = []
    with tempfile.TemporaryDirectory() as folder:
        memory = Path(folder) / "memory"
        learner.save(memory)
        body = pschema.gym.EnvironmentBody(table(), seed=MEASURED)
        for episode in range(1, episodes + 1):
            copy = pschema.Learner.load(memory)
            copy.declare(body.describe())
            copy.achieve("touch{}", actions_max=ACTIONS_MAX)
            outcome: Optional[pschema.Outcome] = None
            while body.done < episode:
                outcome = body.act(chosen(copy, body, outcome))
            if body.total:
                lengths.append(body.length)
            # Whatever is done begins the next episode.
            body.act(chosen(copy, body, outcome))
    return len(lengths) / episodes, statistics.fmean(lengths) if lengths else float("nan")


LEARNERS = {"random": by_chance, "ppo": ppo, "q-learning": q_learning, "pschema": of_pschema}


def life(name: str, seed: int, points: list[int], episodes: int) -> dict[str, Any]:
    began = time.perf_counter()
    told = list(LEARNERS[name](seed, points, episodes))
    return {"learner": name, "seed": seed, "seconds": time.perf_counter() - began, "measured": told}


def between(shares: list[float]) -> str:
    return f"{statistics.median(shares):.0%} ({min(shares):.0%} to {max(shares):.0%})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5, help="how many lives of each")
    parser.add_argument("--steps", type=int, nargs="+", default=[100, 300, 1000, 3000], help="actions after which they are measured")
    parser.add_argument("--episodes", type=int, default=50, help="in which they are measured")
    parser.add_argument("--only", nargs="+", choices=list(LEARNERS), default=list(LEARNERS), metavar="LEARNER")
    parser.add_argument("--jobs", type=int, default=1, help="lives at once")
    parser.add_argument("--json", action="store_true", help="a line for each life, and no table")
    given = parser.parse_args()
    names = given.only
    if "ppo" in names and importlib.util.find_spec("stable_baselines3") is None:
        print("ppo is left out: pip install stable-baselines3", file=sys.stderr)
        names = [name for name in names if name != "ppo"]
    points, lives = sorted(given.steps), []
    with ProcessPoolExecutor(given.jobs) as pool:
        waited = [pool.submit(life, name, seed, points, given.episodes) for name in names for seed in range(1, given.seeds + 1)]
        for one in waited:
            lives.append(one.result())
            if given.json:
                print(json.dumps(lives[-1]), flush=True)
    if given.json:
        return
    print("| learner | " + " | ".join(f"after {point:,}" for point in points) + " | actions, if touched |")
    print("|---|" + "---|" * (len(points) + 1))
    for name in names:
        own = [one["measured"] for one in lives if one["learner"] == name]
        shares = [between([told[at][1] for told in own]) for at in range(len(points))]
        lengths = [told[-1][2] for told in own if told[-1][2] == told[-1][2]]
        print(f"| `{name}` | " + " | ".join(shares) + f" | {statistics.median(lengths) if lengths else float('nan'):.1f} |")


if __name__ == "__main__":
    main()
