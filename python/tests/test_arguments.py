"""Warnings about arrays name the arguments, and the results say that arrays are simulated."""

import re
import tarfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import ROOT

import friction_bench as fb

Arguments = dict[str, Any]
FILE_WORDS = re.compile(r"\.csv|\.toml|\.wav|\.parquet|normal_n|lateral_n|position_m|\btime_s\b|\bline\b|\bcolumns?\b|\bfile\b|\brows?\b")


@pytest.fixture(scope="module")
def trial() -> Arguments:
    return fb.simulate("steady", 4, rate_hz=96_000, strokes=1).arguments()


def changed(arguments: Arguments, name: str, change: Callable[[np.ndarray, np.ndarray], Any]) -> Arguments:
    return arguments | {name: change(*arguments[name])}


CHANGES: dict[str, tuple[Callable[[Arguments], Arguments], list[str]]] = {
    "no force": (lambda a: a | {"normal": None, "lateral": None}, ["`normal` and `lateral` are missing"]),
    "no position": (lambda a: a | {"position": None}, ["`position` is missing"]),
    "millinewtons": (lambda a: changed(a, "normal", lambda t, f: (t, f * 1e3)), ["`normal` reads", "divide by 1000"]),
    "another sign": (lambda a: changed(a, "normal", lambda t, f: (t, -f)), ["`normal` is negative"]),
    "a constant": (lambda a: changed(a, "lateral", lambda t, f: (t, f * 0 + 0.25)), ["`lateral` is 0.25 in each of", "array was filled in"]),
    "a lost reading": (
        lambda a: changed(a, "normal", lambda t, f: (t, np.where(np.arange(len(f)) == 7, np.nan, f))), ["the first at index 7"],
    ),
    "an early end": (lambda a: changed(a, "position", lambda t, x: (t[: len(t) // 2], x[: len(x) // 2])), ["`position`: it ends at"]),
    "another clock": (lambda a: changed(a, "position", lambda t, x: (t + 100.0, x)), ["`position`: its times run from", "the first sample of `drive`"]),
    "millimetres": (lambda a: changed(a, "position", lambda t, x: (t, x * 1e3)), ["`position`: the finger travels"]),
    "backwards": (lambda a: changed(a, "position", lambda t, x: (t, -x)), ["`position` falls in every exploration"]),
    "exchanged signals": (lambda a: a | {"drive": a["pickup"], "pickup": a["drive"]}, ["exchange the two arguments"]),
    "a dead pickup": (lambda a: a | {"pickup": np.zeros(len(a["pickup"]))}, ["the pickup is 0 in each sample"]),
    "another resonance": (lambda a: a | {"plate": {**vars(a["plate"]), "resonance_hz": 35_300.0}}, ["as stated"]),
    "an interval beyond the end": (
        lambda a: a | {"intervals": [*a["intervals"], ("unloaded", a["intervals"][-1][1], 1e3)]}, ["`intervals.3` ends at"],
    ),
}


@pytest.mark.parametrize("kind", CHANGES)
def test_a_warning_about_arrays_names_the_arguments(kind: str, trial: Arguments) -> None:
    change, words = CHANGES[kind]
    analysis = fb.analyze(**change(trial))
    warnings = "\n".join(analysis.warnings)
    for word in words:
        assert word in warnings, warnings
    assert FILE_WORDS.findall(warnings) == [], warnings
    (recording,) = analysis.results["recordings"]
    assert all(f"arrays: warning: {text}" in warnings for text in recording["warnings"])


def test_what_stops_an_analysis_names_the_arguments(trial: Arguments) -> None:
    with pytest.raises(fb.FrictionBenchError, match="`carrier_hz`") as refused:
        fb.analyze(**trial | {"rate_hz": 70_000.0})
    assert FILE_WORDS.findall(str(refused.value)) == [], refused.value


def test_intervals_without_a_finger_count_once_in_any_order(trial: Arguments) -> None:
    first, *others = trial["intervals"]
    kind, start_s, end_s = first
    middle_s = (start_s + end_s) / 2
    parts = [(kind, middle_s - 0.1, end_s), *others, (kind, start_s, middle_s)]
    assert fb.analyze(**trial | {"intervals": parts}).results == fb.analyze(**trial).results


def concerns(analysis: fb.Analysis) -> list[str]:
    return [count["concern"] for count in analysis.results["provenance"]]


def test_simulated_arrays_have_simulated_results(trial: Arguments) -> None:
    simulated = fb.analyze(**trial)
    assert concerns(simulated) == ["simulated"]
    assert any("nobody took part" in warning for warning in simulated.warnings)
    assert set(simulated.instances["simulated"]) == {True}
    assert all("simulated (1 of 1)" in svg for svg in simulated.figures().values())
    assert "nobody took part" in simulated.report()
    assert concerns(fb.analyze(**trial | {"simulated": False})) == []
    nominal = fb.simulate("bench-unknown", 4, rate_hz=96_000, duration_s=1.5, calibrated=False)
    assert concerns(fb.analyze(**nominal.arguments())) == ["simulated", "uncalibrated"]
    with pytest.raises(fb.FrictionBenchError, match="`simulated` is of arrays"):
        fb.analyze("study", simulated=True)


def test_arrays_of_a_simulated_session_have_simulated_results(tmp_path: Path) -> None:
    with tarfile.open(ROOT / "tests/fixtures/0.1.0/files.tar.xz") as archive:
        archive.extractall(tmp_path, filter="data")
    folder = tmp_path / "study/sub-01/ses-01/trial-001_attempt-1"
    recording = fb.read(folder)
    assert recording.simulated
    of_arrays, of_folder = fb.analyze(**recording.arguments()), fb.analyze(folder)
    assert "simulated" in concerns(of_arrays)
    assert concerns(of_arrays) == concerns(of_folder)
