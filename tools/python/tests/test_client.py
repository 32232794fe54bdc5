"""Looking into a learner that runs, and giving it orders."""

from __future__ import annotations

import math
import os
import threading
import time
from pathlib import Path
from typing import Any, Callable, Optional

import pytest

import pschema

from .conftest import Lamp, Sandbox, running, steps, until


def test_everything_that_can_be_asked(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Lamp(), "lamp"):
        steps(client, 50)
        status = client.status()
        assert (status["name"], status["profile"]) == ("lamp", "full")
        listed = list(client.schemas())
        assert [schema["id"] for schema in listed] == list(range(len(listed)))
        assert list(client.schemas(limit=1)) == [listed[0]] or client.status()["step"] > status["step"]
        assert all(schema["action"].startswith("press") for schema in client.schemas(action="press"))
        used = [schema["executions"] for schema in client.schemas(sort="uses")]
        assert used
        assert client.show(0)["id"] == 0
        assert client.claims("press")
        assert client.explain()["step"] > 0
        assert client.why_not(0)["schema"] == 0
        assert client.predict("press()")["outcomes"]
        assert client.graph()["nodes"]
        assert client.graph(around=0)["around"] == 0
        assert "stages" in client.report() or client.report()["step"]


def test_schemas_are_told_page_by_page(sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pschema.questions._PAGE", 1)
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with running(Lamp(), "lamp"):
            steps(client, 100)
        listed = list(client.schemas())
        assert len(listed) == client.status()["schemas_total"] > 1
        assert list(client.schemas(limit=2)) == listed[:2]


def test_schemas_as_a_table_and_as_a_network(sandbox: Sandbox) -> None:
    pytest.importorskip("pandas")
    pytest.importorskip("networkx")
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        assert client.schemas_frame().empty
        with running(Lamp(), "lamp"):
            steps(client, 100)
        frame = client.schemas_frame(sort="uses")
        assert frame.index.name == "id"
        assert frame.loc[0, "executions"] >= 0
        network = client.network()
        assert network.number_of_nodes() == len(frame)
        assert network.nodes[0]["schema"]["id"] == 0


def test_a_notebook_shows_them(sandbox: Sandbox) -> None:
    from xml.etree import ElementTree

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        assert ElementTree.fromstring(client.excitation()._repr_svg_()).tag.endswith("svg")
        with running(Lamp(), "lamp"):
            steps(client, 300)
        explained = client.explain()
        assert explained["action"] in str(explained)
        assert explained._repr_html_().startswith("<pre>")
        assert ElementTree.fromstring(client.graph()._repr_svg_()).tag.endswith("svg")
        curve = client.excitation(100)
        assert curve[-1][0] - curve[0][0] <= 100
        assert 50 < len(curve) <= 100
        picture = ElementTree.fromstring(curve._repr_svg_())
        (line,) = picture.iter("{http://www.w3.org/2000/svg}polyline")
        assert len(line.attrib["points"].split()) == len(curve)
        changed = type(explained)({"step": 1})
        with pytest.raises(ValueError, match="another answer"):
            str(changed)


def test_a_goal_is_achieved_and_told(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Lamp(), "lamp"):
        steps(client, 100)
        assert client.plan("lamp{lit=true}")
        told: list[Any] = []
        end = client.achieve("lamp{lit=true}", actions_max=10, seen=told.append)
        assert end["achieved"]
        assert told[-1]["state"] == end["state"] == "achieved"
        with pytest.raises(pschema.AnswerError, match="lampe"):
            client.achieve("lampe{}")


def test_most_of_a_value_comes_and_a_goal_is_wanted_again(sandbox: Sandbox) -> None:
    class Paid(Lamp):
        def describe(self) -> pschema.Description:
            lamp, pay = pschema.state("lamp", lit=pschema.boolean()), pschema.value("pay", pay=pschema.real(0, 1, 0.5))
            return pschema.Description(self.name, senses=[lamp, pay], actions=[pschema.action("press"), pschema.action("rest")])

        def sense(self) -> list[pschema.Observation]:
            return [*super().sense(), *([("pay", (0.5,))] if self.lit else [])]

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Paid(), "lamp"):
        steps(client, 150)
        plan = client.plan(most="pay")
        assert plan["most"] == "pay"
        assert plan["expected"] > 20
        end = client.achieve(most="pay", actions_max=20)
        assert end["state"] == "actions used up"
        assert end["came"] >= 9
        told = sandbox.command("--name", "lamp", "achieve", "--most", "pay", "--actions", "10")
        assert told.returncode == 0, told.stderr
        assert "most pay: " in told.stdout
        assert "came in 10 actions" in " ".join(told.stdout.split())
        told = sandbox.command("--name", "lamp", "achieve", "--again", "lamp{lit=true}")
        assert told.returncode == 0, told.stderr
        assert "lamp{lit=true} again was achieved with" in " ".join(told.stdout.split())
        for wrong in (["--most", "lamp"], ["--most", "pay", "lamp{}"], ["--again"]):
            assert sandbox.command("--name", "lamp", "achieve", *wrong).returncode != 0
        assert sandbox.command("--name", "lamp", "plan", "--most", "pay").returncode == 0


