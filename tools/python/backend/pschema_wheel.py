"""Builds the wheel: maturin does, after the program `pschema` has been built and put where maturin takes a wheel's scripts from.

The program and the library are made of one build: the library is built on the crate of the program, so both are compiled
with the same features of all crates, once, into the target directory of the workspace.

The wheel's tag says on which machines it runs: ``manylinux_2_35_x86_64`` on those whose C library is glibc 2.35 or newer. It is the newest
version that the program or the library asks a function of, so it follows from the machine that builds. maturin looks at the library
alone, and refuses a tag that it does not keep to: a library that is not part of every Linux, a newer function.
"""

from __future__ import annotations

import json
import os
import re
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


def _glibc_minor(built: Path) -> int:
    """The newest glibc, 2.MINOR, whose functions something built needs; 0 where it needs none, as with another C library."""
    wanted = re.findall(rb"\x00GLIBC_2\.(\d+)(?:\.\d+)?(?=\x00)", built.read_bytes())
    return max((int(minor) for minor in wanted), default=0)


def _tagged(settings: Settings, minor: int) -> Settings:
    """The settings, with the tag of a wheel that needs glibc 2.MINOR; another that somebody asks for stays."""
    arguments = list(maturin.get_maturin_pep517_args(settings))
    if minor == 0 or any(one.startswith(("--compatibility", "--manylinux")) for one in arguments):
        return settings
    return {**(settings or {}), "maturin.build-args": [*arguments, "--compatibility", f"manylinux_2_{minor}"]}


def _put_program() -> int:
    """Builds the program and the library and puts the program where it goes into the wheel; returns the glibc, 2.MINOR, that both need."""
    if not (HERE.parent.parent / "Cargo.toml").is_file():
        raise SystemExit(
            f"{HERE} is not in a clone of the repository, of which the program and the library are built: "
            "clone it, and install ./tools/python from its root"
        )
    cargo = os.environ.get("CARGO", "cargo")
    packages = ["-p", "pschema-tools", "-p", "pschema-python"]
    subprocess.run([cargo, "build", "--release", "--locked", *packages, "--bin", "pschema", "--lib"], cwd=HERE, check=True)
    metadata = subprocess.run(
        [cargo, "metadata", "--format-version", "1", "--no-deps", "--locked"], cwd=HERE, check=True, stdout=subprocess.PIPE
    )
    release = Path(json.loads(metadata.stdout)["target_directory"]) / "release"
    built = release / "pschema"
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    program = SCRIPTS / "pschema"
    shutil.copy2(built, program)
    # Tables of lines are most of the program, and serve those who work on it.
    strip = shutil.which("strip")
    if strip:
        subprocess.run([strip, str(program)], check=True)
    return max(_glibc_minor(one) for one in (built, release / "lib_native.so"))


def prepare_metadata_for_build_wheel(directory: str, settings: Settings = None) -> str:
    # maturin wants the folder of scripts to be there even where it only tells what the package is called.
    SCRIPTS.mkdir(parents=True, exist_ok=True)
    return str(maturin.prepare_metadata_for_build_wheel(directory, settings))


prepare_metadata_for_build_editable = prepare_metadata_for_build_wheel


def build_wheel(directory: str, settings: Settings = None, metadata: Optional[str] = None) -> str:
    return str(maturin.build_wheel(directory, _tagged(settings, _put_program()), metadata))


def build_editable(directory: str, settings: Settings = None, metadata: Optional[str] = None) -> str:
    _put_program()
    return str(maturin.build_editable(directory, settings, metadata))


def build_sdist(directory: str, settings: Settings = None) -> str:
    raise SystemExit("there is no source distribution: the package is built of the whole repository, from a clone of it")
