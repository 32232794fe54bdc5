"""How fast a trivial body is, in Python and in Rust, on a daemon of the same learner; and a learner in the process.

    python tools/python/bench/rates.py [--seconds 5] [--steps 100000] [--json]

The body in Python is a lamp with a button. The body in Rust is the world `flip` of `pschema sim`, which is as small. Both
daemons live in a runtime directory of their own, one after the other.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import threading
import time
from typing import Any, Optional

import pschema


class Lamp(pschema.Body):
    """A lamp that a button switches."""

    lit = False

    def describe(self) -> pschema.Description:
        lamp = pschema.state("lamp", lit=pschema.boolean())
        return pschema.Description("lamp", senses=[lamp], actions=[pschema.action("press"), pschema.action("rest")])

    def sense(self) -> list[pschema.Observation]:
        return [("lamp", (self.lit,))]

    def act(self, action: pschema.Action) -> Optional[pschema.Outcome]:
        self.lit ^= action.name == "press"
        return None


def exchanges(profile: str, rust: bool, seconds: float) -> float:
    """Frames a second that a body exchanges with its daemon."""
    name = "rate"
    with pschema.Daemon(name, arguments=["--set", f'learner.profile="{profile}"']), pschema.connect(name) as client:
        stop = pschema.Stop()
        if rust:
            body = subprocess.Popen([pschema.program(), "sim", "--name", name, "--world", "flip", "-q"])
        else:
            thread = threading.Thread(target=pschema.run, args=(Lamp(), name), kwargs={"stop": stop})
            thread.start()
        while client.status()["step"] < 100:
            time.sleep(0.01)
        first, began = client.status()["step"], time.perf_counter()
        time.sleep(seconds)
        rate: float = (client.status()["step"] - first) / (time.perf_counter() - began)
        if rust:
            body.terminate()
            body.wait()
        else:
            stop.set()
            thread.join()
    return rate


def steps(profile: str, count: int) -> float:
    """Steps a second of a learner in this process, its toy included."""
    learner, lamp = pschema.Learner(1, profile=profile), Lamp()
    learner.declare(lamp.describe())
    began = time.perf_counter()
    for _ in range(count):
        action = learner.step(lamp.sense())
        if action is not None:
            lamp.act(action)
    return count / (time.perf_counter() - began)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5.0, help="for each body")
    parser.add_argument("--steps", type=int, default=100_000, help="of the learner in this process")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    rows: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix="pyr-", dir="/tmp") as runtime:
        os.environ["PSCHEMA_RUNTIME_DIR"] = runtime
        for profile in ("paper", "full"):
            rows[profile] = {
                "python_exchanges_per_s": exchanges(profile, False, given.seconds),
                "rust_exchanges_per_s": exchanges(profile, True, given.seconds),
                "steps_per_s": steps(profile, given.steps),
            }
    if given.json:
        print(json.dumps(rows))
        return
    for profile, row in rows.items():
        told = ", ".join(f"{name.replace('_per_s', '').replace('_', ' ')} {value:,.0f}/s" for name, value in row.items())
        print(f"profile {profile}: {told}")


if __name__ == "__main__":
    main()