def test_a_goal_beyond_what_is_declared_is_refused(sandbox: Sandbox) -> None:
    class Dial(Lamp):
        def describe(self) -> pschema.Description:
            return pschema.Description("dial", senses=[pschema.state("dial", at=pschema.integer(0, 9))], actions=[pschema.action("press")])

        def sense(self) -> list[pschema.Observation]:
            return [("dial", (self.pressed % 10,))]

    with sandbox.daemon("dial"), pschema.connect("dial") as client:
        with pytest.raises(pschema.AnswerError, match="no body is attached"):
            client.achieve("dial{at=99}")
        with running(Dial(), "dial"):
            steps(client, 20)
            for ask in (client.achieve, client.plan):
                with pytest.raises(pschema.AnswerError, match=r"dial\{at=99\} will never be so: body dial declares at of dial as 0..=9"):
                    ask("dial{at=99}")
            told = sandbox.command("--name", "dial", "achieve", "dial{at=99}")
            assert told.returncode != 0
            assert "declares at of dial as 0..=9" in told.stderr


def test_a_goal_is_called_off_from_another_thread(sandbox: Sandbox) -> None:
    begun, free, stop = threading.Event(), threading.Event(), pschema.Stop()

    class Stuck(Lamp):
        def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
            begun.set()
            free.wait()
            return super().act(action)

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Stuck(), "lamp"):
        begun.wait()
        caller = threading.Timer(0.1, stop.set)
        caller.start()
        try:
            # Nothing comes of it while the body is stuck.
            end = client.achieve("lamp{lit=true}", wait_s=600, stop=stop)
        finally:
            caller.join()
            free.set()
        assert end["state"] == "cancelled"


def test_a_goal_is_called_off(sandbox: Sandbox) -> None:
    class Slow(Lamp):
        def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
            time.sleep(0.1)
            return super().act(action)

    def fails(_: Any) -> None:
        raise ZeroDivisionError

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Slow(), "lamp"):
        steps(client, 3)
        end = client.achieve("lamp{lit=true}", wait_s=0)
        assert not end["achieved"]
        assert end["state"] != "pursued"
        with pytest.raises(ZeroDivisionError):
            client.achieve("lamp{lit=true}", seen=fails)
        assert client.pursuit()["state"] != "pursued"


