"""The result of folders, held to the files and lines of the command line."""

import json
import math
import os
import signal
import tarfile
import threading
import time
from pathlib import Path

import command_line
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from command_line import REFERENCE, ROOT

import friction_bench as fb

TABLES = ["instances", "estimates", "samples", "explorations", "friction", "trials", "participants", "descriptive"]


@pytest.fixture(scope="session")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of two simulated people, one more of whom has no trial, and one recording that is a copy."""
    folder = tmp_path_factory.mktemp("laboratory")
    with tarfile.open(ROOT / "tests/fixtures/0.1.0/files.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    return folder / "study"


@pytest.fixture(scope="session")
def analysis(study: Path) -> fb.Analysis:
    return fb.analyze([study, REFERENCE / "recording-d"])


@pytest.fixture(scope="session")
def files(study: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the command line writes of the same recordings, and its standard error as `warnings`."""
    folder = tmp_path_factory.mktemp("files")
    options = ["--json", folder / "results.json", "--tables", folder, "--figures", folder]
    done = command_line.run("--quiet", "analyze", study, REFERENCE / "recording-d", *options)
    (folder / "warnings").write_text(done.stderr, encoding="utf-8")
    return folder


def test_results_warnings_and_figures_are_those_of_the_command_line(analysis: fb.Analysis, files: Path) -> None:
    text = (files / "results.json").read_text(encoding="utf-8")
    assert analysis.to_json() == text
    assert analysis.results == json.loads(text)
    for key in analysis.results:
        assert getattr(analysis, key) == analysis.results[key]
    assert set(analysis.results) < set(dir(analysis))
    # Recordings finish in any order.
    assert sorted(analysis.warnings) == sorted((files / "warnings").read_text(encoding="utf-8").splitlines())
    figures = analysis.figures()
    assert sorted(figures) == sorted(path.stem for path in files.glob("*.svg"))
    for name, svg in figures.items():
        assert svg == (files / f"{name}.svg").read_text(encoding="utf-8"), name
    page = analysis.report(methods=["dynamic"])
    assert page.startswith("<!DOCTYPE html>")
    assert len(page) < len(analysis.report())


@pytest.mark.parametrize("name", TABLES)
def test_a_table_has_the_values_of_its_parquet_file(analysis: fb.Analysis, files: Path, name: str) -> None:
    table = analysis.table(name)
    written = pq.read_table(files / f"{name}.parquet")
    taken = pa.table(table)
    assert taken.schema.names == written.schema.names == table.column_names
    assert len(table) == table.num_rows == written.num_rows
    dictionary = {entry["column"]: entry for entry in json.loads(written.schema.metadata[b"columns"])}
    columns = table.to_dict()
    frame = table.to_pandas()
    assert list(frame.columns) == table.column_names
    if len(table) > 0:
        # pandas makes rows into a frame of its own, without columns where there are none.
        pd.testing.assert_frame_equal(pd.DataFrame(table), frame)
    for field in taken.schema:
        column, expected = taken[field.name], written[field.name]
        assert field.type == written.schema.field(field.name).type
        assert {key.decode(): text.decode() for key, text in field.metadata.items()} == {
            "unit": dictionary[field.name]["unit"],
            "meaning": dictionary[field.name]["meaning"],
        }
        assert table.units[field.name] == dictionary[field.name]["unit"]
        numbers = expected.to_numpy()
        np.testing.assert_array_equal(column.to_numpy(), numbers)
        np.testing.assert_array_equal(columns[field.name], numbers)
        np.testing.assert_array_equal(frame[field.name].to_numpy(), numbers)


def test_numbers_of_a_table_are_views(analysis: fb.Analysis) -> None:
    table = analysis.samples
    assert table is analysis.samples
    taken = pa.table(table)
    for name in ["gap_m", "instance"]:
        column = table[name]
        address = column.ctypes.data
        assert address == taken[name].chunk(0).buffers()[1].address
        assert address == table[name].ctypes.data
        assert not column.flags.writeable
    kept = table["gap_m"]
    expected = kept.copy()
    del table, taken
    np.testing.assert_array_equal(kept, expected)
    assert pa.schema(analysis.samples).names == analysis.samples.column_names
    with pytest.raises(KeyError, match="no_such_column"):
        analysis.samples["no_such_column"]
    assert "gap_m" in analysis.samples
    assert analysis.instances["participant"].dtype == object


