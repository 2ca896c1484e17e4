"""Simulated recordings: their truth is found by the analysis."""

import _thread
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from docstrings import run_examples

import friction_bench as fb

SHORT: dict[str, Any] = {"rate_hz": 96_000, "strokes": 1}


def within(interval: list[float], value: float) -> bool:
    return interval[0] <= value <= interval[1]


def estimates(simulation: fb.Simulation) -> tuple[dict[str, Any], list[tuple[dict[str, Any], float, complex]]]:
    """Return the estimates of the trial, and those of each instance with its true σ_t and Z_t."""
    result = fb.analyze(**simulation.arguments()).results["recordings"][0]
    series = simulation.truth["series"]
    instances = []
    for instance in result["instances"]:
        during = (instance["start_s"] <= series["time_s"]) & (series["time_s"] < instance["end_s"])
        instances.append((instance["trial"], series["sigma_t_m"][during].mean(), series["z_t_n_s_per_m"][during].mean()))
    assert len(instances) > 5
    return result["trial"], instances


def test_the_analysis_finds_the_truth_of_the_steady_scenario() -> None:
    simulation = fb.simulate("steady", 1)
    trial, instances = estimates(simulation)
    truth = simulation.truth
    for estimate, sigma_t_m, z_t in instances:
        assert estimate["sigma_t_m"] == pytest.approx(sigma_t_m, rel=0.02)
        assert complex(*estimate["z_t_n_s_per_m"]) == pytest.approx(z_t, rel=0.03)
        assert estimate["mu0"] == pytest.approx(truth["mu0"], rel=0.02)
    for name, error in [("contact_area_m2", 0.03), ("q0_rad_per_m", 0.06), ("loss_factor", 0.03), ("tau_s", 0.15)]:
        assert trial[name] == pytest.approx(truth[name], rel=error), name


def test_the_intervals_of_an_unkind_scenario_have_the_truth() -> None:
    simulation = fb.simulate("population-unkind", 6)
    _, instances = estimates(simulation)
    for estimate, sigma_t_m, z_t in instances:
        interval = estimate["interval95"]
        assert within(interval["sigma_t_m"], sigma_t_m)
        assert within(interval["z_t_re_n_s_per_m"], z_t.real)
        assert within(interval["z_t_im_n_s_per_m"], z_t.imag)
        assert estimate["sigma_t_m"] == pytest.approx(sigma_t_m, rel=0.05)


def test_the_streams_show_what_is_true() -> None:
    simulation = fb.simulate("steady", 4, **SHORT)
    series, truth = simulation.truth["series"], simulation.truth
    assert simulation.drive.dtype == simulation.pickup.dtype == np.float32
    assert len(simulation.drive) == len(simulation.pickup)
    assert np.abs(simulation.drive).max() == pytest.approx(24.0 * 1.95, rel=0.03)
    (kind, start_s, end_s, direction) = next(interval for interval in simulation.intervals if interval[0] == "exploration")
    assert (kind, direction) == ("exploration", "left_to_right")
    during = (series["time_s"] > start_s + 0.5) & (series["time_s"] < end_s)
    for name, true_name, error in [("normal", "normal_n", 2e-3), ("position", "position_m", 1e-4)]:
        time_s, values = getattr(simulation, name)
        assert (np.diff(time_s) > 0).all()
        read = np.interp(series["time_s"][during], time_s, values)
        np.testing.assert_allclose(read, series[true_name][during], atol=error)
    for _, start_s, end_s in (interval for interval in simulation.intervals if interval[0] == "unloaded"):
        unloaded = (series["time_s"] > start_s) & (series["time_s"] < end_s)
        assert (series["normal_n"][unloaded] == 0).all()
        assert np.isnan(series["gap_m"][unloaded]).all()
    assert truth["scenario"]["participant"]["sigma_t_m"] == truth["sigma_t_m"] == 1.7e-6
    z_m, time_s = fb.impedance(
        simulation.drive, simulation.pickup, simulation.rate_hz, carrier_hz=simulation.carrier_hz, plate=simulation.plate,
        pickup_scale=simulation.pickup_scale,
    )
    unloaded = (time_s > 0.3) & (time_s < 0.9)
    assert np.median(z_m[unloaded].real) == pytest.approx(truth["z_p_n_s_per_m"].real, rel=0.01)


