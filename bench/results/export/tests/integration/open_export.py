"""Opens an export of the small study with numpy and scipy alone, and compares it with the recording it was made from."""

import csv
import gzip
import json
import sys
import tomllib
from pathlib import Path

import numpy as np
from scipy.io import loadmat, wavfile

form, export, recording = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
NAME = "sub-01_ses-01_trial-001_attempt-1"
SILENT = "sub-02_ses-01_trial-002_attempt-1"
FORCES = "sub-04_ses-01_trial-001_attempt-1"
ENVELOPES = "sub-05_ses-02_trial-003_attempt-2"

manifest = tomllib.loads((recording / "recording.toml").read_text())
rate_hz, samples = wavfile.read(recording / "signals.wav")
drive, pickup = manifest["channels"]["drive"], manifest["channels"]["pickup"]


def scaled(channel, factor):
    return (samples[:, channel].astype(np.float64) * factor).astype(np.float32)


def rows(path, delimiter=","):
    opened = gzip.open(path, "rt") if path.suffix == ".gz" else open(path, newline="")
    with opened as file:
        return list(csv.reader(file, delimiter=delimiter))


def numbers(path):
    """Columns of a table with a header, by their names; an empty cell is NaN."""
    header, *body = rows(path)
    columns = zip(*[[float(cell) if cell else np.nan for cell in row] for row in body])
    return dict(zip(header, map(np.array, columns)))


def same(one, other):
    one, other = np.asarray(one), np.asarray(other)
    assert one.shape == other.shape, (one.shape, other.shape)
    assert np.array_equal(one, other, equal_nan=True), np.max(np.abs(one - other))


def plausible(friction):
    """Friction whose columns belong together."""
    ratio = np.abs(friction["lateral_n"]) / friction["normal_n"]
    touching = friction["normal_n"] > 0.1
    assert touching.sum() > 1000
    assert np.allclose(friction["measured_mu"][touching], ratio[touching], rtol=1e-12)
    estimated = friction["instance"] > 0
    assert np.isfinite(friction["mu"][estimated]).all() and np.isnan(friction["mu"][~estimated]).all()
    assert np.abs(friction["mu"][estimated] - friction["measured_mu"][estimated]).mean() < 0.1
    assert (friction["direction"] == 1).all()


force, position = numbers(recording / "force.csv"), numbers(recording / "position.csv")


def mat():
    files = sorted(path.name for path in export.iterdir())
    assert files == [f"{name}.mat" for name in (NAME, SILENT, FORCES, ENVELOPES)], files
    content = loadmat(export / f"{NAME}.mat", squeeze_me=True, struct_as_record=False)
    assert [name for name in content if not name.startswith("__")] == ["recording"]
    trial = content["recording"]
    assert (trial.name, trial.participant, trial.session, trial.attempt) == (NAME, "sub-01", 1, 1)
    assert (trial.condition, trial.protocol, trial.method) == ("dry", "demo", "trial")
    assert trial.signals.rate_hz == rate_hz and trial.signals.start_s == 0
    assert trial.signals.drive_v.dtype == np.float32
    same(trial.signals.drive_v, scaled(drive["index"], drive["volts_per_unit"]))
    same(trial.signals.pickup_m, scaled(pickup["index"], pickup["metres_per_unit"]))
    for name in force:
        same(getattr(trial.forces, name), force[name])
    for name in position:
        same(getattr(trial.positions, name), position[name])
    assert trial.constants.plate_modal_mass_kg == manifest["plate"]["modal_mass_kg"]
    assert np.isnan(trial.constants.ambient_pressure_pa)
    assert trial.units.forces.normal_n == "N" and trial.units.constants.plate_force_factor_n_per_v == "N/V"
    assert trial.units.friction.re_z_m_n_s_per_m == "N*s/m"
    assert list(trial.intervals.kind) == ["unloaded", "exploration"]
    assert list(trial.intervals.start_s) == [0.2, 1.4]
    assert trial.events.kind == "note" and trial.events.text == "a remark"
    assert trial.friction.instance.dtype == np.int64
    plausible(vars(trial.friction))
    for name in trial.friction._fieldnames:
        assert len(getattr(trial.meanings.friction, name)) > 5
    silent = loadmat(export / files[1], squeeze_me=True, struct_as_record=False)["recording"]
    assert not hasattr(silent, "forces") and (silent.signals.channel_2 == 0.25).all()
    forces = loadmat(export / files[2], squeeze_me=True, struct_as_record=False)["recording"]
    assert set(forces.friction._fieldnames) >= {"measured_mu", "stimulus"} and not hasattr(forces.friction, "amplitude_m")
    assert np.allclose(forces.friction.measured_mu, 0.4 - 0.1 * forces.friction.stimulus) and set(forces.friction.stimulus) == {0, 1}
    assert not hasattr(forces, "signals") and np.isnan(forces.constants.carrier_hz) and forces.stimulus.time_s.shape == (2000,)
    envelopes = loadmat(export / files[3], squeeze_me=True, struct_as_record=False)["recording"]
    same(envelopes.envelopes.drive_im_v, np.arange(2000.0))
    assert (envelopes.envelopes.pickup_im_m == 1e-6).all() and (envelopes.session, envelopes.attempt) == (2, 2)
    # Matrices have one column.
    assert loadmat(export / f"{NAME}.mat")["recording"]["forces"][0, 0]["time_s"][0, 0].shape == (len(force["time_s"]), 1)


