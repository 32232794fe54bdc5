"""The notebook, run from its first cell to its last."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import DEADLINE_S, Sandbox

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

NOTEBOOK = Path(__file__).resolve().parents[3] / "docs" / "PYTHON-TUTORIAL.ipynb"


def test_the_notebook_runs(sandbox: Sandbox) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells), "its outputs are to be left out"
    nbclient.NotebookClient(notebook, timeout=DEADLINE_S, kernel_name="python3").execute()
    shown = {kind for cell in cells for output in cell.outputs for kind in output.get("data", {})}
    assert {"text/html", "image/svg+xml", "text/plain"} <= shown
    assert any("achieved" in output.get("text", "") for cell in cells for output in cell.outputs)
    # It leaves nothing behind.
    sandbox.note()
    assert sandbox.left() == []