def test_the_same_arguments_give_the_same_samples() -> None:
    first, second = (fb.simulate("population-unkind", 3, duration_s=1.5, rate_hz=96_000) for _ in range(2))
    np.testing.assert_array_equal(first.drive, second.drive)
    np.testing.assert_array_equal(first.pickup, second.pickup)
    other = fb.simulate("population-unkind", 4, participant_seed=3, duration_s=1.5, rate_hz=96_000)
    assert other.truth["sigma_t_m"] == first.truth["sigma_t_m"]
    assert (other.pickup != first.pickup).any()


def test_an_uncalibrated_bench_states_nominal_constants() -> None:
    calibrated, nominal = (fb.simulate("bench-unknown", 2, duration_s=1, calibrated=calibrated) for calibrated in (True, False))
    plate = calibrated.truth["scenario"]["plate"]
    assert calibrated.plate.resonance_hz == calibrated.carrier_hz == plate["resonance_hz"]
    assert (nominal.plate.resonance_hz, nominal.carrier_hz) == (35_000.0, 35_000.0)
    assert nominal.plate.force_factor_n_per_v != plate["force_factor_n_per_v"]


def test_a_scenario_is_a_name_a_path_a_text_or_keys(tmp_path: Path) -> None:
    text = "[participant]\nsigma_t_m = 2.1e-6\n"
    file = tmp_path / "soft skin.toml"
    file.write_text(text, encoding="utf-8")
    for scenario in (file, str(file), text, {"participant": {"sigma_t_m": 2.1e-6}}):
        assert fb.simulate(scenario, duration_s=1, rate_hz=96_000).truth["sigma_t_m"] == 2.1e-6


def test_progress_ends_at_the_total_and_its_exception_ends_the_simulation() -> None:
    calls: list[tuple[int, int]] = []
    fb.simulate("steady", duration_s=3, rate_hz=96_000, progress=lambda done, total: calls.append((done, total)))
    assert calls == [(1, 3), (2, 3), (3, 3)]

    def refuse(done: int, total: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fb.simulate("steady", duration_s=600, progress=refuse)


def test_ctrl_c_ends_a_simulation() -> None:
    threading.Timer(0.3, _thread.interrupt_main).start()
    with pytest.raises(KeyboardInterrupt):
        fb.simulate("steady", duration_s=600)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"scenario": "stedy"}, "did you mean `steady`"),
        ({"scenario": "missing.toml"}, "cannot read the scenario missing.toml: it does not exist"),
        ({"scenario": "[participant]\nmu0 = 9.0\n"}, "scenario, line 2: participant.mu0 = 9"),
        ({"scenario": {"participnt": {}}}, "unknown key `participnt`, did you mean `participant`?"),
        ({"scenario": {"participant": {"mu0": None}}}, "omit keys instead of passing None"),
        ({"scenario": 3}, "`scenario` is no scenario"),
        ({"seed": -1}, "`seed` is no whole number"),
        ({"strokes": 0}, "strokes = 0"),
        ({"rate_hz": 44_100}, "rate_hz = 44100"),
        ({"duration_s": 1e4}, "duration_s = 10000 s"),
        ({"modulation_index": 1.5}, "modulation_index = 1.5"),
        ({"mean_amplitude_v": 50.0}, "mean_amplitude_v = 50 V"),
        ({"carrier_hz": 95e3}, "carrier_hz = 95000 Hz"),
    ],
)
def test_errors_name_the_argument(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(fb.FrictionBenchError) as refused:
        fb.simulate(**{"scenario": "steady", **arguments})
    assert words in str(refused.value)


def test_the_example_in_the_docstring_runs() -> None:
    run_examples(fb.simulate)
