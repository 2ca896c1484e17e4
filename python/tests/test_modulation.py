"""A modulation that is not stated is found in the drive."""

from typing import Any

import numpy as np
import pytest

import friction_bench as fb


def test_the_modulation_of_a_drive_is_found() -> None:
    simulation = fb.simulate("steady", 4, rate_hz=96_000, strokes=1, modulation_hz=4.7)
    stated = simulation.arguments()
    unstated = {key: value for key, value in stated.items() if not key.startswith("modulation_")}
    known, found = fb.analyze(**stated), fb.analyze(**unstated)
    np.testing.assert_allclose(found.instances["modulation_hz"], known.instances["modulation_hz"], rtol=1e-4)
    assert known.instances["modulation_hz"][0] == pytest.approx(4.7)
    np.testing.assert_allclose(found.estimates["sigma_t_m"], known.estimates["sigma_t_m"], rtol=1e-3)


def unstated(**changes: Any) -> dict[str, Any]:
    """Return the arguments of a simulation without its modulation."""
    arguments = fb.simulate("steady", 4, rate_hz=96_000, duration_s=1.5).arguments()
    return {key: value for key, value in arguments.items() if not key.startswith("modulation_")} | changes


@pytest.mark.parametrize(
    ("scale", "words"),
    [(0.0, "the drive is off: its RMS is 0 V throughout"), (1e-7, "the carrier's RMS is at most"), (None, "less than 0.3 s")],
)
def test_a_drive_that_is_off_is_named_with_the_next_step(scale: float | None, words: str) -> None:
    arguments = unstated()
    count = len(arguments["drive"])
    if scale is None:
        arguments |= {name: arguments[name][48_000:67_200] for name in ("drive", "pickup")}
    else:
        noise = np.random.default_rng(1).normal(0.0, 1e-4 * (scale > 0), count)
        arguments["drive"] = scale * arguments["drive"] + noise
    with pytest.raises(fb.FrictionBenchError) as refused:
        fb.analyze(**arguments)
    message = str(refused.value)
    assert words in message and " V" in message, message
    assert "Pass the voltage across the actuators as `drive`" in message and "is missing" not in message
