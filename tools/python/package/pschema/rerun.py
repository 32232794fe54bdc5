"""A learner in the Rerun viewer: pictures, fields, world state, excitation and new schemas on one time line, the step.

    python -m pschema.rerun NAME                        # a running learner, as it lives
    python -m pschema.rerun --data DIR                  # the life in a data directory
    python -m pschema.rerun NAME --save life.rrd        # either of them into a file

It needs ``rerun-sdk``: ``pip install 'pschema[rerun]'``.
"""

from __future__ import annotations

import argparse
import itertools
import os
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Optional

from . import _native
from .client import Client, Past, connect
from .errors import Error, NoDaemonError
from .questions import Answer

try:
    import numpy
    import rerun
    from rerun import blueprint
except ImportError as missing:
    wanted = f"pschema.rerun needs rerun-sdk ({missing}): pip install 'pschema[rerun]', or from a clone './tools/python[rerun]'"
    if __name__ == "__main__":
        sys.exit(wanted)
    raise ImportError(wanted) from missing

__all__ = ["Recording", "follow", "main", "replay"]

#: The time line of a recording.
STEP = "step"
#: How many moments of a life on disk are looked at, unless it is said how many: each is worked out anew.
MOMENTS = 500
#: The pause when no step has come, in seconds.
PAUSE_S = 0.03
#: How many pictures may wait for the steps that they show.
PICTURES_WAITING_MAX = 32
#: Of how many steps it is remembered which fields were filled, for the pictures that come after them.
REMEMBERED = 4096

_FIELD, _FILLED = (120, 120, 120), (235, 120, 20)


def _text(observation: Answer) -> str:
    """An observation as it prints."""
    values = ", ".join(f"{name}={_value(value)}" for name, value in observation["properties"].items())
    return f"{observation['type']}{{{values}}}"


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"${value['var']}" if isinstance(value, dict) and "var" in value else str(value)


@dataclass
class Recording:
    """What is logged, where it stands in the viewer, and how much there was of it.

    Args:
        stream: a recording of Rerun, which goes to a viewer or into a file.
    """

    stream: Any
    steps: int = 0
    schemas: int = 0
    pictures: int = 0
    #: The last step that was logged.
    last: int = 0
    #: In which fields something was perceived, in the latest steps.
    _filled: dict[int, set[int]] = field(default_factory=dict)
    _stage: str = ""

    def at(self, step: int) -> None:
        """What is logged from now on belongs to this step."""
        self.last = max(self.last, step)
        self.stream.set_time(STEP, sequence=step)

    def world(self, step: int, perceived: Iterable[Answer]) -> None:
        """The world state of a step: as text, and the number of each field in which something is seen as a curve."""
        perceived = list(perceived)
        self.stream.log("world/state", rerun.TextDocument("\n".join(map(_text, perceived)) or "nothing is perceived"))
        filled = self._filled[step] = set()
        for one in perceived:
            number = one["properties"].get("field")
            if isinstance(number, int) and not isinstance(number, bool):
                filled.add(number)
                told = [_value(value) for name, value in one["properties"].items() if name != "field"]
                self.stream.log("/".join(["fields", one["type"], *told]), rerun.Scalars(number))
        while len(self._filled) > REMEMBERED:
            del self._filled[next(iter(self._filled))]

    def decision(self, action: str, schema: Optional[int], reason: Any, chosen: Optional[float], top: Optional[float]) -> None:
        """What was decided, and how exciting it was."""
        for name, value in (("chosen", chosen), ("top", top)):
            if value is not None:
                self.stream.log(f"excitation/{name}", rerun.Scalars(value))
        of = "untried" if schema is None else f"schema {schema}"
        self.stream.log("mind/decision", rerun.TextLog(f"{action} ({of}, {reason})"))

    def stage(self, name: str) -> None:
        """The stage of the curriculum, when it is another."""
        if name != self._stage:
            self._stage = name
            self.stream.log("mind/stage", rerun.TextLog(name))

    def schema(self, summary: Answer) -> None:
        """A schema that is new."""
        text = f"{' & '.join(summary['pre']) or '∅'} → {summary['action']} → {' & '.join(summary['post']) or '∅'}"
        self.stream.log("memory/new", rerun.TextLog(f"{summary['id']} ({summary['kind']}): {text}"))
        self.schemas += 1

    def count(self, schemas: int, generalised: Optional[int] = None) -> None:
        """How many schemas there are."""
        self.stream.log("memory/schemas", rerun.Scalars(schemas))
        if generalised is not None:
            self.stream.log("memory/generalised", rerun.Scalars(generalised))

    def picture(self, step: int, width: int, height: int, pixels: bytes, marks: Sequence[tuple[float, float, float]]) -> None:
        """What a body saw in a step, with its visual fields; those in which something was perceived are filled."""
        self.at(step)
        self.stream.log("world/camera", rerun.Image(numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 3)))
        self.pictures += 1
        filled = [number in self._filled.get(step, ()) for number in range(len(marks))]
        points = rerun.Points2D(
            [(x, y) for x, y, _ in marks],
            radii=[radius / (2 if one else 6) for (_, _, radius), one in zip(marks, filled)],
            colors=[_FILLED if one else _FIELD for one in filled],
            labels=[str(number) for number in range(len(marks))],
            show_labels=False,
        )
        self.stream.log("world/camera/fields", points)

    def record(self, record: Answer, stages: Sequence[str]) -> None:
        """A step, as the daemon's trace has it."""
        self.at(record["step"])
        self.stage(stages[record["stage"]] if record["stage"] < len(stages) else "")
        self.world(record["step"], record["perceived"])
        for word in record["heard"]:
            self.stream.log("world/heard", rerun.TextLog(word))
        decided = record["decision"]
        if decided is not None:
            of = (decided["schema"], decided["reason"], decided["excitation"], decided["excitation_top"])
            self.decision(decided["action"], *of)
            self.stream.log("mind/distance", rerun.Scalars(decided["distance"]))
        self.count(record["schemas_total"], record["schemas_generalised"])
        self.stream.log("speed/step_us", rerun.Scalars(record["latency_us"]))
        self.steps += 1