def test_orders(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp") as daemon, pschema.connect("lamp") as client, running(Lamp(), "lamp"):
        steps(client, 20)
        assert client.stage("hold")["stage_state"] == "held"
        before = client.status()["step"]
        client.say("light")
        client.stage("step")
        steps(client, before)
        until("it is heard", lambda: "'light'" in str(client.explain()["world"]) or None)
        client.stage("resume")
        assert client.stage()["stage"] == "free"
        client.stage("free")
        with pytest.raises(pschema.AnswerError, match="nowhere"):
            client.stage("nowhere")
        with pytest.raises(pschema.AnswerError, match="is no word"):
            client.say("two words")
        client.shutdown()
        daemon._process.wait(60)
        assert daemon._process.returncode == 0


def test_steps_are_watched_until_the_daemon_ends(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp") as daemon, pschema.connect("lamp") as client, running(Lamp(), "lamp"):
        steps(client, 5)
        seen = []
        for record in client.watch(rate=100):
            seen.append(record["step"])
            if len(seen) == 50:
                daemon.end()
        assert len(seen) >= 50
        assert seen == list(range(seen[0], seen[0] + len(seen)))


def test_the_past(sandbox: Sandbox, tmp_path: Path) -> None:
    data = tmp_path / "memory"
    with sandbox.daemon("lamp", data=data), pschema.connect("lamp") as client:
        with running(Lamp(), "lamp"):
            steps(client, 120)
        now = client.status()["step"]
        assert client.past(50).status()["step"] == 50
        assert client.explain(step=10)["step"] == 10
        with pytest.raises(pschema.AnswerError):
            client.explain(step=now + 1_000_000)
    memory = pschema.Past(data)
    assert memory.status()["step"] == now
    assert pschema.Past(data, 50).explain()["step"] == 50
    assert list(memory.schemas())
    assert memory.predict("press()")["outcomes"]
    with pytest.raises(pschema.AnswerError, match="nowhere"):
        pschema.Past(tmp_path / "nowhere").status()
    with pytest.raises(pschema.AnswerError):
        pschema.Past(data, 10**9).status()


def test_there_is_no_daemon(sandbox: Sandbox) -> None:
    with pytest.raises(pschema.NoDaemonError, match="nobody"):
        pschema.connect("nobody")
    with pytest.raises(ValueError, match="Not A Name"):
        pschema.connect("Not A Name")
    with pytest.raises(ValueError, match="timeout_s=-1: give a finite number"):
        pschema.connect("nobody", timeout_s=-1)


def test_a_memory_in_ram_has_no_past(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with pytest.raises(pschema.AnswerError, match="in RAM only"):
            client.past()
        client.close()
        with pytest.raises(pschema.AnswerError, match="was closed"):
            client.status()


def test_several_threads_ask(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client, running(Lamp(), "lamp"):
        steps(client, 50)
        answers: list[Any] = []

        def ask(number: int) -> None:
            answers.extend((number, client.show(number)["id"]) for _ in range(25))

        threads = [threading.Thread(target=ask, args=(number,)) for number in (0, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(answers) == 50
        assert all(asked == told for asked, told in answers)


def test_a_question_that_is_not_known_is_refused(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        with pytest.raises(ValueError, match="no request"):
            client._asked("status", {"more": 1})
        with pytest.raises(pschema.AnswerError, match="there is no schema 7"):
            client.show(7)
        with pytest.raises(pschema.ArgumentError, match="schema='xxx") as refused:
            client.show("x" * 10_000_000)  # type: ignore[arg-type]
        assert len(str(refused.value)) < 200


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda client: client.show(-1), "schema=-1: give a whole number from 0"),
        (lambda client: client.show(1.0), "schema=1.0: give a whole number from 0"),
        (lambda client: client.show(True), "schema=True: give a whole number from 0"),
        (lambda client: client.show(2**70), "schema=1180591620717411303424: give a whole number from 0 to 4,294,967,295"),
        (lambda client: client.why_not("a"), "schema='a': give a whole number from 0"),
        (lambda client: client.explain(step=-1), "step=-1: give a whole number from 0"),
        (lambda client: client.explain(candidates=None), "candidates=None: give a whole number from 0"),
        (lambda client: client.schemas(sort="x"), "sort='x': give one of age, uses, probability, excitation"),
        (lambda client: client.schemas(limit=-1), "limit=-1: give a whole number from 0"),
        (lambda client: client.schemas(post=3), "post=3: give a text"),
        (lambda client: client.claims(3), "action=3: give a text"),
        (lambda client: client.predict(None), "action=None: give a text"),
        (lambda client: client.plan("lamp{}", 3), "goal[1]=3: give a text"),
        (lambda client: client.graph(around=-1), "around=-1: give a whole number from 0"),
        (lambda client: client.say(3), "words[0]=3: give a text"),
        (lambda client: client.say("light", "\ud800"), "words[1]='\\ud800': leave out U+D800, which is half of a character"),
        (lambda client: client.stage(5), "order=5: give a text"),
        (lambda client: client.achieve("lamp{}", actions_max=-1), "actions_max=-1: give a whole number from 1"),
        (lambda client: client.achieve("lamp{}", actions_max=math.nan), "actions_max=nan: give a whole number from 1"),
        (lambda client: client.achieve("lamp{}", wait_s=math.nan), "wait_s=nan: give a finite number from 0"),
        (lambda client: client.achieve("\udfff{}"), "goal[0]='\\udfff{}': leave out U+DFFF"),
        (lambda client: client.cancel(-1), "number=-1: give a whole number from 0"),
        (lambda client: client.watch(rate=0), "rate=0: give a finite number above 0"),
        (lambda client: client.excitation(-1), "last=-1: give a whole number from 0"),
        (lambda client: client.past(-1), "at=-1: give a whole number from 0"),
        (lambda _: pschema.connect(5), "name=5: give a text"),  # type: ignore[arg-type]
        (lambda _: pschema.connect("lamp", timeout_s="soon"), "timeout_s='soon': give a finite number from 0"),  # type: ignore[arg-type]
        (lambda _: pschema.Past(5), "data=5: give the path of a data directory"),  # type: ignore[arg-type]
        (lambda _: pschema.Daemon(5), "name=5: give a text"),  # type: ignore[arg-type]
        (lambda _: pschema.Daemon("other", data=5), "data=5: give the path"),  # type: ignore[arg-type]
        (lambda _: pschema.Daemon("other", seed=-1), "seed=-1: give a whole number from 0"),
        (lambda _: pschema.run(5), "body=5: it has no describe()"),  # type: ignore[arg-type]
        (lambda _: pschema.run(Lamp(), 5), "name=5: give a text"),  # type: ignore[arg-type]
        (lambda _: pschema.run(Lamp(), stop=True), "stop=True: give a pschema.Stop"),  # type: ignore[arg-type]
    ],
)
def test_an_argument_that_is_wrong_is_named(sandbox: Sandbox, tmp_path: Path, ask: Callable[[pschema.Client], Any], told: str) -> None:
    with sandbox.daemon("lamp", data=tmp_path), pschema.connect("lamp") as client:
        with pytest.raises(pschema.ArgumentError) as refused:
            ask(client)
        assert told in str(refused.value)
        assert isinstance(refused.value, ValueError)
        assert isinstance(refused.value, TypeError)
        # Nothing went anywhere.
        assert client.status()["step"] == 0


def test_words_and_what_they_are_associated_with(sandbox: Sandbox) -> None:
    class Presses(Lamp):
        """A lamp that is named when it is lit."""

        def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
            super().act(action)
            if self.lit and action.name == "press":
                client.say("light")
            return None

    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        assert client.words() == {}
        with running(Presses(), "lamp"):
            steps(client, 50)
            until("the word is known", lambda: client.words() or None)
        words = client.words()
        assert set(words) == {"light"}
        (first, *_) = words["light"]
        assert 1 <= first["occurrences"] <= first["trials"]
        assert client.show(first["schema"])["associated"]


def test_a_child_connects_by_itself(sandbox: Sandbox) -> None:
    with sandbox.daemon("lamp"), pschema.connect("lamp") as client:
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                client.status()
            except RuntimeError as error:
                os.write(writer, str(error).encode())
            finally:
                os._exit(0)
        os.close(writer)
        told = os.read(reader, 1000).decode()
        os.close(reader)
        os.waitpid(child, 0)
        assert "connect again in the child" in told
        assert client.status()["step"] == 0


def test_the_daemon_could_not_be_started(sandbox: Sandbox, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(pschema.Error, match="ended with exit code"):
        pschema.Daemon("lamp", curriculum="nowhere")
    assert "nowhere" in capfd.readouterr().err
    with sandbox.daemon("lamp"), pytest.raises(pschema.Error, match="ended with exit code"):
        pschema.Daemon("lamp")
