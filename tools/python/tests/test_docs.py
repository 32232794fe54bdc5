"""The page about Python, followed literally."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import pschema

from .conftest import DEADLINE_S, Sandbox, finished, steps

PAGES = Path(__file__).resolve().parents[3]


def test_the_page_does_what_it_says(sandbox: Sandbox) -> None:
    pytest.importorskip("gymnasium")
    page = (PAGES / "docs" / "PYTHON.md").read_text()
    blocks = re.findall(r"([^\n]*)\n\n```python\n(.*?)```\n", page, re.DOTALL)
    assert len(blocks) >= 6
    names: dict[str, Any] = {"__name__": "page"}
    with sandbox.daemon("default"), pschema.connect() as client:
        for before, text in blocks:
            if "Save this as `lamp.py`" in before:
                lamp = sandbox.python(text)
                steps(client, 100)
            else:
                exec(compile(text, "docs/PYTHON.md", "exec"), names)
        lamp.terminate()
        finished(lamp)


def test_the_package_shows_a_body_that_runs(sandbox: Sandbox) -> None:
    readme = (PAGES / "tools" / "python" / "README.md").read_text()
    (text,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    lamp = sandbox.python(text)
    with_daemon = None
    while with_daemon is None:
        try:
            with_daemon = pschema.connect("lamp")
        except pschema.NoDaemonError:
            assert lamp.poll() is None
    steps(with_daemon, 20)
    sandbox.note()
    lamp.terminate()
    finished(lamp)
    assert sandbox.left() == []


def test_an_environment_is_attached_as_its_page_says(sandbox: Sandbox, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("gymnasium")
    page = (PAGES / "docs" / "howto" / "gymnasium.md").read_text()
    names: dict[str, Any] = {"__name__": "page"}
    for text in re.findall(r"```python\n(.*?)```\n", page, re.DOTALL):
        exec(compile(text, "docs/howto/gymnasium.md", "exec"), names)
    told = capsys.readouterr().out
    assert "15,625 actions" in told
    assert "achieved with" in told
    # It says of a picture that it is refused, once the actions are not.
    with pytest.raises(pschema.DeclarationError, match="an image of 4×12×3 numbers"):
        names["pschema"].gym.attach(names["Track"](), "track", actions=names["actions"])


def test_what_the_how_tos_show_is_python() -> None:
    """A robot with ROS 2 is not at hand, so its page is only compiled."""
    page = (PAGES / "docs" / "howto" / "ros2.md").read_text()
    (text,) = re.findall(r"```python\n(.*?)```\n", page, re.DOTALL)
    compile(text, "ros2.md", "exec")


def test_the_reference_is_made_without_a_warning(tmp_path: Path) -> None:
    for module in ("pdoc", "gymnasium", "rerun"):
        pytest.importorskip(module)
    (named,) = re.findall(r"&& pdoc (--docformat google .*?) +#", (PAGES / "docs" / "PYTHON.md").read_text())
    command = [sys.executable, "-m", "pdoc", *named.split(), "--output-directory", str(tmp_path)]
    told = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=False)
    assert (told.returncode, told.stderr) == (0, "")
    text = re.sub(r"<[^>]+>", "", (tmp_path / "pschema.html").read_text())
    assert all(name in text for name in pschema.__all__)