def layout() -> Any:
    """How the viewer shows it."""
    camera = blueprint.Spatial2DView(origin="world/camera", name="camera and fields")
    curves = blueprint.Vertical(
        blueprint.TimeSeriesView(origin="excitation", name="excitation"),
        blueprint.TimeSeriesView(origin="memory", contents=["memory/schemas", "memory/generalised"], name="schemas"),
        blueprint.TimeSeriesView(origin="fields", name="in which field"),
    )
    texts = blueprint.Vertical(
        blueprint.TextDocumentView(origin="world/state", name="world state"),
        blueprint.TextLogView(origin="memory/new", name="new schemas"),
        blueprint.TextLogView(origin="mind", name="decisions"),
    )
    return blueprint.Blueprint(blueprint.Horizontal(camera, curves, texts), collapse_panels=True)


def follow(learner: Client, to: Recording, *, steps: Optional[int] = None, pictures: bool = True) -> None:
    """Logs a running learner, the steps that its daemon still has first, until it ends, or until so many ``steps`` are logged."""
    after, known = 0, None
    # Pictures wait until their steps are told.
    seen: deque[tuple[int, Any]] = deque(maxlen=PICTURES_WAITING_MAX)
    try:
        eye = _native.Eye(learner.name) if pictures else None
        while steps is None or to.steps < steps:
            page = learner._asked("trace", {"from": after})
            for record in page["records"][: None if steps is None else steps - to.steps]:
                to.record(record, page["stages"])
            after = page["from"] + len(page["records"])
            known = _new_schemas(learner, to, known, page["records"])
            newest = eye.newest() if eye is not None else None
            if newest is not None:
                seen.append((_step_of(learner, *newest[:2]) or to.last, newest[2:]))
            while seen and seen[0][0] <= to.last:
                step, picture = seen.popleft()
                to.picture(step, *picture)
            if after >= page["total"]:
                time.sleep(PAUSE_S)
    except Error:
        try:
            learner.status()
        except NoDaemonError:
            # It has ended, and what it did is logged.
            return
        raise


def _step_of(learner: Client, session: int, frame: int) -> Optional[int]:
    """The step in which a body sent the frame after ``frame`` others, if it is the only one: each of its frames was a step then."""
    status = learner.status()
    attached = [body for body in status["bodies"] if body["state"] == "attached"]
    if [body["id"] for body in attached] != [session]:
        return None
    step: int = status["step"] - attached[0]["frames"] + frame + 1
    return step if step > 0 else None


def _new_schemas(learner: Client, to: Recording, known: Optional[int], records: Sequence[Answer]) -> Optional[int]:
    """Logs the schemas that were made meanwhile; returns how many there are."""
    if not records:
        return known
    total: int = records[-1]["schemas_total"]
    # Those that were there before are told of with the first steps that are known.
    have = records[0]["schemas_total"] if known is None else known
    if have < total:
        question = {"generalised": False, "sort": "age", "limit": total - have, "offset": have}
        made = {record["schemas_total"]: record["step"] for record in reversed(records)}
        counts = sorted(made)
        for summary in learner._asked("schemas", question)["schemas"]:
            to.at(made[next((count for count in counts if count > summary["id"]), total)])
            to.schema(summary)
    return max(have, total)


