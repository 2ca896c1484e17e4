"""Holds the stubs to the module, and the package to mypy."""

import subprocess
import sys
from pathlib import Path

import friction_bench

SAMPLE = Path(__file__).with_name("typing_sample.py")


def run(module: str, *arguments: str | Path, folder: Path) -> None:
    command = [sys.executable, "-m", module, *map(str, arguments)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_stubs_have_every_name_and_signature_of_the_module(tmp_path: Path) -> None:
    # A compiled class has `__getattribute__` in place of it.
    allowed = tmp_path / "allowed.txt"
    allowed.write_text("friction_bench._native.Analysis.__getattr__\nfriction_bench._native.Settings.__getattr__\n", encoding="utf-8")
    run("mypy.stubtest", "friction_bench", "--allowlist", allowed, folder=tmp_path)


def test_the_package_and_a_use_of_it_are_typed(tmp_path: Path) -> None:
    package = Path(friction_bench.__file__).parent
    run("mypy", "--strict", "--cache-dir", tmp_path / "cache", package, SAMPLE, folder=tmp_path)
