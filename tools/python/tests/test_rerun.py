"""Learners in the Rerun viewer: what was written is read back."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import pschema

from .conftest import DEADLINE_S, Lamp, Sandbox, running, steps, until

numpy = pytest.importorskip("numpy")
rerun = pytest.importorskip("rerun")

from rerun.chunk import RrdReader  # noqa: E402

import pschema.rerun  # noqa: E402


def told(path: Path) -> dict[str, list[tuple[int, Any]]]:
    """What a recording holds: at each place what was logged, with its step."""
    found: dict[str, list[tuple[int, Any]]] = {}
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        if "step" not in batch.schema.names:
            continue
        steps = batch.column("step").to_pylist()
        for name in batch.schema.names:
            if name.split(":")[-1] in ("scalars", "text", "buffer", "positions", "colors"):
                rows = zip(steps, batch.column(name).to_pylist())
                found.setdefault(f"{chunk.entity_path} {name.split(':')[-1]}", []).extend(rows)
    return {place: sorted(rows, key=lambda row: row[0]) for place, rows in found.items()}


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "pschema.rerun", *arguments]


def done(*arguments: str, code: int = 0) -> str:
    ended = subprocess.run(command(*arguments), capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    assert ended.returncode == code, ended.stdout + ended.stderr
    return ended.stdout + ended.stderr


class Seen(Lamp):
    """A lamp in a field, that is seen."""

    def describe(self) -> pschema.Description:
        lamp = pschema.state("lamp", lit=pschema.boolean(), field=pschema.integer(0, 3))
        return pschema.Description(self.name, senses=[lamp], actions=[pschema.action("press"), pschema.action("rest")])

    def sense(self) -> list[pschema.Observation]:
        return [("lamp", (self.lit, 2))]

    def picture(self) -> Any:
        pixels = numpy.full((4, 8, 3), 255 * self.lit, numpy.uint8)
        return pixels, [(1.0 + 2 * number, 2.0, 1.0) for number in range(4)]


class Enough(pschema.rerun.Recording):
    """A recording that ends when it has some pictures."""

    def picture(self, *seen: Any) -> None:
        super().picture(*seen)
        if self.pictures == 5:
            raise StopIteration


def test_a_running_learner_with_its_pictures(sandbox: Sandbox, tmp_path: Path) -> None:
    path = tmp_path / "life.rrd"
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Seen(), "lamp"):
        stream = rerun.RecordingStream("test")
        stream.save(path)
        with pytest.raises(StopIteration):
            pschema.rerun.follow(client, Enough(stream))
        stream.flush()
        stream.disconnect()
        learnt = next(client.schemas(action="press"))
    found = told(path)
    counted = [step for step, _ in found["/memory/schemas scalars"]]
    assert counted == list(range(1, counted[-1] + 1))
    assert {text for _, (text,) in found["/world/state text"]} == {"lamp{lit=false, field=2}", "lamp{lit=true, field=2}"}
    assert {number for _, (number,) in found["/fields/lamp/false scalars"]} == {2}
    assert any(text.startswith(("press()", "rest()")) for _, (text,) in found["/mind/decision text"])
    new = [text for _, (text,) in found["/memory/new text"]]
    assert any(text.startswith(f"{learnt['id']} (") and "→ press() →" in text for text in new)
    assert {len(pixels) for _, (pixels,) in found["/world/camera buffer"]} == {4 * 8 * 3}
    # Each picture is with the step that it shows.
    states = dict(found["/world/state text"])
    assert all((pixels[0] == 255) == ("lit=true" in states[step][0]) for step, (pixels,) in found["/world/camera buffer"])
    # The field in which something is perceived is filled.
    _, colours = found["/world/camera/fields colors"][-1]
    assert [colour == colours[0] for colour in colours] == [True, True, False, True]


def test_a_life_on_disk(sandbox: Sandbox, tmp_path: Path) -> None:
    data, path = tmp_path / "memory", tmp_path / "life.rrd"
    with sandbox.daemon("lamp", data=data), pschema.connect("lamp") as client, running(Seen(), "lamp"):
        steps(client, 60)
    assert "40 steps" in done("--data", str(data), "--save", str(path), "--to", "40")
    found = told(path)
    assert [step for step, _ in found["/memory/schemas scalars"]] == list(range(1, 41))
    memory = pschema.Past(data, 40)
    assert len(found["/memory/new text"]) == memory.status()["schemas_total"] > 0
    # Each is told of in the step whose frame showed what the action before it had done.
    for (step, _), schema in zip(found["/memory/new text"], memory.schemas()):
        assert memory.show(schema["id"])["created_step"] + 1 == step
    some = tmp_path / "some.rrd"
    assert "3 steps" in done("--data", str(data), "--save", str(some), "--from", "20", "--to", "40", "--every", "10")
    assert [step for step, _ in told(some)["/memory/schemas scalars"]] == [20, 30, 40]


def test_it_ends_after_so_many_steps_with_the_daemon_and_at_ctrl_c(sandbox: Sandbox, tmp_path: Path) -> None:
    path = tmp_path / "life.rrd"
    with sandbox.daemon("lamp") as daemon, pschema.connect("lamp") as client, running(Seen(), "lamp"):
        steps(client, 100)
        assert "100 steps" in done("lamp", "--save", str(path), "--steps", "100")
        assert "it is there already" in done("lamp", "--save", str(path), code=1)
        assert [step for step, _ in told(path)["/memory/schemas scalars"]] == list(range(1, 101))
        begun = {end: tmp_path / f"{end}.rrd" for end in ("daemon", "signal")}
        both = {end: subprocess.Popen(command("lamp", "--save", str(own)), stdout=subprocess.PIPE, text=True) for end, own in begun.items()}
        sandbox.processes.extend(both.values())
        until("both have begun", lambda: all(own.exists() for own in begun.values()) or None)
        both["signal"].send_signal(signal.SIGINT)
        assert "steps" in both["signal"].communicate(timeout=DEADLINE_S)[0]
        daemon.end()
        assert "steps" in both["daemon"].communicate(timeout=DEADLINE_S)[0]
        assert {process.returncode for process in both.values()} == {0}


def test_there_is_nothing_to_show(sandbox: Sandbox, tmp_path: Path) -> None:
    path = tmp_path / "never.rrd"
    assert "nobody" in done("nobody", "--save", str(path), code=3)
    assert "nowhere" in done("--data", str(tmp_path / "nowhere"), "--save", str(path), code=1)
    assert not os.path.exists(path)
