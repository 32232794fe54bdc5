"""Builds the wheel: maturin does, after the program `pschema` has been built and put where maturin takes a wheel's scripts from.

The program and the library are made of one build: the library is built on the crate of the program, so both are compiled
with the same features of all crates, once, into the target directory of the workspace.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any, Optional

import maturin
from maturin import get_requires_for_build_editable, get_requires_for_build_wheel

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

HERE = Path(__file__).resolve().parent.parent
SCRIPTS = HERE / "pschema.data" / "scripts"

Settings = Optional[dict[str, Any]]


def _put_program() -> None:
    if not (HERE.parent.parent / "Cargo.toml").is_file():
        raise SystemExit(
            f"{HERE} is not in a clone of the repository, of which the program and the library are built: "
            "clone it, and install ./tools/python from its root"
        )
    cargo = os.environ.get("CARGO", "cargo")
    packages = ["-p", "pschema-tools", "-p", "pschema-python"]
    subprocess.run([cargo, "build", "--release", "--locked", *packages, "--bin", "pschema"], cwd=HERE, check=True)
    metadata = subprocess.run(
        [cargo, "metadata", "--format-version", "1", "--no-deps", "--locked"], cwd=HERE, check=True, stdout=subprocess.PIPE
    )
    built = Path(json.loads(metadata.stdout)["target_directory"]) / "release" / "pschema"
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    program = SCRIPTS / "pschema"
    shutil.copy2(built, program)
    # Tables of lines are most of the program, and serve those who work on it.
    strip = shutil.which("strip")
    if strip:
        subprocess.run([strip, str(program)], check=True)


def prepare_metadata_for_build_wheel(directory: str, settings: Settings = None) -> str:
    # maturin wants the folder of scripts to be there even where it only tells what the package is called.
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    return str(maturin.prepare_metadata_for_build_wheel(directory, settings))


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel


def build_wheel(directory: str, settings: Settings = None, metadata: Optional[str] = None) -> str:
    _put_program()
    return str(maturin.build_wheel(directory, settings, metadata))


def build_editable(directory: str, settings: Settings = None, metadata: Optional[str] = None) -> str:
    _put_program()
    return str(maturin.build_editable(directory, settings, metadata))


def build_sdist(directory: str, settings: Settings = None) -> str:
    raise SystemExit("there is no source distribution: the package is built of the whole repository, from a clone of it")