def npz():
    with np.load(export / f"{NAME}.npz", allow_pickle=False) as trial:
        assert trial["participant"] == "sub-01" and trial["session"] == 1 and trial["method"] == "trial"
        assert trial["signals_rate_hz"] == rate_hz and trial["carrier_hz"] == manifest["carrier_hz"]
        same(trial["signals_drive_v"], scaled(drive["index"], drive["volts_per_unit"]))
        same(trial["signals_pickup_m"], scaled(pickup["index"], pickup["metres_per_unit"]))
        for name in force:
            same(trial[f"forces_{name}"], force[name])
        for name in position:
            same(trial[f"positions_{name}"], position[name])
        assert list(trial["intervals_kind"]) == ["unloaded", "exploration"]
        assert list(trial["intervals_direction"]) == ["", "left_to_right"]
        start = len("friction_")
        plausible({name[start:]: trial[name] for name in trial.files if name.startswith("friction_")})
        units = dict(zip(trial["dictionary_array"], trial["dictionary_unit"]))
        assert units["friction_gap_m"] == "m" and units["forces_lateral_n"] == "N"
        # Every array but the dictionary's own and the warnings is in the dictionary.
        unknown = {name for name in trial.files if not name.startswith("dictionary_")} - set(units)
        assert unknown == {"warnings"}, unknown


def tables():
    folder = export / NAME
    signals = numbers(folder / "signals.csv")
    same(signals["time_s"], np.arange(len(samples)) / rate_hz)
    same(signals["drive_v"].astype(np.float32), scaled(drive["index"], drive["volts_per_unit"]))
    same(signals["pickup_m"].astype(np.float32), scaled(pickup["index"], pickup["metres_per_unit"]))
    for name, values in numbers(folder / "forces.csv").items():
        same(values, force[name])
    for name, values in numbers(folder / "positions.csv").items():
        same(values, position[name])
    plausible(numbers(folder / "friction.csv"))
    assert rows(folder / "intervals.csv")[1:] == [["unloaded", "", "0.2", "1"], ["exploration", "left_to_right", "1.4", "3.0999999999999996"]]
    facts = dict(row for row in rows(folder / "recording.csv"))
    assert facts["condition"] == "dry" and facts["trial"] == "1"
    constants = {name: (float(value or "nan"), unit) for name, value, unit in rows(folder / "constants.csv")[1:]}
    assert constants["carrier_hz"] == (manifest["carrier_hz"], "Hz")
    header, *dictionary = rows(export / "columns.csv")
    assert header == ["table", "name", "unit", "meaning"]
    known = {(table, name) for table, name, _, _ in dictionary}
    for table in folder.iterdir():
        if table.name not in ("recording.csv", "constants.csv"):
            for name in rows(table)[0]:
                assert (table.name, name) in known, (table.name, name)


def series(path):
    """Columns of a table without a header, by the names in its sidecar."""
    sidecar = json.loads(Path(str(path).removesuffix(".tsv.gz") + ".json").read_text())
    cells = [[np.nan if cell == "n/a" else float(cell) for cell in row] for row in rows(path, "\t")]
    return sidecar, dict(zip(sidecar["Columns"], np.array(cells).T))


def bids():
    beh, motion = export / "sub-01/ses-01/beh", export / "sub-01/ses-01/motion"
    begin = "sub-01_ses-01_task-exploration"
    sidecar, forces = series(beh / f"{begin}_run-001_recording-forces_physio.tsv.gz")
    for name in force:
        same(forces[name], force[name])
    assert sidecar["normal_n"]["Units"] == "N" and sidecar["StartTime"] == force["time_s"][0]
    steps = np.diff(force["time_s"])
    assert np.isclose(sidecar["SamplingFrequency"], 1 / np.median(steps), rtol=1e-6)
    sidecar, friction = series(beh / f"{begin}_run-001_recording-friction_physio.tsv.gz")
    plausible(friction)
    even = sidecar["StartTime"] + np.arange(len(friction["time_s"])) / sidecar["SamplingFrequency"]
    assert np.allclose(friction["time_s"], even, atol=1e-6)
    cells = np.array(rows(motion / f"{begin}_tracksys-position_run-001_motion.tsv", "\t"), dtype=float)
    same(cells[:, 0], position["time_s"])
    same(cells[:, 1], position["position_m"])
    events = rows(beh / f"{begin}_run-001_events.tsv", "\t")
    assert [row[2] for row in events[1:]] == ["note", "unloaded", "exploration"], events
    assert events[3][:2] == ["1.4", "1.6999999999999997"] and events[3][3:] == ["left_to_right", "dry"]
    source = export / "sourcedata/sub-01/ses-01/trial-001_attempt-1"
    for file in ["recording.toml", "signals.wav", "force.csv", "position.csv"]:
        assert (source / file).read_bytes() == (recording / file).read_bytes()
    assert (source.parent / "demo.toml").exists()
    sidecar, stimulus = series(export / f"sub-04/ses-01/beh/{begin.replace('01', '04', 1)}_run-001_stim.tsv.gz")
    assert stimulus["stimulus"].mean() == 0.5 and "PhysioType" not in sidecar
    name = f"{begin.replace('sub-01_ses-01', 'sub-05_ses-02')}_run-003_recording-envelopes_physio.tsv.gz"
    sidecar, envelopes = series(export / "sub-05/ses-02/beh" / name)
    assert (envelopes["drive_re_v"] == 10).all() and np.isclose(sidecar["SamplingFrequency"], 1e4)
    people = rows(export / "participants.tsv", "\t")
    assert [row[0] for row in people] == ["participant_id", "sub-01", "sub-02", "sub-04", "sub-05"], people
    assert people[1][2:4] == ["n/a", "female"] and people[1][people[0].index("age_as_stated")] == "18-38"
    assert json.loads((export / "dataset_description.json").read_text())["Name"] == "Wet and dry"


{"mat": mat, "npz": npz, "csv": tables, "bids": bids}[form]()
