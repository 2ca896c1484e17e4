"""The curves of the published model."""

import numpy as np
import pytest
from docstrings import run_examples

import friction_bench as fb


def test_the_curves_are_those_of_the_contact() -> None:
    curves = fb.model.curves(sigma_t_m=1.5e-6, loss_factor=0.2, mu0=0.6)
    tissue = complex(32.0, 2 * np.pi * 35e3 * 1e-4)
    contact = fb.Contact(
        sigma_t_m=1.5e-6, contact_area_m2=314e-6, loss_factor=0.2, z_t_n_s_per_m=tissue, z_p_n_s_per_m=7.01, carrier_hz=35e3
    )
    gap = curves["gap"]
    load = {"amplitude_m": gap["amplitude_m"], "normal_n": gap["normal_n"]}
    np.testing.assert_allclose(contact.equilibrium_gap_m(**load), gap["gap_m"], rtol=1e-12)
    stiffness = contact.balance_stiffness_n_per_m(gap_m=gap["gap_m"], normal_n=gap["normal_n"])
    np.testing.assert_allclose(curves["stiffness"]["k_c_n_per_m"], stiffness, rtol=1e-12)
    impedance = curves["impedance"]["z_m_re_n_s_per_m"] + 1j * curves["impedance"]["z_m_im_n_s_per_m"]
    np.testing.assert_allclose(contact.impedance_n_s_per_m(**load), impedance, rtol=1e-9)
    friction = curves["friction"]
    expected = contact.friction(amplitude_m=friction["amplitude_m"], normal_n=friction["normal_n"], mu0=0.6)
    np.testing.assert_allclose(friction["mu"], expected, rtol=1e-12)
    film = curves["film_force"]
    expected = contact.squeeze_force_n(gap_m=film["gap_m"], amplitude_m=film["amplitude_m"])
    np.testing.assert_allclose(film["film_n"], expected, rtol=1e-12)
    left = curves["force_left_to_film"]
    expected = left["normal_n"] - contact.asperity_force_n(left["gap_m"])
    np.testing.assert_allclose(left["left_to_film_n"], expected, atol=1e-12)
    motion = curves["motion"]
    np.testing.assert_allclose(motion["plate_m"], motion["amplitude_m"] * np.cos(2 * np.pi * 35e3 * motion["time_s"]), atol=1e-15)
    by_stiffness = curves["impedance_by_stiffness"]
    z_c = (by_stiffness["loss_factor"] - 1j) * by_stiffness["k_c_n_per_m"] / (2 * np.pi * 35e3)
    z_m = contact.observed_impedance_n_s_per_m(z_c)
    np.testing.assert_allclose(by_stiffness["z_m_re_n_s_per_m"] + 1j * by_stiffness["z_m_im_n_s_per_m"], z_m, rtol=1e-12)


def test_the_columns_of_a_set_have_one_length() -> None:
    for name, columns in fb.model.curves().items():
        lengths = {len(values) for values in columns.values()}
        assert len(lengths) == 1, name
        assert all(np.isfinite(values).all() for values in columns.values()), name


@pytest.mark.parametrize(("assumption", "words"), [("mu0", "mu0 = -1: must be"), ("sigma_t_m", "sigma_t = -1 m"), ("plate_mass_kg", "kg")])
def test_a_negative_assumption_is_refused(assumption: str, words: str) -> None:
    with pytest.raises(fb.FrictionBenchError, match=words):
        fb.model.curves(**{assumption: -1.0})


def test_the_example_in_the_docstring_runs() -> None:
    run_examples(fb.model.curves)
