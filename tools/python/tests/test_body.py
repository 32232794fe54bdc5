"""Bodies with real daemons, and what befalls them."""

from __future__ import annotations

import contextlib
import inspect
import logging
import os
import re
import signal
import textwrap
import time
from collections.abc import Iterator
from typing import Any, Callable, Optional

import pytest

import pschema

from .conftest import Lamp, Sandbox, finished, running, steps, until


def shown(kind: type) -> str:
    """The program that the documentation of a class shows."""
    (text,) = re.findall(r"A lamp::\n\n(.*?)(?=\n\S|\Z)", inspect.getdoc(kind) or "", re.DOTALL)
    return "import pschema\n" + textwrap.dedent(text)


#: The lamp of the documentation, as a program.
LAMP = shown(pschema.Body) + "\nprint(pschema.run(Lamp()))\n"


def test_a_lamp_is_at_most_fifteen_lines() -> None:
    assert sum(bool(line.strip()) for line in LAMP.splitlines()) <= 15


def test_a_lamp_in_functions_lives(sandbox: Sandbox) -> None:
    text = shown(pschema.FunctionBody)
    assert sum(bool(line.strip()) for line in text.splitlines()) <= 15
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        lamp = sandbox.python(text, "--name", "lamp")
        steps(client, 50)
        assert client.achieve("light{lit=true}", actions_max=10)["achieved"]
        lamp.terminate()
        finished(lamp)
        assert client.status()["bodies"][0]["frames_refused"] == 0


def test_functions_sense_and_act() -> None:
    body = pschema.FunctionBody("crane", kind="toy")
    lifted: list[float] = []

    @body.state(of=pschema.symbol("a", "b"))
    def crate() -> Iterator[Any]:
        yield ("a",)
        yield {"of": "b"}

    @body.state(own=True, height=pschema.real(0, 1, 0.1))
    def hook() -> Optional[tuple[float]]:
        return (lifted[-1],) if lifted else None

    @body.event(name="bump")
    def has_bumped() -> bool:
        return lifted[-1:] == [1.0]

    @body.action(primitives=[(0.5,), (1.0,)], height=pschema.real(0, 1, 0.1))
    def lift(height: float) -> Optional[pschema.Outcome]:
        if lifted[-1:] == [height]:
            return pschema.Outcome.refused("it is there")
        lifted.append(height)
        return None

    told = body.describe()
    assert [(sense.name, sense.own, sense.transient) for sense in told.senses] == [
        ("crate", False, False),
        ("hook", True, False),
        ("bump", False, True),
    ]
    assert told.kind == "toy"
    learner = pschema.Learner(1)
    learner.declare(told)
    frame = list(body.sense())
    assert frame == [("crate", ("a",)), ("crate", {"of": "b"})]
    outcomes = set()
    for _ in range(40):
        ordered = learner.step(body.sense())
        assert ordered is not None
        outcome = body.act(ordered)
        outcomes.add(None if outcome is None else outcome.kind)
    assert outcomes == {None, "refused"}
    assert set(lifted) == {0.5, 1.0}
    lifted.append(1.0)
    assert list(body.sense())[2:] == [("hook", (1.0,)), "bump"]


def test_functions_that_do_not_fit_are_refused() -> None:
    body = pschema.FunctionBody("lamp")
    body.state(lit=pschema.boolean())(lambda: {"lit": True})
    with pytest.raises(pschema.DeclarationError, match="declared twice"):
        body.state()(lambda: True)

    def press(hard: bool) -> None:
        raise AssertionError(hard)

    with pytest.raises(pschema.DeclarationError, match=r"press\(\) does not take its parameters"):
        body.action(soft=pschema.boolean())(press)
    with pytest.raises(pschema.DeclarationError):
        body.action(hard=1)(press)  # type: ignore[arg-type]


