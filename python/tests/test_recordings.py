"""Recordings as arrays, and their import."""

import shutil
import tarfile
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import REFERENCE, ROOT
from scipy.io import wavfile

import friction_bench as fb

RECORDING = REFERENCE / "recording-a"


def test_a_recording_has_the_content_of_its_files() -> None:
    recording = fb.read(RECORDING)
    manifest = tomllib.loads((RECORDING / "recording.toml").read_text(encoding="utf-8"))
    assert recording.manifest == manifest
    assert Path(recording.path) == RECORDING
    rate_hz, frames = wavfile.read(RECORDING / "signals.wav")
    assert recording.rate_hz == rate_hz
    channels = manifest["channels"]
    for name, array in [("drive", recording.drive), ("pickup", recording.pickup)]:
        assert array.dtype == np.float32
        samples = frames[:, channels[name]["index"]]
        scale = 1.0 if samples.dtype.kind == "f" else 2.0 ** (1 - 8 * samples.dtype.itemsize)
        np.testing.assert_array_equal(array, (samples * scale).astype(np.float32))
    forces = np.loadtxt(RECORDING / "force.csv", delimiter=",", skiprows=1)
    for (time_s, force_n), column in [(recording.normal, 1), (recording.lateral, 2)]:
        np.testing.assert_array_equal(time_s, forces[:, 0])
        np.testing.assert_array_equal(force_n, forces[:, column])
    positions = np.loadtxt(RECORDING / "position.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(np.column_stack(recording.position), positions)
    assert recording.carrier_hz == manifest["carrier_hz"]
    assert recording.plate.modal_mass_kg == manifest["plate"]["modal_mass_kg"]
    assert len(recording.intervals) == len(manifest["intervals"])
    for interval, table in zip(recording.intervals, manifest["intervals"], strict=True):
        assert list(interval) == [table[key] for key in ["kind", "start_s", "end_s", "direction"] if key in table]


@pytest.mark.parametrize("name", ["recording-a", "recording-d"])
def test_the_arrays_of_a_recording_have_the_results_of_its_folder(name: str) -> None:
    folder = REFERENCE / name
    of_arrays = fb.analyze(**fb.read(folder).arguments())
    assert of_arrays.to_json() == fb.analyze(folder).to_json().replace(str(folder), "arrays")


def test_a_recording_of_a_session_has_its_protocol_and_participant(tmp_path: Path) -> None:
    with tarfile.open(ROOT / "tests/fixtures/0.1.0/files.tar.xz") as archive:
        archive.extractall(tmp_path, filter="data")
    folder = tmp_path / "study/sub-01/ses-01/trial-001_attempt-1"
    arguments = fb.read(folder).arguments()
    assert "[" in arguments["protocol"]
    of_arrays, of_folder = fb.analyze(**arguments), fb.analyze(folder)
    for table in ["instances", "samples", "explorations"]:
        arrays, folders = of_arrays.table(table), of_folder.table(table)
        assert len(arrays) > 0
        for column in folders.column_names:
            # The session's log has the rest.
            if column not in ["recording", "accepted"]:
                np.testing.assert_array_equal(arrays[column], folders[column], err_msg=column)


def test_a_recording_that_lacks_a_stream_says_so(tmp_path: Path) -> None:
    forces = tmp_path / "forces"
    forces.mkdir()
    shutil.copy(RECORDING / "force.csv", forces)
    (forces / "recording.toml").write_text("format = 1\n", encoding="utf-8")
    recording = fb.read(forces)
    assert len(recording.normal[0]) > 0
    for name, words in [("drive", "drive and pickup"), ("position", "position"), ("plate", "plate"), ("carrier_hz", "carrier")]:
        with pytest.raises(fb.FrictionBenchError, match=words):
            getattr(recording, name)
    with pytest.raises(fb.FrictionBenchError, match="friction_bench.analyze reads the folder"):
        recording.arguments()
    with pytest.raises(fb.FrictionBenchError, match="recording.toml"):
        fb.read(tmp_path / "nowhere")


MAP: dict[str, Any] = {
    "format": 1,
    "files": r"rec_(?<participant>\d+)\.wav",
    "carrier": {"hz": 35000},
    "modulation": {"hz": 6.0, "index": 0.95},
    "drive": {"from": "[:,0]", "rate_hz": "file", "volts_per_unit": 1.0},
    "pickup": {"from": "[:,1]", "quantity": "displacement", "metres_per_unit": 2e-6, "phase_rad": 0},
    "normal": {
        "file": "force_{participant}.csv", "from": "normal_n", "time": "time_s", "newtons_per_unit": 1.0, "tare": "none",
    },
    "lateral": {
        "file": "force_{participant}.csv", "from": "lateral_n", "newtons_per_unit": 1.0, "tare": "none",
    },
    "position": {"file": "position_{participant}.csv", "from": "position_m", "time": "time_s", "metres_per_unit": 1.0},
    "plate": {"modal_mass_kg": 8e-3, "resonance_hz": 35000, "force_factor_n_per_v": 0.13, "centre_m": 0.0525},
    "intervals": {"unloaded": "normal < 0.05 N for 0.3 s", "exploration": "30 to 70 mm/s for 0.5 s"},
}


@pytest.fixture
def laboratory(tmp_path: Path) -> Path:
    """A folder with the recordings of two people as another laboratory would keep them, the second without forces."""
    folder = tmp_path / "laboratory"
    folder.mkdir()
    for number in [7, 8]:
        shutil.copy(RECORDING / "signals.wav", folder / f"rec_{number}.wav")
        shutil.copy(RECORDING / "position.csv", folder / f"position_{number}.csv")
    with (folder / "rec_8.wav").open("ab") as file:
        file.write(b"another recording")
    shutil.copy(RECORDING / "force.csv", folder / "force_7.csv")
    return folder


def test_a_map_that_is_a_dict_imports_files_as_one_on_the_disk(laboratory: Path, tmp_path: Path) -> None:
    steps: list[tuple[int, int]] = []
    checked = fb.import_map(MAP, folder=laboratory, dry_run=True, progress=lambda *step: steps.append(step))
    assert steps == [(1, 2), (2, 2)]
    assert [(file["path"], file["status"]) for file in checked] == [("rec_7.wav", "checked"), ("rec_8.wav", "refused")]
    assert "force_8.csv" in checked[1]["flaws"][0]
    study = tmp_path / "study"
    first = fb.import_map(MAP, folder=laboratory, study=study)
    assert first[0]["status"] == "written"
    assert first[0]["recording"] == "sub-7/ses-01/trial-001_attempt-1"
    assert fb.import_map(MAP, folder=laboratory, study=study)[0]["status"] == "unchanged"
    assert fb.analyze(study).instances.num_rows > 0


def test_a_map_that_cannot_be_used_is_refused(laboratory: Path, tmp_path: Path) -> None:
    with pytest.raises(fb.FrictionBenchError, match="dry_run=True"):
        fb.import_map(MAP, folder=laboratory)
    with pytest.raises(fb.FrictionBenchError, match="^the map: unknown key `carier`"):
        fb.import_map({**MAP, "carier": {"hz": 1}}, folder=laboratory, dry_run=True)
    with pytest.raises(fb.FrictionBenchError, match="`carrier.hz` is of type object"):
        fb.import_map({**MAP, "carrier": {"hz": object()}}, folder=laboratory, dry_run=True)
    with pytest.raises(fb.FrictionBenchError, match="map.toml"):
        fb.import_map(tmp_path / "map.toml", study=tmp_path / "study")
    with pytest.raises(fb.FrictionBenchError, match="`folder`"):
        fb.import_map(tmp_path / "map.toml", folder=laboratory, dry_run=True)
