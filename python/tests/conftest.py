"""Recordings for the tests: those of the repository, in short, and a simulated session of the command line."""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import pytest
from command_line import REFERENCE


def samples_of(folder: Path) -> tuple[np.ndarray, float]:
    """Return the samples of a signals.wav of 32-bit floats, a column a channel, and their rate."""
    data = (folder / "signals.wav").read_bytes()
    channels, rate_hz = np.frombuffer(data, "<u2", 1, 22)[0], np.frombuffer(data, "<u4", 1, 24)[0]
    begin = data.index(b"data") + 8
    return np.frombuffer(data, "<f4", (len(data) - begin) // 4, begin).reshape(-1, channels), float(rate_hz)


def columns_of(file: Path) -> list[np.ndarray]:
    return list(np.loadtxt(file, delimiter=",", skiprows=1).T)


def arguments_of(folder: Path) -> dict[str, Any]:
    """Return a recording of the format in docs/RECORDING.md as the arguments of `analyze`, read without the package."""
    manifest = tomllib.loads((folder / "recording.toml").read_text(encoding="utf-8"))
    samples, rate_hz = samples_of(folder)
    channels = manifest["channels"]
    force_s, normal_n, lateral_n = columns_of(folder / "force.csv")
    position_s, position_m = columns_of(folder / "position.csv")
    drive, pickup = channels["drive"], channels["pickup"]
    return {
        "drive": samples[:, drive["index"]], "pickup": samples[:, pickup["index"]],
        "rate_hz": channels.get("rate_hz", rate_hz),
        "drive_volts_per_unit": drive["volts_per_unit"],
        "pickup_scale": {key: value for key, value in pickup.items() if key != "index"},
        "normal": (force_s, normal_n), "lateral": (force_s, lateral_n), "position": (position_s, position_m),
        "intervals": manifest["intervals"], "manifest": manifest,
    }


@pytest.fixture(scope="session")
def reference() -> Callable[[str], dict[str, Any]]:
    """Return the arguments of a reference recording."""
    return lambda name: arguments_of(REFERENCE / name)


@pytest.fixture(scope="session")
def program() -> Callable[..., str]:
    """Run the program of the command line, and return its standard output."""

    def run(*arguments: str | Path) -> str:
        done = command_line.run(*arguments)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
