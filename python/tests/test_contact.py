"""The contact model, compared with formulas in numpy."""

import numpy as np
import pytest
from docstrings import run_examples

import friction_bench as fb
from friction_bench import Contact, FrictionBenchError

SIGMA_T_M, S_M2, Q0, E_PA, NU, P0_PA, ETA = 1.9e-6, 250e-6, 1.1e4, 24e6, 0.45, 9.7e4, 0.27
Z_T, Z_P, CARRIER_HZ = 0.52 + 2.9j, 6.8 + 0.3j, 34_200.0
OMEGA = 2 * np.pi * CARRIER_HZ
P_C_S = 0.375 * Q0 * SIGMA_T_M * E_PA / (1 - NU**2) * S_M2
EXACT = {"rtol": 1e-12, "atol": 0.0}


@pytest.fixture(scope="module")
def contact() -> Contact:
    return Contact(
        sigma_t_m=SIGMA_T_M, z_t_n_s_per_m=Z_T, z_p_n_s_per_m=Z_P, carrier_hz=CARRIER_HZ, contact_area_m2=S_M2, q0_rad_per_m=Q0,
        young_modulus_pa=E_PA, poisson_ratio=NU, ambient_pressure_pa=P0_PA, loss_factor=ETA,
    )


@pytest.fixture(scope="module")
def loads() -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes and normal forces."""
    rng = np.random.default_rng(3)
    return 1e-6 * rng.uniform(0, 6, (40, 5)), rng.uniform(0.2, 3, (40, 5))


def asperity_n(gap_m: np.ndarray) -> np.ndarray:
    return P_C_S * np.exp(-gap_m / SIGMA_T_M)


def film_n(gap_m: np.ndarray, amplitude_m: np.ndarray) -> np.ndarray:
    return 1.25 * P0_PA * S_M2 * amplitude_m**2 / gap_m**2


def equilibrium_m(amplitude_m: np.ndarray, normal_n: np.ndarray) -> np.ndarray:
    """Solve Eq. 17 by bisection."""
    low = SIGMA_T_M * np.log(P_C_S / normal_n)
    high = low + 1e-3
    for _ in range(80):
        middle = 0.5 * (low + high)
        too_close = asperity_n(middle) + film_n(middle, amplitude_m) > normal_n
        low, high = np.where(too_close, middle, low), np.where(too_close, high, middle)
    return 0.5 * (low + high)


def test_forces_gap_stiffness_and_friction_are_those_of_the_equations(contact: Contact, loads: tuple[np.ndarray, np.ndarray]) -> None:
    a, n = loads
    x = equilibrium_m(a, n)
    np.testing.assert_allclose(contact.asperity_limit_n, P_C_S, **EXACT)
    np.testing.assert_allclose(contact.asperity_force_n(x), asperity_n(x), **EXACT)
    np.testing.assert_allclose(contact.squeeze_force_n(gap_m=x, amplitude_m=a), film_n(x, a), **EXACT)
    np.testing.assert_allclose(contact.normal_force_n(gap_m=x, amplitude_m=a), asperity_n(x) + film_n(x, a), **EXACT)
    np.testing.assert_allclose(contact.rest_gap_m(n), SIGMA_T_M * np.log(P_C_S / n), **EXACT)
    np.testing.assert_allclose(contact.rest_stiffness_n_per_m(n), n / SIGMA_T_M, **EXACT)
    np.testing.assert_allclose(contact.equilibrium_gap_m(amplitude_m=a, normal_n=n), x, **EXACT)
    k_c = asperity_n(x) / SIGMA_T_M + 2 * film_n(x, a) / x
    np.testing.assert_allclose(contact.stiffness_n_per_m(gap_m=x, amplitude_m=a), k_c, **EXACT)
    in_balance = asperity_n(x) / SIGMA_T_M + 2 * (n - asperity_n(x)) / x
    np.testing.assert_allclose(contact.balance_stiffness_n_per_m(gap_m=x, normal_n=n), in_balance, **EXACT)
    ratio = asperity_n(x) / n
    np.testing.assert_allclose(contact.friction_ratio(gap_m=x, normal_n=n), ratio, **EXACT)
    # The bisection's rounding of the gap is a larger one of the exponential.
    np.testing.assert_allclose(contact.friction(amplitude_m=a, normal_n=n, mu0=0.7), 0.7 * ratio, rtol=1e-10)


def test_impedances_are_those_of_the_equations(contact: Contact, loads: tuple[np.ndarray, np.ndarray]) -> None:
    a, n = loads
    x = equilibrium_m(a, n)
    k_c = contact.stiffness_n_per_m(gap_m=x, amplitude_m=a)
    z_c = (ETA - 1j) * k_c / OMEGA
    np.testing.assert_allclose(contact.contact_impedance_n_s_per_m(k_c), z_c, **EXACT)
    np.testing.assert_allclose(contact.stiffness_from_impedance_n_per_m(z_c), -OMEGA * z_c.imag, **EXACT)
    z_m = Z_P + Z_T * z_c / (Z_T + z_c)
    np.testing.assert_allclose(contact.observed_impedance_n_s_per_m(z_c), z_m, **EXACT)
    np.testing.assert_allclose(contact.impedance_n_s_per_m(amplitude_m=a, normal_n=n), z_m, rtol=1e-10)
    finger = z_m - Z_P
    np.testing.assert_allclose(contact.contact_from_observed_n_s_per_m(z_m), finger * Z_T / (Z_T - finger), **EXACT)
    tissue = contact.tissue_from_observed_n_s_per_m(z_m0_n_s_per_m=z_m, z_c0_n_s_per_m=z_c)
    np.testing.assert_allclose(tissue, finger * z_c / (z_c - finger), **EXACT)
    velocity = (0.3 + 0.1j) * np.ones_like(z_m)
    of_plate = {"z_m_n_s_per_m": z_m, "velocity_m_per_s": velocity}
    np.testing.assert_allclose(contact.contact_force_n(**of_plate), finger * velocity, **EXACT)
    np.testing.assert_allclose(contact.skin_velocity_m_per_s(**of_plate), finger / Z_T * velocity, **EXACT)


def test_inversions_lead_back(contact: Contact, loads: tuple[np.ndarray, np.ndarray]) -> None:
    a, n = loads
    x = contact.equilibrium_gap_m(amplitude_m=a, normal_n=n)
    k_c = contact.stiffness_n_per_m(gap_m=x, amplitude_m=a)
    np.testing.assert_allclose(contact.gap_from_stiffness_m(stiffness_n_per_m=k_c, amplitude_m=a), x, rtol=1e-9)
    in_balance = contact.balance_stiffness_n_per_m(gap_m=x, normal_n=n)
    np.testing.assert_allclose(contact.gap_from_balance_stiffness_m(stiffness_n_per_m=in_balance, normal_n=n), x, rtol=1e-9)


def test_a_stiffness_that_no_gap_has_gives_nan(contact: Contact) -> None:
    stiffness = np.array([-1.0, 0.0, 3e5])
    gaps = contact.gap_from_stiffness_m(stiffness_n_per_m=stiffness, amplitude_m=1e-6)
    assert np.isnan(gaps).tolist() == [True, True, False]
    gaps = contact.gap_from_balance_stiffness_m(stiffness_n_per_m=stiffness, normal_n=0.6)
    assert np.isnan(gaps).tolist() == [True, True, False]


def test_the_gap_follows_and_the_force_is_sensed_without_a_sensor() -> None:
    contact = Contact(sigma_t_m=1.7e-6, z_t_n_s_per_m=0.47 + 3.16j, z_p_n_s_per_m=7.01, tau_s=1.2e-3)
    interval_s = 2e-4
    time_s = interval_s * np.arange(3000)
    amplitude_m = 2e-6 * (1 + 0.9 * np.sin(2 * np.pi * 6 * time_s))
    normal_n = 0.6 + 0.05 * np.sin(2 * np.pi * 2 * time_s)
    equilibrium_m = contact.equilibrium_gap_m(amplitude_m=amplitude_m, normal_n=normal_n)
    gap_m = contact.lagging_gap_m(equilibrium_gap_m=equilibrium_m, interval_s=interval_s)
    lag_m = contact.tau_s * np.gradient(gap_m, interval_s)
    np.testing.assert_allclose((gap_m + lag_m)[100:-1], equilibrium_m[100:-1], rtol=2e-3)

    k_c = contact.stiffness_n_per_m(gap_m=gap_m, amplitude_m=amplitude_m)
    z_m = contact.observed_impedance_n_s_per_m(contact.contact_impedance_n_s_per_m(k_c))
    sensed = contact.self_sensed(z_m_n_s_per_m=z_m, amplitude_m=amplitude_m, interval_s=interval_s)
    np.testing.assert_allclose(sensed["gap_m"], gap_m, rtol=1e-9)
    np.testing.assert_allclose(sensed["normal_n"][100:-2], normal_n[100:-2], rtol=5e-3)
    assert np.isnan(sensed["normal_n"][:2]).all()
    friction = contact.friction_ratio(gap_m=gap_m, normal_n=normal_n)
    np.testing.assert_allclose(sensed["friction_ratio"][100:-2], friction[100:-2], rtol=5e-3)


def test_numbers_give_numbers_and_arrays_their_shape(contact: Contact) -> None:
    assert type(contact.rest_gap_m(0.5)) is float
    assert type(contact.contact_impedance_n_s_per_m(1e6)) is complex
    amplitude_m = np.linspace(0, 3e-6, 12).reshape(3, 4)
    gap_m = contact.equilibrium_gap_m(amplitude_m=amplitude_m, normal_n=0.5)
    assert gap_m.shape == (3, 4)
    swapped = amplitude_m.T.astype(">f8")
    np.testing.assert_array_equal(contact.equilibrium_gap_m(amplitude_m=swapped, normal_n=0.5), gap_m.T)
    assert contact.equilibrium_gap_m(amplitude_m=[1e-6, 2e-6], normal_n=1).shape == (2,)
    assert contact.rest_gap_m(np.array([])).shape == (0,)
    z_c = contact.contact_impedance_n_s_per_m(np.array([1e5, 1e6], np.float32))
    assert z_c.dtype == np.complex128
    np.testing.assert_array_equal(contact.observed_impedance_n_s_per_m(list(z_c)), contact.observed_impedance_n_s_per_m(z_c))


def test_nan_gives_nan(contact: Contact) -> None:
    gap_m = contact.equilibrium_gap_m(amplitude_m=[np.nan, 1e-6, 1e-6], normal_n=[0.5, np.nan, 0.5])
    assert np.isnan(gap_m).tolist() == [True, True, False]
    assert np.isnan(contact.rest_gap_m(float("nan")))
    z_c = contact.contact_from_observed_n_s_per_m(np.array([complex(np.nan, 1), 8 + 1j]))
    assert np.isnan(z_c).tolist() == [True, False]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda c: Contact(sigma_t_m=0.0), "sigma_t = 0 m: must be finite and above 0"),
        (lambda c: Contact(sigma_t_m=1e-6, poisson_ratio=0.6), "Poisson's ratio = 0.6: must be above -1 and at most 0.5"),
        (lambda c: Contact(sigma_t_m=1e-6, tau_s=-1.0), "tau_s = -1 s"),
        (lambda c: Contact(sigma_t_m=1e-6, z_t_n_s_per_m=complex("nan")), "z_t_n_s_per_m is not finite"),
        (lambda c: Contact(sigma_t_m=1e-6).impedance_n_s_per_m(amplitude_m=1e-6, normal_n=1), "has no `z_p_n_s_per_m`"),
        (lambda c: c.rest_gap_m([0.5, -0.1]), "sample 1: normal force = -0.1 N"),
        (lambda c: c.rest_gap_m(1e9), "is not below p_c S"),
        (lambda c: c.asperity_force_n(0.0), "gap = 0 m"),
        (lambda c: c.asperity_force_n(np.inf), "gap = inf m"),
        (lambda c: c.equilibrium_gap_m(amplitude_m=[1e-6] * 3, normal_n=[1.0] * 4), "`amplitude_m` has the shape (3,) and `normal_n` (4,)"),
        (lambda c: c.rest_gap_m(1j), "`normal_n` is complex"),
        (lambda c: c.rest_gap_m(["a"]), "`normal_n` has texts"),
        (lambda c: c.lagging_gap_m(equilibrium_gap_m=5e-6, interval_s=1e-3), "pass an array of one dimension"),
        (lambda c: c.lagging_gap_m(equilibrium_gap_m=[5e-6] * 3, interval_s=1e-3), "has 3 samples: pass at least 4"),
    ],
)
def test_errors_name_the_argument(contact: Contact, call: object, words: str) -> None:
    with pytest.raises(FrictionBenchError) as refused:
        call(contact)  # type: ignore[operator]
    assert words in str(refused.value)


def test_the_examples_in_the_docstrings_run() -> None:
    run_examples(fb.Contact)
    run_examples(fb.Contact.impedance_n_s_per_m)


def test_a_contact_shows_its_constants(contact: Contact) -> None:
    assert contact.carrier_hz == CARRIER_HZ
    assert eval(repr(contact), {"Contact": Contact}).rest_gap_m(0.5) == contact.rest_gap_m(0.5)
