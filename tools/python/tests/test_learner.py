"""A learner in this process: the same as a daemon's."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import pschema

from .conftest import Lamp, Sandbox, running, until


def lived(learner: pschema.Learner, steps: int, lamp: Any = None) -> list[str]:
    """Lets a lamp live so many steps; returns what it was asked for."""
    lamp = lamp or Lamp()
    learner.declare(lamp.describe())
    asked = []
    for _ in range(steps):
        action = learner.step(lamp.sense())
        assert action is not None
        asked.append(repr(action))
        lamp.act(action)
    return asked


def test_the_same_seed_is_the_same_life() -> None:
    learners = [pschema.Learner(seed) for seed in (7, 7, 8)]
    one, same, other = [lived(learner, 200) for learner in learners]
    assert one == same
    assert one != other
    assert learners[0].digest == learners[1].digest != learners[2].digest
    assert learners[0].steps == 200


@pytest.mark.parametrize("profile", ["full", "paper"])
def test_a_daemon_has_the_same_digest_for_the_same_frames(sandbox: Sandbox, profile: str) -> None:
    class Finite(Lamp):
        """A lamp that leaves after so many frames."""

        frames = 0

        def sense(self) -> Any:
            self.frames += 1
            if self.frames > 300:
                raise SystemExit
            return super().sense()

    settings = ["--set", f'learner.profile="{profile}"']
    with sandbox.daemon("twin", seed=5, arguments=settings), pschema.connect("twin") as client:
        with pytest.raises(SystemExit), running(Finite(), "twin"):
            until("the lamp has left", lambda: client.status()["step"] >= 300 or None)
            until("it is said", lambda: client.status()["bodies"][0]["state"] != "attached" or None)
        there = client.report()["memory_digest"] or client.status()["memory_digest"]
    here = pschema.Learner(5, profile=profile)
    lived(here, 300)
    assert here.digest == there


def test_what_is_saved_is_loaded_and_goes_on_alike(tmp_path: Path, sandbox: Sandbox) -> None:
    path = tmp_path / "lamp.jsonl"
    learner = pschema.Learner(3)
    lived(learner, 150)
    learner.save(path)
    again = [pschema.Learner.load(path) for _ in range(2)]
    assert [one.digest for one in again] == [learner.digest] * 2
    assert lived(again[0], 50) == lived(again[1], 50)
    assert again[0].steps == 200
    made = sandbox.command("import", str(path), "--data", str(tmp_path / "data"))
    assert made.returncode == 0, made.stderr
    assert learner.digest in made.stdout
    path.write_text(path.read_text().replace('"format":1', '"format":99', 1))
    with pytest.raises(pschema.Error, match=r"lamp\.jsonl"):
        pschema.Learner.load(path)
    with pytest.raises(OSError, match="cannot read"):
        pschema.Learner.load(tmp_path / "nowhere")
    with pytest.raises(OSError, match="cannot write"):
        learner.save(tmp_path / "no" / "folder")


def test_a_goal_is_achieved() -> None:
    learner, lamp = pschema.Learner(1), Lamp()
    lived(learner, 100, lamp)
    wanted = str(not lamp.lit).lower()
    assert learner.plan(f"lamp{{lit={wanted}}}")["probability"] > 0.5
    learner.achieve(f"lamp{{lit={wanted}}}", actions_max=5)
    for _ in range(6):
        action = learner.step(lamp.sense())
        if learner.pursuit()["state"] != "pursued":
            break
        assert action is not None
        lamp.act(action)
    assert learner.pursuit()["achieved"]
    assert str(lamp.lit).lower() == wanted
    with pytest.raises(pschema.AnswerError, match="lamp"):
        learner.achieve("lampe{}")
    for wrong in (0, -1, math.nan, "5", 2**40):
        with pytest.raises(pschema.ArgumentError, match="actions_max="):
            learner.achieve("lamp{lit=true}", actions_max=wrong)  # type: ignore[arg-type]
    with pytest.raises(pschema.AnswerError):
        learner.cancel()


def test_most_of_a_value_comes_and_a_goal_is_wanted_again() -> None:
    learner, at, comes = pschema.Learner(1), 0, 0
    place, points = pschema.state("place", at=pschema.integer(0, 4)), pschema.value("points", points=pschema.integer(-1, 9))
    learner.declare(pschema.Description("walker", senses=[place, points], actions=[pschema.action("left"), pschema.action("right")]))

    def live(while_it: Callable[[int], bool]) -> None:
        nonlocal at, comes
        for number in itertools.count():
            if not while_it(number):
                return
            action = learner.step([("place", (at,)), *([("points", (comes,))] if comes else [])])
            assert action is not None
            at = min(max(at + (1 if action.name == "right" else -1), 0), 4)
            comes = 9 if at == 4 else -1

    live(lambda number: number < 200)
    with pytest.raises(pschema.AnswerError, match="place is no value"):
        learner.achieve(most="place")
    with pytest.raises(pschema.AnswerError, match="most of points"):
        learner.achieve("place{at=1}", most="points")
    with pytest.raises(pschema.ArgumentError, match="again='yes'"):
        learner.plan("place{at=1}", again="yes")  # type: ignore[arg-type]
    assert learner.plan(most="points")["expected"] > 500
    learner.achieve(most="points", actions_max=20)
    live(lambda _: learner.pursuit()["state"] == "pursued")
    end = learner.pursuit()
    assert end["most"] == "points"
    assert end["state"] == "actions used up"
    assert end["came"] >= 9 * 16 - 4
    learner.achieve("place{at=4}", again=True, actions_max=9)
    live(lambda _: learner.pursuit()["state"] == "pursued")
    assert learner.pursuit()["achieved"]
    assert learner.pursuit()["again"]
    assert learner.pursuit()["actions"] > 0


def test_a_goal_beyond_what_is_declared_is_refused() -> None:
    dial = pschema.state("dial", at=pschema.integer(0, 9), of=pschema.symbol("red", "blue"), x=pschema.real(0, 1, 0.25, unit="m"))
    other = pschema.state("flag", of=pschema.symbol("green", "blue"))
    learner = pschema.Learner(1)
    learner.declare(pschema.Description("panel", senses=[dial, other], actions=[pschema.action("turn")]))
    learner.step([("dial", (0, "red", 0.0)), ("flag", ("green",))])
    for goal, told in (
        ("dial{at=10}", "dial{at=10} will never be so: body panel declares at of dial as 0..=9"),
        ("dial{at=-1}", "at of dial as 0..=9"),
        ("dial{x=1.4}", "x of dial as 0..=1 m"),
        ("dial{of=green}", "of of dial as red, blue"),
    ):
        for ask in (learner.achieve, learner.plan):
            with pytest.raises(pschema.AnswerError) as refused:
                ask(goal)
            assert told in str(refused.value)
    with pytest.raises(pschema.AnswerError, match="no observation type"):
        learner.achieve("lamp{}")
    learner.achieve("dial{at=9, of=blue, x=1.0}")


def test_it_can_be_asked() -> None:
    learner = pschema.Learner(1, profile="paper")
    lived(learner, 60)
    assert learner.status()["step"] == 60
    schemas = list(learner.schemas())
    assert schemas
    assert learner.show(schemas[0]["id"])["id"] == schemas[0]["id"]
    assert learner.explain()["step"] == 60
    assert learner.predict("press()")["outcomes"]
    assert learner.graph()["nodes"]
    with pytest.raises(pschema.AnswerError, match="there is no schema 9999"):
        learner.show(9999)


def test_a_frame_that_is_wrong_changes_nothing() -> None:
    learner, lamp = pschema.Learner(1), Lamp()
    with pytest.raises(pschema.DeclarationError, match="declare"):
        learner.step(lamp.sense())
    lived(learner, 5, lamp)
    before = learner.digest
    for wrong in ([("lamp", {"lit": 1.5})], [("lamp", (True, True))], [("lump", (True,))], ["lamp"], 3, None, [b"lamp"]):
        with pytest.raises(pschema.FrameError):
            learner.step(wrong)  # type: ignore[arg-type]
    assert learner.digest == before
    assert learner.step(lamp.sense()) is not None


def test_an_outcome_is_of_an_action() -> None:
    learner, lamp = pschema.Learner(1), Lamp()
    learner.declare(lamp.describe())
    with pytest.raises(pschema.FrameError, match="did not ask for"):
        learner.step(lamp.sense(), pschema.Outcome.done())
    for outcome in (
        pschema.Outcome.refused("no"),
        pschema.Outcome.failed("x" * 1_000_000),
        pschema.Outcome.timed_out(),
        pschema.Outcome.episode_ended(),
        pschema.Outcome.episode_cut(),
        pschema.Outcome.done(),
    ):
        learner.step(lamp.sense())
        learner.step(lamp.sense(), outcome)
    assert learner.steps == 12
    with pytest.raises(pschema.ArgumentError, match=r"outcome='done': give a pschema\.Outcome"):
        learner.step(lamp.sense(), "done")  # type: ignore[arg-type]
    with pytest.raises(pschema.DeclarationError, match=r"declare\(5\): give a pschema\.Description"):
        learner.declare(5)  # type: ignore[arg-type]


def test_two_bodies_of_one_learner() -> None:
    learner, one, other = pschema.Learner(1), Lamp("one"), Lamp("other")
    learner.declare(one.describe())
    learner.declare(other.describe())
    with pytest.raises(ValueError, match="say which one is meant"):
        learner.step(one.sense())
    for _ in range(20):
        for lamp in (one, other):
            action = learner.step(lamp.sense(), body=lamp.name)
            assert action is not None
            lamp.act(action)
    assert learner.steps == 40


def test_words_are_heard() -> None:
    learner, lamp = pschema.Learner(1), Lamp()
    lived(learner, 5, lamp)
    learner.say("light")
    learner.step(lamp.sense())
    assert {"type": "word", "properties": {"text": "light"}} in learner.explain()["world"]
    with pytest.raises(ValueError, match="is no word"):
        learner.say("two words")


def test_what_there_is_not_is_refused() -> None:
    with pytest.raises(ValueError, match='no profile "half"'):
        pschema.Learner(profile="half")
    with pytest.raises(ValueError, match="nowhere"):
        pschema.Learner(curriculum="nowhere")
    with pytest.raises(ValueError, match="sure"):
        pschema.Learner(settings=["learner.sure=1"])
    with pytest.raises(pschema.ArgumentError, match="seed=-1: give a whole number from 0"):
        pschema.Learner(-1)


def test_a_learner_that_another_thread_steps_says_so() -> None:
    learner = pschema.Learner(1)
    learner.declare(pschema.Description("lamp", [pschema.state("lamp")], [pschema.action("press")]))

    def sensed() -> Any:
        # While it takes the observations it is in use.
        with pytest.raises(pschema.Error, match="in use by another thread"):
            learner.step([])
        yield "lamp", ()

    learner.step(sensed())


@pytest.mark.parametrize("place", [3, None])
def test_a_path_that_is_none_is_refused_by_name(place: Any) -> None:
    with pytest.raises(pschema.ArgumentError, match=r"path=.*: give the path of a file"):
        pschema.Learner(1).save(place)
    with pytest.raises(pschema.ArgumentError, match="path="):
        pschema.Learner.load(place)


def test_arguments_of_a_daemon_are_a_list_of_texts() -> None:
    for arguments in ("--set", [3]):
        with pytest.raises(pschema.ArgumentError, match="arguments"):
            pschema.Daemon("nobody", arguments=arguments)  # type: ignore[arg-type]
