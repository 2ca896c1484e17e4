"""Runs the Python of the handbook's chapters on the package, and the Python half of its page on MATLAB."""

import io
import re
import tarfile
from contextlib import redirect_stdout
from pathlib import Path

import matlab_lines
import numpy as np
import pytest
import scipy.io

import friction_bench as fb

ROOT = Path(__file__).resolve().parents[2]
HANDBOOK = ROOT / "docs/handbook/src"


def blocks(chapter: str, language: str) -> list[str]:
    text = (HANDBOOK / chapter).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the study `my-study` of two simulated people, which is the current one."""
    with tarfile.open(ROOT / "tests/fixtures/0.1.0/files.tar.xz") as archive:
        archive.extractall(tmp_path, filter="data")
    (tmp_path / "study").rename(tmp_path / "my-study")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_chapter_on_python_runs(workplace: Path) -> None:
    lines = blocks("from-python.md", "python")
    assert len(lines) > 8
    names: dict[str, object] = {}
    printed = io.StringIO()
    for block in lines:
        with redirect_stdout(printed):
            exec(compile(block, "from-python.md", "exec"), names)
    text = printed.getvalue()
    for part in ["total intervals include", "95 % interval", "2 recordings", "sub-02", "Z_p = (", "pickup"]:
        assert part in text, f"{part}: {text}"
    assert "<html" in (workplace / "report.html").read_text(encoding="utf-8")
    assert (workplace / "fig15_agreement.svg").is_file()


def exported(recording: fb.Recording, file: Path) -> None:
    """Writes what `export --as mat` writes of a recording, as far as the page uses it."""
    (force_s, normal_n), (_, lateral_n), (position_s, position_m) = recording.normal, recording.lateral, recording.position
    manifest = recording.manifest
    plate, channels = manifest["plate"], manifest["channels"]
    kinds = ["kind", "direction", "start_s", "end_s"]
    intervals = {key: np.array([i.get(key, "") for i in manifest["intervals"]], object) for key in kinds[:2]}
    intervals |= {key: np.array([i[key] for i in manifest["intervals"]]) for key in kinds[2:]}
    content = {
        "signals": {
            "rate_hz": recording.rate_hz,
            "drive_v": np.asarray(recording.drive, float) * channels["drive"]["volts_per_unit"],
            "pickup_m": np.asarray(recording.pickup, float) * channels["pickup"]["metres_per_unit"],
        },
        "forces": {"time_s": force_s, "normal_n": normal_n, "lateral_n": lateral_n},
        "positions": {"time_s": position_s, "position_m": position_m},
        "intervals": intervals,
        "constants": {
            "carrier_hz": manifest["carrier_hz"], "modulation_hz": manifest["modulation_hz"],
            "modulation_index": manifest["modulation_index"], "pickup_phase_rad": channels["pickup"]["phase_rad"],
            **{f"plate_{key}": plate[key] for key in ["resonance_hz", "modal_mass_kg", "force_factor_n_per_v", "centre_m"]},
        },
    }
    file.parent.mkdir()
    scipy.io.savemat(file, {"recording": content})


def test_the_python_half_of_the_page_on_matlab_runs(workplace: Path) -> None:
    name = "sub-01_ses-01_trial-001_attempt-1"
    recording = ROOT / "bench/tests/data/reference/recording-a"
    exported(fb.read(recording), workplace / f"my-export/{name}.mat")
    printed: list[str] = []
    names = matlab_lines.namespace(workplace, printed)
    lines = [line for block in blocks("from-matlab.md", "matlab") for line in matlab_lines.statements(block)]
    for line in lines:
        exec(compile(matlab_lines.python(line), f"from-matlab.md: {line}", "exec"), names)
    assert sum("py." in line for line in lines) > 10
    tau_s, gap_m, plot, study = printed
    assert 0.2e-3 < float(tau_s) < 5e-3
    assert 1e-6 < float(gap_m) < 1e-4
    assert plot.startswith("plot of")
    # From exported samples, in volts and metres, the estimates are those from the recording.
    analysed = fb.analyze(recording).results["recordings"][0]["trial"]
    assert float(tau_s) == pytest.approx(analysed["tau_s"], rel=1e-3)
    assert '"recordings"' in study
