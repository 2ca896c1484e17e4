"""A use of each name of the package, with the types that a reader of its documentation expects: mypy checks it, nothing runs it."""

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import friction_bench as fb


def own_arrays(drive: npt.NDArray[np.int16], pickup: npt.NDArray[np.float32], force_n: list[float]) -> fb.Analysis:
    times_s = [index * 1e-3 for index in range(len(force_n))]
    plate = fb.Plate(resonance_hz=35e3, modal_mass_kg=8e-3, force_factor_n_per_v=0.13, centre_m=0.0525)
    return fb.analyze(
        drive, pickup, 192_000,
        carrier_hz=35e3, modulation_hz=6.0, modulation_index=0.95, plate=plate,
        normal=(times_s, force_n), lateral=(times_s, force_n), position=(times_s, force_n),
        intervals=[("unloaded", 0.0, 1.0), ("exploration", 2.0, 9.0, "right_to_left")],
        pickup_scale=fb.Pickup(metres_per_unit=2e-6, phase_rad=0.1), drive_volts_per_unit=60.0,
        settings={"contact_area_m2": 314e-6},
    )


def folders(paths: list[Path]) -> fb.Analysis:
    def progress(done: int, total: int) -> None:
        print(done, "of", total)

    one: fb.Analysis = fb.analyze("study", practice=True)
    assert one.results
    return fb.analyze(paths, settings=fb.Settings(loss_factor=0.6), exclude=["study/backup"], progress=progress)


def results(analysis: fb.Analysis) -> tuple[str, list[str], dict[str, str]]:
    found: dict[str, Any] = analysis.results
    rows: int = analysis.samples.num_rows
    names: list[str] = analysis.instances.column_names
    print(found["recordings"], rows, names, analysis.estimates, analysis.explorations, analysis.trials, analysis.participants)
    Path("results.json").write_text(analysis.to_json())
    return analysis.report(), analysis.warnings, analysis.figures()


def signals(recording: fb.Recording) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.float64]]:
    envelope, time_s = fb.envelopes(recording.pickup, recording.rate_hz, carrier_hz=recording.carrier_hz)
    z_m, same_time_s = fb.impedance(
        recording.drive, recording.pickup, recording.rate_hz, carrier_hz=recording.carrier_hz, plate=recording.plate,
        pickup_scale=fb.Pickup(metres_per_unit=2e-6),
    )
    assert len(envelope) == len(z_m) and len(time_s) == len(same_time_s)
    return z_m, time_s


def contact(amplitude_m: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    model = fb.Contact(sigma_t_m=1.7e-6)
    gap_m = model.equilibrium_gap_m(amplitude_m=amplitude_m, normal_n=0.6)
    return np.asarray(model.friction_ratio(gap_m=gap_m, normal_n=0.6))


def simulation() -> dict[str, Any]:
    simulated: fb.Simulation = fb.simulate("population-unkind", seed=3)
    same: fb.Analysis = fb.analyze(**simulated.arguments())
    assert same.results
    return simulated.truth


def recorded() -> list[dict[str, Any]]:
    recording: fb.Recording = fb.read("study/sub-01/ses-01/trial-001_attempt-1")
    print(recording.manifest["carrier_hz"])
    return fb.import_map("map.toml", study="study", dry_run=True)


def failure() -> str:
    try:
        fb.read("nowhere")
    except fb.FrictionBenchError as error:
        refused: ValueError = error
        return str(refused)
    return fb.__version__
