"""Writes gaps.csv: the gap equation and the gap from stiffness, solved by scipy's brentq. Run with numpy and scipy at hand."""

import itertools
import numpy as np
import scipy
from scipy.optimize import brentq

Q0, NU, E, S, P0 = 1.4e4, 0.5, 20e6, 300e-6, 101325.0
SQUEEZE = 1.25 * P0 * S


def root(f, lo, hi):
    return brentq(f, lo, hi, xtol=1e-300, rtol=4 * np.finfo(float).eps, maxiter=500)


rows = []
for sigma_um, normal, amplitude_um in itertools.product(
    [0.3, 1.0, 1.7, 4.0, 12.0], [0.01, 0.65, 5.0], [0.0, 1e-4, 0.05, 0.5, 2.0, 20.0]
):
    sigma, amplitude = sigma_um * 1e-6, amplitude_um * 1e-6
    limit = 0.375 * Q0 * sigma * E / (1 - NU**2) * S
    # In units of sigma_t, from the gap at rest up: w = (x - x0)/sigma.
    rest = np.log(limit / normal)
    load = SQUEEZE / normal * (amplitude / sigma) ** 2
    w = 0.0 if load == 0 else root(lambda w: -np.expm1(-w) * (rest + w) ** 2 - load, 0.0, 1.0 + 2 * np.sqrt(load))
    gap = sigma * (rest + w)
    carried = np.exp(-w)
    stiffness = normal * carried / sigma + 2 * normal * (1 - carried) / gap
    rows.append((sigma, normal, amplitude, gap, stiffness, carried))

with open("gaps.csv", "w") as f:
    f.write(f"# scipy {scipy.__version__} brentq, numpy {np.__version__}; q0 1.4e4 rad/m, nu 0.5, E 20 MPa, S 300 mm2, p0 101325 Pa\n")
    f.write("sigma_t_m,normal_n,amplitude_m,gap_m,k_c_n_per_m,mu_ratio\n")
    for row in rows:
        f.write(",".join(repr(float(v)) for v in row) + "\n")
