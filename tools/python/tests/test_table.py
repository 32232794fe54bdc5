"""The simulated arm as an environment of Gymnasium."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import pytest

import pschema

from .conftest import DEADLINE_S, Sandbox
from .test_gym import lived

gymnasium = pytest.importorskip("gymnasium")
numpy = pytest.importorskip("numpy")
import pschema.gym  # noqa: E402
from pschema.table import Table  # noqa: E402


def made(**options: Any) -> Any:
    return gymnasium.make("pschema/Table-v0", **options)


def touching(table: Table) -> int:
    """The action that touches the first block: the posture whose finger is seen where the block is."""
    (field,) = [values[1] for name, values in table.sensed if name == "object"]
    empty = Table(table.world, blocks=0)
    empty.reset(seed=0)
    for action in range(len(table.meanings)):
        if empty.step(action)[0]["finger"] == field:
            return action
    raise AssertionError(f"no posture has its finger in field {field}")


@pytest.mark.parametrize("options", [{}, {"world": "narrow", "blocks": 2}, {"world": "block-and-ball", "reward": "none"}])
def test_gymnasium_s_checker_has_nothing_to_say(options: dict[str, Any]) -> None:
    from gymnasium.utils.env_checker import check_env

    env = made(render_mode="rgb_array", **options)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


def test_it_is_made_without_another_import() -> None:
    text = """if True:
        import gymnasium
        env = gymnasium.make("pschema.gym:pschema/Table-v0", world="narrow")
        assert env.spec.max_episode_steps == 20
    """
    told = subprocess.run([sys.executable, "-W", "error", "-c", text], capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    assert told.returncode == 0, told.stderr
    assert told.stderr == ""


def test_the_spaces_are_those_of_the_world() -> None:
    table = made().unwrapped
    assert table.action_space.n == len(table.meanings) == 224
    assert str(table.meanings[0]).startswith("move(j1=")
    assert table.colours == ("blue", "red", "yellow")
    assert table.sides == ("left", "right", "near", "far")
    assert len(table.places) == 100
    seen, info = table.reset(seed=1, options={"places": [40]})
    assert seen["finger"] == table.fields == table.observation_space["finger"].n - 1
    assert list(seen["objects"]) == [table.places[40], table.fields, table.fields]
    assert info["sensed"] == [("object", ("blue", table.places[40]))]
    pushes = made(world="block-and-ball").unwrapped
    assert str(pushes.meanings[-1]).startswith("push(")


def test_a_touch_is_the_reward_and_ends_the_episode() -> None:
    env = made(world="narrow")
    seen, _ = env.reset(seed=3)
    action = touching(env.unwrapped)
    seen, reward, terminated, truncated, info = env.step(action)
    assert (reward, terminated, truncated, info["outcome"]) == (1.0, True, False, "done")
    assert seen["touch"] == 1
    assert seen["contact"].sum() >= 1
    free = made(world="narrow", reward="none")
    free.reset(seed=3)
    seen, reward, terminated, _, _ = free.step(action)
    assert (seen["touch"], reward, terminated) == (1, 0.0, False)


def test_the_same_seed_is_the_same_world() -> None:
    def life(seed: int) -> list[Any]:
        env = made(blocks=3)
        told: list[Any] = []
        for episode in range(3):
            told.append(env.reset(seed=seed if episode == 0 else None))
            told.extend(env.step(action) for action in (5, 100, 200))
        return told

    assert repr(life(1)) == repr(life(1)) != repr(life(2))
    # What was before is nothing to an episode with a seed.
    env = made()
    env.reset(seed=9)
    env.step(17)
    assert repr(env.reset(seed=1)) == repr(made().reset(seed=1))


def test_what_is_not_in_the_world_is_refused(tmp_path: Path) -> None:
    for options, told in (
        ({"world": "nowhere.toml"}, "nowhere.toml"),
        ({"blocks": 4}, "blocks=4: wide has 3: blue-block, red-block, yellow-block"),
        ({"blocks": ["green-block"]}, "no object 'green-block'"),
        ({"reward": "money"}, "reward='money'"),
        ({"render_mode": "human"}, "render_mode='human'"),
    ):
        with pytest.raises(ValueError, match=told):
            Table(**options)
    table = Table(blocks=["red-block"])
    with pytest.raises(ValueError, match="1 are wanted"):
        table.reset(options={"places": [1, 2]})
    with pytest.raises(ValueError, match="no such object or position"):
        table.reset(options={"places": [10_000]})
    for action in (224, -1):
        with pytest.raises(IndexError, match=f"there is no action {action}: there are 224"):
            table.step(action)
    broken = tmp_path / "broken.toml"
    broken.write_text("[table]\nwidth_mm = 1\n")
    with pytest.raises(ValueError, match=r"broken\.toml.*line 2"):
        Table(str(broken))


def test_as_a_body_it_is_the_body_of_the_simulator() -> None:
    body = pschema.gym.EnvironmentBody(made(world="narrow"), seed=1)
    told = body.describe()
    assert [sense.name for sense in told.senses] == ["finger", "object", "touch", "contact", "reward", "end"]
    assert [one.name for one in told.actions] == ["move"]
    learner, frames = lived(body, 50)
    assert learner.steps == 50
    assert frames[0][0][0] == "object"


def test_several_are_bodies_of_one_learner(sandbox: Sandbox) -> None:
    env = gymnasium.make_vec("pschema/Table-v0", num_envs=2, vectorization_mode="sync", world="narrow")
    with sandbox.daemon("table"), pschema.connect("table") as client:
        assert pschema.gym.attach(env, "table", seed=1, episodes=1).refused == 0
        assert {body["name"] for body in client.status()["bodies"]} == {"pschema/Table-v0-0", "pschema/Table-v0-1"}
    env.close()


def test_it_attaches_by_its_id(sandbox: Sandbox) -> None:
    with sandbox.daemon("table"), pschema.connect("table") as client:
        summary = pschema.gym.attach("pschema/Table-v0", "table", seed=1, episodes=2, world="narrow")
        assert summary.refused == 0
        assert client.status()["bodies"][0]["name"] == "pschema/Table-v0"