def test_an_analysis_says_what_it_is(analysis: fb.Analysis) -> None:
    assert "3 recordings" in repr(analysis)
    html = analysis._repr_html_()
    assert html.count("<tr>") == 4 and "sub-02" in html
    assert "accepted 2, analysed 3" in str(analysis)
    assert repr(analysis.trials).startswith("<friction_bench.Table trials: 3 rows")
    assert not hasattr(analysis, "no_such_result")
    with pytest.raises(fb.FrictionBenchError, match="participants, descriptive"):
        analysis.table("people")
    with pytest.raises(fb.FrictionBenchError, match="paper, dynamic, trial"):
        analysis.report(methods=["papr"])
    with pytest.raises(fb.FrictionBenchError, match="`methods` is no list of names"):
        analysis.figures(methods="paper")


def test_settings_are_the_assumptions_of_the_command_line(tmp_path: Path) -> None:
    recording = REFERENCE / "recording-c"
    assumptions = {"contact_area_m2": 314e-6, "trial_priors": {"tau_s": {"median": 2e-3}}, "damping": "ratio"}
    file = tmp_path / "results.json"
    command_line.run(
        "--quiet", "analyze", recording, "--json", file, "--no-offset", "--assume", "contact_area_m2=314e-6",
        "--assume", "trial_priors.tau_s.median=2e-3", "--assume", "damping=ratio",
    )
    expected = file.read_text(encoding="utf-8")
    for settings in [{**assumptions, "plate_offset": False}, fb.Settings(**assumptions, plate_offset=False)]:
        assert fb.analyze(recording, settings=settings).to_json() == expected
    settings = fb.Settings(**assumptions)
    assert settings.loss_factor == 0.6 and settings.plate_offset
    same = fb.Settings(contact_area_m2=np.float64(314e-6), loss_factor=0.6, **{"trial_priors.tau_s.median": 2e-3})
    assert settings == same != fb.Settings()
    assert settings.to_dict()["trial_priors"]["tau_s"]["median"] == 2e-3
    for wrong, words in [
        ({"contact_area": 1.0}, "did you mean `contact_area_m2`"),
        ({"poisson_ratio": 0.6}, "at most 0.5"),
        ({"poisson_ratio": math.nan}, "at most 0.5"),
        ({"trial_priors": {"tau_s": {"std": 1}}}, "trial_priors.tau_s."),
        ({"plate_offset": 0}, "True, False"),
        ({"contact_n": None}, "finite numbers above 0"),
        ([("contact_n", 1)], "a dict of assumptions"),
    ]:
        with pytest.raises(fb.FrictionBenchError, match=words):
            fb.analyze(recording, settings=wrong)


def test_progress_is_reported_and_ends_an_analysis() -> None:
    folders = [REFERENCE / name for name in ["recording-a", "recording-c", "recording-d"]]
    steps: list[tuple[int, int]] = []
    assert len(fb.analyze(folders, progress=lambda done, total: steps.append((done, total))).recordings) == 3
    assert steps == [(1, 3), (2, 3), (3, 3)]

    class Enough(Exception):
        pass

    def end(done: int, total: int) -> None:
        raise Enough(f"{done} of {total}")

    with pytest.raises(Enough, match="1 of 3"):
        fb.analyze(folders, progress=end)


def test_an_analysis_lets_other_threads_run_and_obeys_ctrl_c() -> None:
    folders = [REFERENCE / name for name in ["recording-a", "recording-c", "recording-d"]]
    sent: list[float] = []

    def interrupt() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.1, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        while True:
            fb.analyze(folders)
    assert time.monotonic() - sent[0] < 1.0


def test_errors_are_those_of_the_command_line(tmp_path: Path) -> None:
    missing = tmp_path / "nowhere"
    for paths, words in [
        (missing, "cannot list"),
        (str(tmp_path), "neither a recording"),
        ([missing, REFERENCE / "recording-d"], "nowhere"),
    ]:
        with pytest.raises(fb.FrictionBenchError, match=words) as raised:
            fb.analyze(paths)
        listed = paths if isinstance(paths, list) else [paths]
        done = command_line.run("analyze", *listed)
        assert str(raised.value) in done.stderr
    damaged = tmp_path / "damaged"
    damaged.mkdir()
    (damaged / "recording.toml").write_text("format = 1\n", encoding="utf-8")
    result = fb.analyze(damaged)
    assert result.instances.num_rows == 0
    assert result.warnings[0].startswith(f"{damaged}: cannot be read: ")
    assert result.attempts["left_out"][0]["because"].removeprefix("it cannot be read: ") in result.warnings[0]
