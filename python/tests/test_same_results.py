"""Results from Python are those of the command line, from folders and from arrays, to the last bit."""

import gc
import json
import os
import resource
import signal
import tarfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import REFERENCE, ROOT
from conftest import arguments_of

import friction_bench as fb

Arguments = dict[str, Any]
FIXTURE = ROOT / "tests/fixtures/0.1.0/files.tar.xz"


def numbers(results: Arguments) -> Arguments:
    """Results without the place of the recording, which arrays do not have."""
    text = json.dumps({**results, "recordings": [{**one, "path": ""} for one in results["recordings"]]})
    return json.loads(text.replace(str(results["recordings"][0]["path"]), "arrays"))


def as_double(arguments: Arguments) -> Arguments:
    return arguments | {name: np.asfortranarray(arguments[name], "f8") for name in ("drive", "pickup")}


@pytest.mark.parametrize("name", ["recording-a", "recording-c", "recording-d"])
def test_arrays_have_the_results_of_the_command_line(name: str, program: Callable[..., str]) -> None:
    text = program("analyze", REFERENCE / name, "--json", "-")
    arguments = arguments_of(REFERENCE / name)
    found = fb.analyze(**arguments)
    assert numbers(found.results) == numbers(json.loads(text))
    assert fb.analyze(**as_double(arguments)).to_json() == found.to_json()


def test_trials_of_sessions_have_the_results_of_the_command_line(tmp_path: Path, program: Callable[..., str]) -> None:
    with tarfile.open(FIXTURE) as archive:
        archive.extractall(tmp_path, filter="data")
    trials = sorted((tmp_path / "study").glob("*/*/trial-*"))
    assert len(trials) == 2
    for trial in trials:
        from_program = json.loads(program("analyze", trial, "--json", "-"))
        protocol = (trial.parent / "smallest.toml").read_text(encoding="utf-8")
        from_arrays = fb.analyze(**arguments_of(trial), protocol=protocol).results
        (in_memory,), (on_disk,) = numbers(from_arrays)["recordings"], numbers(from_program)["recordings"]
        # Only the session's log tells that nobody took part.
        assert in_memory | {"provenance": {}} == on_disk | {"provenance": {}}


def test_threads_have_the_same_results() -> None:
    arguments = arguments_of(REFERENCE / "recording-a")
    with ThreadPoolExecutor(2) as pool:
        texts = list(pool.map(lambda _: fb.analyze(**arguments).to_json(), range(2)))
    assert texts[0] == texts[1]


def test_a_forked_process_has_the_same_results(tmp_path: Path) -> None:
    arguments = arguments_of(REFERENCE / "recording-a")
    written = tmp_path / "results"

    def texts() -> str:
        return fb.analyze(**arguments).to_json() + fb.analyze(REFERENCE / "recording-a").to_json()

    expected = texts()
    child = os.fork()
    if child == 0:
        # A process that waited for the threads of its parent would wait for ever.
        signal.alarm(60)
        try:
            written.write_text(texts(), encoding="utf-8")
        finally:
            os._exit(0)
    os.waitpid(child, 0)
    assert written.read_text(encoding="utf-8") == expected


def test_the_lock_of_python_is_free_during_an_analysis() -> None:
    arguments = arguments_of(REFERENCE / "recording-a")
    analysis = threading.Thread(target=fb.analyze, kwargs=arguments)
    turns = 0
    analysis.start()
    while analysis.is_alive():
        time.sleep(1e-3)
        turns += 1
    assert turns > 20


def small() -> tuple[np.ndarray, Arguments]:
    samples = np.cos(np.arange(2000) * 2.0)
    plate = fb.Plate(resonance_hz=30e3, modal_mass_kg=8e-3, force_factor_n_per_v=0.13, centre_m=0.05)
    return samples, {"carrier_hz": 30e3, "modulation_hz": 6.0, "modulation_index": 0.95, "plate": plate}


def test_a_thousand_calls_need_no_more_memory() -> None:
    samples, arguments = small()
    force = (np.arange(5) * 1e-3, np.ones(5))

    def calls(count: int) -> None:
        for _ in range(count):
            fb.analyze(samples, samples, 96_000, normal=force, lateral=force, position=force, **arguments)
            fb.envelopes(samples[::2], 96_000, carrier_hz=30e3)
            with pytest.raises(fb.FrictionBenchError):
                fb.envelopes([np.inf], 96_000, carrier_hz=30e3)
        gc.collect()

    calls(100)
    before = resident_bytes()
    calls(1000)
    assert resident_bytes() - before < 3_000_000


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


def test_progress_is_reported_and_ends_the_analysis_by_an_exception() -> None:
    samples, arguments = small()
    steps: list[tuple[int, int]] = []
    fb.analyze(samples, samples, 96_000, **arguments, progress=lambda done, total: steps.append((done, total)))
    assert steps == [(1, 1)]

    def refuse(done: int, total: int) -> None:
        raise RuntimeError(f"{done} of {total}")

    with pytest.raises(RuntimeError, match="1 of 1"):
        fb.analyze(samples, samples, 96_000, **arguments, progress=refuse)


def test_an_interrupt_ends_a_long_call_within_a_second() -> None:
    samples = np.resize(np.float32(small()[0]), 40_000_000)
    interrupted: list[float] = []

    def interrupt(*_: object) -> None:
        interrupted.append(time.monotonic())
        raise KeyboardInterrupt

    previous = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            fb.impedance(samples, samples, 96_000, carrier_hz=30e3)
        assert time.monotonic() - interrupted[0] < 1.0
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
