"""What is installed: the command, the types, and how soon it is there."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

import pschema

from .conftest import Sandbox


def test_the_command_comes_with_the_package(sandbox: Sandbox) -> None:
    assert Path(pschema.program()).parent == Path(sys.executable).parent
    told = sandbox.command("--version")
    assert told.stdout.split() == ["pschema", pschema.__version__]


def test_the_demo_runs(sandbox: Sandbox) -> None:
    told = sandbox.command("demo", "--json")
    assert told.returncode == 0, told.stderr
    assert '"placements"' in told.stdout


def test_the_wheel_says_which_linux_it_needs() -> None:
    """Its tag was that of the machine which built it, whatever it was built on."""
    files = [pschema.program(), pschema._native.__file__ or ""]
    needed = {int(minor) for file in files for minor in re.findall(rb"\0GLIBC_2\.(\d+)", Path(file).read_bytes())}
    (tag,) = re.findall(r"^Tag: (.*)$", distribution("pschema").read_text("WHEEL") or "", re.MULTILINE)
    assert tag == f"cp39-abi3-manylinux_2_{max(needed)}_{platform.machine()}"


def test_it_is_typed() -> None:
    assert (Path(pschema.__file__).parent / "py.typed").exists()


def test_import_takes_no_time() -> None:
    def took(text: str) -> float:
        """Seconds of a processor: other programs of the machine do not count."""
        before = os.times()
        subprocess.run([sys.executable, "-I", "-c", text], check=True)
        after = os.times()
        return after.children_user - before.children_user + after.children_system - before.children_system

    took("import pschema")
    with_it, without = [min(took(text) for _ in range(5)) for text in ("import pschema", "pass")]
    assert with_it - without < 0.3
    text = "import pschema, sys; print('numpy' in sys.modules or 'gymnasium' in sys.modules)"
    told = subprocess.run([sys.executable, "-I", "-c", text], check=True, capture_output=True, text=True, env={**os.environ})
    assert told.stdout.strip() == "False"


def test_everything_public_is_documented() -> None:
    bare = [name for name in pschema.__all__ if name[0] != "_" and not getattr(getattr(pschema, name), "__doc__", None)]
    assert [name for name in bare if name not in ("Observation", "Value")] == []
