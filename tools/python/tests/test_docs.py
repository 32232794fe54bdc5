"""The page about Python, followed literally."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import pschema

from .conftest import Sandbox, finished, steps

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