def test_a_lamp_lives_and_leaves_at_ctrl_c(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        lamp = sandbox.python(LAMP, "--name", "lamp")
        steps(client, 100)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            lamp.send_signal(number)
            out, err = finished(lamp)
            assert "ending='stopped', sessions=1" in out
            assert "Traceback" not in err
            # It said farewell: it is not found dead.
            until("the lamp has left", lambda: client.status()["bodies"][0]["state"] == "left" or None)
            lamp = sandbox.python(LAMP, "--name", "lamp")
            until("it is back", lambda: client.status()["bodies"][0]["state"] == "attached" or None)
        lamp.send_signal(signal.SIGINT)
        finished(lamp)
        assert next(client.schemas(action="press"))["executions"] > 0
    assert sandbox.left() == []


def test_it_leaves_at_ctrl_c_while_it_waits_for_a_daemon(sandbox: Sandbox) -> None:
    lamp = sandbox.python(LAMP, "--name=nobody")
    assert lamp.stderr is not None
    assert "waiting to attach" in lamp.stderr.readline()
    lamp.send_signal(signal.SIGINT)
    began = time.monotonic()
    out, _ = finished(lamp)
    assert "ending='stopped', sessions=0" in out
    assert time.monotonic() - began < 10


def test_it_leaves_at_ctrl_c_while_the_learner_is_held(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        lamp = sandbox.python(LAMP, "--name", "lamp")
        steps(client, 10)
        client.stage("hold")
        lamp.send_signal(signal.SIGINT)
        finished(lamp)


def test_the_python_process_is_killed_and_comes_back(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        lamp = sandbox.python(LAMP, "--name", "lamp")
        steps(client, 50)
        lamp.kill()
        lamp.wait()
        until("the lamp is lost", lambda: client.status()["bodies"][0]["state"] == "lost" or None)
        before = client.status()["step"]
        again = sandbox.python(LAMP, "--name", "lamp")
        steps(client, before + 50)
        again.terminate()
        finished(again)
    assert sandbox.left() == []


def test_the_daemon_is_killed_and_comes_back(sandbox: Sandbox, tmp_path: Any) -> None:
    daemon = sandbox.daemon("lamp", data=tmp_path)
    with running(Lamp(), "lamp"), pschema.connect("lamp") as client:
        before = steps(client, 50)
        os.kill(daemon.pid, signal.SIGKILL)
        daemon.end()
        with pytest.raises(pschema.NoDaemonError):
            client.status()
        with sandbox.daemon("lamp", data=tmp_path):
            # The same connection finds the next daemon, and so does the body.
            assert steps(client, before + 50) > before
    assert sandbox.left() == []


def test_it_ends_with_its_daemon_if_told_so(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp") as daemon:
        lamp = sandbox.python(LAMP.replace("Lamp())", "Lamp(), exit_when_daemon_gone=True)"), "--name", "lamp")
        with pschema.connect("lamp") as client:
            steps(client, 5)
        os.kill(daemon.pid, signal.SIGKILL)
        daemon.end()
        out, _ = finished(lamp)
        assert "ending='daemon-gone'" in out


def test_it_leaves_when_its_daemon_is_ended(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp") as daemon:
        lamp = sandbox.python(LAMP, "--name", "lamp")
        with pschema.connect("lamp") as client:
            steps(client, 5)
        daemon.end()
        out, _ = finished(lamp)
        assert "ending='detached'" in out


def test_an_exception_in_act_is_an_action_that_failed(sandbox: Sandbox, caplog: pytest.LogCaptureFixture) -> None:
    class Broken(Lamp):
        def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
            if action.name == "press":
                raise RuntimeError("the button is stuck " + "x" * 100_000)
            return None

    with caplog.at_level(logging.ERROR, "pschema"), sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with running(Broken(), "lamp"):
            steps(client, 50)
            body = client.status()["bodies"][0]
        assert body["last_failure"]["outcome"] == "failed"
        assert body["last_failure"]["reason"].startswith("RuntimeError: the button is stuck xxx")
        assert len(body["last_failure"]["reason"]) == 256
        assert body["frames_refused"] == 0
    # Once, with its trace, however often it came.
    assert [record.exc_info is not None for record in caplog.records if record.name == "pschema"] == [True]


def test_an_exception_that_can_not_be_said_is_an_action_that_failed(sandbox: Sandbox, caplog: pytest.LogCaptureFixture) -> None:
    """Its text is what asking for it raises: it was guarded against, and never tried."""

    class Mute(Exception):
        def __str__(self) -> str:
            raise RuntimeError("no words")

    class Broken(Lamp):
        def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
            raise Mute

    with caplog.at_level(logging.ERROR, "pschema"), sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with running(Broken(), "lamp"):
            steps(client, 20)
            failure = client.status()["bodies"][0]["last_failure"]
        assert (failure["outcome"], failure["reason"]) == ("failed", "Mute")
    assert [record.getMessage() for record in caplog.records if record.name == "pschema"] == [
        "an action of Broken failed; said once until it fails otherwise"
    ]


def test_an_outcome_is_told(sandbox: Sandbox) -> None:
    class Weary(Lamp):
        def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
            return pschema.Outcome.refused("it is too heavy")

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Weary(), "lamp"):
        steps(client, 5)
        failure = client.status()["bodies"][0]["last_failure"]
        assert (failure["outcome"], failure["reason"]) == ("refused", "it is too heavy")


class Fault(Lamp):
    """A lamp that senses something wrong after a while."""

    def __init__(self, wrong: Callable[[], Any]) -> None:
        super().__init__()
        self.wrong = wrong

    def describe(self) -> pschema.Description:
        senses = [
            pschema.state("lamp", lit=pschema.boolean()),
            pschema.state("at", x=pschema.real(0, 1, 0.1), of=pschema.symbol("a", "b"), n=pschema.integer(0, 9)),
        ]
        return pschema.Description("lamp", senses=senses, actions=[pschema.action("press")])

    def sense(self) -> Any:
        return super().sense() if self.pressed < 5 else self.wrong()

    def act(self, action: pschema.Action) -> None:
        self.pressed += 1


def at(x: Any = 0.5, of: Any = "a", n: Any = 1) -> list[Any]:
    return [("lamp", (True,)), ("at", {"x": x, "of": of, "n": n})]


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda: at(x=float("nan")), "observation 1 (at): property x = NaN is outside 0..=1"),
        (lambda: at(x=float("inf")), "property x = inf is outside 0..=1"),
        (lambda: at(x=1.5), "property x = 1.5 is outside 0..=1"),
        (lambda: at(x=True), "observation 1 (at): property x: True (bool) given where a real is declared"),
        (lambda: at(x="1"), "'1' (str) given where a real is declared"),
        (lambda: at(of="c"), 'observation 1 (at): property of: "c" is none of the symbols declared: "a", "b"'),
        (lambda: at(of="c" * 5_000_000), "is none of the symbols declared"),
        (lambda: at(of=0), "0 (int) given where a symbol is declared"),
        (lambda: at(n=10), "observation 1 (at): property n = 10 is outside 0..=9"),
        (lambda: at(n=10**30), "given where an integer of 64 bits is declared"),
        (lambda: at(n=1.0), "1.0 (float) given where an integer of 64 bits is declared"),
        (lambda: [("at", {"x": 0.5})], "observation 0 (at): property of is not given"),
        (lambda: [("lamp", {"lit": True, "lot": True})], "is more than the properties that are declared"),
        (lambda: [("lamp", ())], "observation 0 (lamp): 0 values, 1 are declared: lit"),
        (lambda: ["lamp"], "observation 0 (lamp): 0 values, 1 are declared: lit"),
        (lambda: [("lump", (True,))], 'observation 0: no sense "lump" is declared; there are: at, lamp'),
        (lambda: [("lamp", "yes")], "'yes' (str) is neither a dict nor a tuple of values"),
        (lambda: [7], "observation 0: 7 (int) is no observation"),
        (lambda: 7, "7 (int) was reported where a list of observations is wanted"),
        (lambda: None, "nothing was reported"),
        (lambda: [("lamp", (True,))] * 5000, "more than 4096 observations"),
    ],
)
def test_what_is_sensed_wrong_is_raised_with_its_place(sandbox: Sandbox, wrong: Callable[[], Any], told: str) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with pytest.raises(pschema.FrameError) as raised, running(Fault(wrong), "lamp"):
            until("the body is gone", lambda: (client.status()["bodies"][-1:] and client.status()["bodies"][0]["state"] == "left") or None)
        assert told in str(raised.value)
        assert len(str(raised.value)) < 2_000
        # Nothing wrong was sent, and nothing was learnt of it.
        assert client.status()["step"] == 5


def test_an_exception_in_sense_is_raised(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with pytest.raises(ZeroDivisionError), running(Fault(lambda: 1 / 0), "lamp"):
            until("the body is gone", lambda: (client.status()["bodies"] and client.status()["bodies"][0]["state"] == "left") or None)
        assert client.status()["step"] == 5


def test_what_act_returns_is_an_outcome(sandbox: Sandbox) -> None:
    class Talkative(Lamp):
        def act(self, action: pschema.Action) -> Any:
            return "pressed"

    with sandbox.daemon("lamp"), pytest.raises(TypeError, match=r"act\(\) returned a str"):
        pschema.run(Talkative(), "lamp")


def test_two_bodies_of_one_name(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Lamp(), "lamp"):
        steps(client, 5)
        with pytest.raises(pschema.RefusedError, match="body lamp is attached already") as refused:
            pschema.run(Lamp(), "lamp")
        assert refused.value.code == 21
        assert steps(client, 5)


def test_a_daemon_with_as_many_bodies_as_it_takes(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, contextlib.ExitStack() as lamps:
        for number in range(8):
            lamps.enter_context(running(Lamp(f"lamp-{number}"), "lamp"))
        until("they are attached", lambda: sum(body["state"] == "attached" for body in client.status()["bodies"]) == 8 or None)
        with pytest.raises(pschema.RefusedError, match="already has 8 bodies, which is all it takes") as refused:
            pschema.run(Lamp("ninth"), "lamp")
        assert refused.value.code == 0


def test_a_declaration_that_contradicts_what_was_learnt(sandbox: Sandbox) -> None:
    class Other(Lamp):
        def describe(self) -> pschema.Description:
            lamp = pschema.state("lamp", lit=pschema.integer(0, 1))
            return pschema.Description("lamp", senses=[lamp], actions=[pschema.action("press")])

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with running(Lamp(), "lamp"):
            steps(client, 5)
        with pytest.raises(pschema.RefusedError, match="lit") as refused:
            pschema.run(Other(), "lamp")
        assert refused.value.code == 16
    with sandbox.daemon("lamp", arguments=["--accept-changes"]), pschema.connect("lamp") as client:
        with running(Lamp(), "lamp"):
            steps(client, 5)
        with pytest.raises(pschema.RefusedError) as refused:
            pschema.run(Other(), "lamp")
        # In words, and not as a program is written.
        told = "observation type lamp is already known with other flags or properties: it is a state {lit: a boolean}; declare it the same"
        assert told in str(refused.value)


def test_a_run_that_cannot_begin() -> None:
    class Silent(pschema.Body):
        pass

    with pytest.raises(NotImplementedError, match=r"Silent has no describe\(\)"):
        pschema.run(Silent())
    with pytest.raises(ValueError, match="Not A Name"):
        pschema.run(Lamp(), "Not A Name")


def test_a_process_that_was_forked_while_attached(sandbox: Sandbox) -> None:
    forks = """
        import os, pschema

        class Forks(pschema.Body):
            acted = 0

            def describe(self):
                return pschema.Description("forks", actions=[pschema.action("go")])

            def sense(self):
                return []

            def act(self, action):
                self.acted += 1
                if self.acted == 3:
                    child = os.fork()
                    if child:
                        print("child", os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)

        pschema.run(Forks(), "forks")
    """
    with sandbox.daemon("forks"), pschema.connect("forks") as client:
        body = sandbox.python(forks)
        steps(client, 50)
        body.terminate()
        out, err = finished(body)
        assert "child 70" in out
        assert "this process was forked while a body was attached" in err
        assert client.status()["bodies"][0]["frames_refused"] == 0


def test_other_threads_go_on_while_a_body_waits(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Lamp(), "lamp"):
        steps(client, 5)
        client.stage("hold")
        began, counted = time.perf_counter(), 0
        while time.perf_counter() - began < 0.2:
            counted += 1
        assert counted > 10_000


def test_a_picture_is_shown(sandbox: Sandbox) -> None:
    numpy = pytest.importorskip("numpy")

    class Seeing(Lamp):
        def picture(self) -> Any:
            pixels = numpy.zeros((4, 6, 3), numpy.uint8)
            pixels[..., 0] = 255 * self.lit
            return pixels, [(3.0, 2.0, 1.5)]

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Seeing(), "lamp"):
        steps(client, 5)
        # It shows where the fields are, which come with the picture alone.
        shown = sandbox.command("--name", "lamp", "watch", "--once", "--width", "120", "--height", "40")
        assert shown.returncode == 0, shown.stderr
        assert "camera: lamp" in shown.stdout


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ("numpy.zeros((4, 6))", "picture() returned float64 of the shape (4, 6): height × width × 3 of uint8 are wanted"),
        ("numpy.zeros((4, 6, 3))", "picture() returned float64 of the shape (4, 6, 3): height × width × 3 of uint8 are wanted"),
        ("numpy.zeros((0, 6, 3), numpy.uint8)", "picture() returned uint8 of the shape (0, 6, 3): 1 to 2,304,000 pixels are wanted"),
        ("numpy.zeros((2000, 2000, 3), numpy.uint8)", "of the shape (2000, 2000, 3): 1 to 2,304,000 pixels are wanted"),
        ("'a cat'", "height × width × 3 of uint8 are wanted"),
        ("(numpy.zeros((4, 6, 3), numpy.uint8), [(1, 2)])", "field 0 is (1, 2): (x, y, radius) are wanted, in pixels"),
        ("(numpy.zeros((4, 6, 3), numpy.uint8), [(1, 2, float('nan'))])", "field 0 is (1, 2, nan), which is nowhere"),
        ("(numpy.zeros((4, 6, 3), numpy.uint8), [(1, 2, 3)] * 20000)", "it has 20,000 fields, and at most 16,384 are shown"),
        ("1 / 0", "ZeroDivisionError: division by zero"),
    ],
)
def test_a_picture_that_is_none_is_said_once_and_the_body_goes_on(
    sandbox: Sandbox, caplog: pytest.LogCaptureFixture, wrong: str, told: str
) -> None:
    numpy = pytest.importorskip("numpy")
    asked: list[int] = []

    class Blurred(Lamp):
        def picture(self) -> Any:
            asked.append(self.pressed)
            return eval(wrong, {"numpy": numpy})

    with caplog.at_level(logging.ERROR, "pschema"), sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with running(Blurred(), "lamp"):
            steps(client, 5)
            # Somebody watches for as long as it takes to ask for several pictures.
            eye = pschema._native.Eye("lamp")
            until("pictures were asked for", lambda: len(asked) > 5 or None)
            assert eye.newest() is None
            assert steps(client, client.status()["step"] + 20)
        assert client.status()["bodies"][0]["frames_refused"] == 0
    (record,) = [record for record in caplog.records if record.name == "pschema"]
    assert record.getMessage() == "a picture of Blurred failed; said once until it fails otherwise"
    assert record.exc_info is not None
    assert told in f"{record.exc_info[0].__name__ if record.exc_info[0] else ''}: {record.exc_info[1]}"


def test_it_keeps_the_protocol(sandbox: Sandbox) -> None:
    import shlex
    import sys

    text = LAMP.replace("Lamp())", "Lamp(), __import__('os').environ['PSCHEMA_NAME'])")
    told = sandbox.command("conformance", "--command", f"{sys.executable} -c {shlex.quote(text)}")
    assert told.returncode == 0, told.stdout + told.stderr


def test_the_class_of_a_body_is_no_body() -> None:
    with pytest.raises(pschema.ArgumentError, match=r"an object of the class, as Body\(\)"):
        pschema.run(pschema.Body, "nobody")  # type: ignore[arg-type]