def replay(data: str, to: Recording, *, first: int = 1, last: Optional[int] = None, every: Optional[int] = None) -> None:
    """Logs the life in a data directory, with a daemon on it or without, from step ``first`` to ``last``.

    Each ``every``-th step is looked at, which is worked out from the nearest snapshot: by default as many as take some seconds. No
    pictures are kept on disk.
    """
    memory = Past(data)
    end = memory.status()["step"] if last is None else last
    stride = every if every is not None else max(1, (end - first + 1) // MOMENTS)
    schemas = list(memory.schemas())
    told = None
    for step in _moments(first, end, stride):
        to.at(step)
        moment = Past(data, step)
        status = moment.status()
        total = status["schemas_total"]
        to.stage(status["stage"])
        for summary in schemas[total if told is None and first > 1 else (told or 0) : total]:
            to.schema(summary)
        told = total
        to.count(total)
        try:
            explained = moment.explain(step, candidates=1)
        except Error:
            # Nothing was decided in this step, or nothing is known any more of what was perceived.
            explained = None
        if explained is not None:
            chosen = explained["candidates"][explained["chosen"]]
            to.world(step, explained["world"])
            top = max(one["excitation"] or 0.0 for one in explained["candidates"])
            to.decision(explained["action"], chosen["schema"], explained["reason"], chosen["excitation"], top)
        to.steps += 1


def _moments(first: int, last: int, stride: int) -> Iterator[int]:
    """Each step of a stride, and the last."""
    yield from itertools.chain(range(first, last, stride), [last] if last >= first else [])


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """``python -m pschema.rerun``; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m pschema.rerun",
        description="Show a learner in the Rerun viewer: a running one, or the life in a data directory.",
        epilog="Without --save and --connect a viewer is opened. Ctrl-C ends it.",
    )
    parser.add_argument("name", nargs="?", default="default", help="the running learner [default: default]")
    parser.add_argument("--data", metavar="DIR", help="the life in this data directory, and no running learner")
    parser.add_argument("--from", dest="first", type=int, default=1, metavar="N", help="with --data: the first step [default: 1]")
    parser.add_argument("--to", dest="last", type=int, metavar="N", help="with --data: the last step")
    parser.add_argument("--every", type=int, metavar="N", help=f"with --data: look at each so manieth step [default: {MOMENTS} in all]")
    parser.add_argument("--steps", type=int, metavar="N", help="of a running learner: end after so many")
    parser.add_argument(
        "--no-pictures", action="store_true", help="of a running learner: leave the pictures out, which are most of its bytes"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--save", metavar="FILE", help="into a file (.rrd), which `rerun FILE` shows")
    where.add_argument("--connect", metavar="URL", help="to a viewer that runs (rerun+http://127.0.0.1:9876/proxy)")
    parser.add_argument("--overwrite", action="store_true", help="replace what is there under the name of --save")
    given = parser.parse_args(arguments)
    if given.every is not None and given.every < 1:
        parser.error("--every is at least 1")
    try:
        return _shown(given)
    except Error as error:
        print(f"pschema.rerun: {error}", file=sys.stderr)
        return 3 if isinstance(error, NoDaemonError) else 1


def _shown(given: argparse.Namespace) -> int:
    # Looked for first: nothing is opened where there is nothing to show.
    learner = None if given.data else connect(given.name)
    if given.data:
        Past(given.data).status()
    if given.save and os.path.exists(given.save) and not given.overwrite:
        raise Error(f"{given.save}: it is there already: name another file, or give --overwrite")
    stream = rerun.RecordingStream("pschema")
    to = Recording(stream)
    try:
        stream.send_recording_name(given.data or given.name)
        if given.save:
            stream.save(given.save, default_blueprint=layout())
        elif given.connect:
            stream.connect_grpc(given.connect, default_blueprint=layout())
        else:
            stream.spawn(default_blueprint=layout())
        if learner is None:
            replay(given.data, to, first=given.first, last=given.last, every=given.every)
        else:
            follow(learner, to, steps=given.steps, pictures=not given.no_pictures)
    except KeyboardInterrupt:
        pass
    finally:
        stream.flush()
        stream.disconnect()
        if learner is not None:
            learner.close()
    print(f"{to.steps} steps, {to.schemas} new schemas, {to.pictures} pictures.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
