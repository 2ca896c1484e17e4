"""A modulation that is not stated is found in the drive."""

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


def test_a_drive_that_is_off_has_none() -> None:
    arguments = fb.simulate("steady", 4, rate_hz=96_000, strokes=1).arguments()
    arguments = {key: value for key, value in arguments.items() if not key.startswith("modulation_")}
    with pytest.raises(fb.FrictionBenchError, match="modulation_hz"):
        fb.analyze(**{**arguments, "drive": np.zeros(len(arguments["drive"]))})
