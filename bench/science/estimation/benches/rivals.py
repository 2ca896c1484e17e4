"""What the benchmarks are set beside: the same work in numpy and scipy, as a laboratory would write it.

`rivals.py NAME N` does NAME N times, after once to warm up, and prints the seconds that took and a number that the answer
comes to. `rivals.py ratios FOLDER` prints what criterion measured into FOLDER beside what is required.
"""
import json
import pathlib
import sys
import time

import numpy as np

RATE_HZ, CARRIER_HZ, SECONDS, OUTPUT_RATE_HZ = 192_000, 35_000.0, 60, 2000
OMEGA = 2 * np.pi * CARRIER_HZ
MODAL_MASS_KG = 0.008
NEWTONS_PER_UNIT, METRES_PER_UNIT = 0.13 * 60, 5e-6
SIGMA_T_M, AREA_M2, P0_PA = 1.7e-6, 300e-6, 101_325.0
P_C_PA = 0.375 * 1.4e4 * SIGMA_T_M * 20e6 / (1 - 0.5**2)


def signals():
    t = np.arange(SECONDS * RATE_HZ) / RATE_HZ
    envelope = 1 + 0.95 * np.sin(2 * np.pi * 6 * t)
    drive = (0.4 * envelope * np.sin(2 * np.pi * CARRIER_HZ * t)).astype(np.float32)
    pickup = (0.3 * envelope * np.cos(2 * np.pi * CARRIER_HZ * t)).astype(np.float32)
    return drive, pickup


def hilbert():
    """The published chain: analytic signals, ratio, 100 Hz zero-phase Butterworth, decimation."""
    from scipy import signal

    drive, pickup = signals()
    sos = signal.butter(2, 100, fs=RATE_HZ, output="sos")
    to_z = NEWTONS_PER_UNIT / (1j * OMEGA * METRES_PER_UNIT)

    def work():
        ratio = signal.hilbert(drive) / signal.hilbert(pickup)
        smooth = signal.sosfiltfilt(sos, ratio.real) + 1j * signal.sosfiltfilt(sos, ratio.imag)
        return to_z * smooth[:: RATE_HZ // OUTPUT_RATE_HZ]

    return work, lambda z: np.median(np.abs(z))


def lock_in():
    """Reference, mixing, low-pass of this bench's length and cut-off at the output rate alone, ratio corrected for the envelope."""
    from scipy import signal

    drive, pickup = signals()
    step = RATE_HZ // OUTPUT_RATE_HZ
    window = 2 * signal.firwin(999, OUTPUT_RATE_HZ / 2, window=("kaiser", 11.2), fs=RATE_HZ)

    def work():
        reference = np.exp(-1j * OMEGA / RATE_HZ * np.arange(len(drive)))
        envelope = lambda x: signal.upfirdn(window, x * reference, down=step)
        force = NEWTONS_PER_UNIT * envelope(drive)
        x = METRES_PER_UNIT * envelope(pickup)
        dx = np.gradient(x, 1 / OUTPUT_RATE_HZ)
        v = 1j * OMEGA * x + dx
        return (force - 2 * MODAL_MASS_KG * np.gradient(v, 1 / OUTPUT_RATE_HZ)) / v

    edge = len(window) // step + 2
    return work, lambda z: np.median(np.abs(z[edge:-edge]))


def gaps():
    a = np.linspace(0.05e-6, 3.9e-6, 100_000)
    f_c = np.full_like(a, 0.65)
    rest = SIGMA_T_M * np.log(P_C_PA * AREA_M2 / f_c)
    squeeze = 1.25 * P0_PA * AREA_M2 * a**2
    return rest, squeeze, f_c


def brentq():
    from math import exp, sqrt

    from scipy.optimize import brentq as solve

    rest, squeeze, f_c = gaps()

    def work():
        # math.exp: on a single number it is several times as fast as numpy's.
        return [
            solve(
                lambda x: f * (1 - exp((x0 - x) / SIGMA_T_M)) - s / x**2,
                x0,
                x0 + 10 * SIGMA_T_M + 2 * sqrt(s / f),
                xtol=1e-18,
                rtol=1e-12,
            )
            for x0, s, f in zip(rest.tolist(), squeeze.tolist(), f_c.tolist())
        ]

    return work, np.mean


def equilibrium(rest, squeeze, f_c, sigma_t_m):
    """All gaps at once, Newton from the squeeze film's asymptote until the step is under 1e-12."""
    x = np.maximum(rest, np.sqrt(squeeze / f_c)) + 0.5 * sigma_t_m
    for _ in range(50):
        e = np.exp((rest - x) / sigma_t_m)
        step = (f_c * (1 - e) - squeeze / x**2) / (f_c * e / sigma_t_m + 2 * squeeze / x**3)
        x = np.maximum(x - step, rest)
        if np.max(np.abs(step) / x) < 1e-12:
            break
    return x


def newton():
    rest, squeeze, f_c = gaps()
    return lambda: equilibrium(rest, squeeze, f_c, SIGMA_T_M), np.mean


def least_squares():
    """sigma_t of one instance by the published method: Eq. 21, gap, stiffness and Z_m for each trial value."""
    from scipy import optimize

    z_p = 7.01

    def contact(amplitude, normal, sigma_t_m):
        """k_c by Eqs. 17 and 18."""
        p_c = P_C_PA / SIGMA_T_M * sigma_t_m
        rest = sigma_t_m * np.log(p_c * AREA_M2 / normal)
        squeeze = 1.25 * P0_PA * AREA_M2 * amplitude**2
        gap = equilibrium(rest, squeeze, normal, sigma_t_m)
        return normal * np.exp((rest - gap) / sigma_t_m) / sigma_t_m + 2 * squeeze / gap**3

    to_z_c = (0.3 - 1j) / OMEGA
    observed = lambda z_t, z_c: z_p + z_t * z_c / (z_t + z_c)

    index = np.arange(20, 80)
    t = index / 1000 - 0.05
    amplitude = 1.95e-6 * (1 + 0.95 * np.sin(2 * np.pi * 6 * t))
    normal = 0.65 + 0.03 * np.cos(2 * np.pi * 1.3 * t)
    z_m = observed(0.47 + 3.16j, to_z_c * contact(amplitude, normal, SIGMA_T_M)) + 0.01 * np.exp(1j * index)

    def work():
        below = amplitude < 0.2e-6
        if not below.any():
            below = amplitude <= np.sort(amplitude)[4]
        finger = z_m[below].mean() - z_p
        mean_n = np.full_like(amplitude, normal.mean())

        def residual(p):
            sigma_t_m = np.exp(p[0])
            z_c0 = to_z_c * mean_n[0] / sigma_t_m
            z_t = finger * z_c0 / (z_c0 - finger)
            off = observed(z_t, to_z_c * contact(amplitude, mean_n, sigma_t_m)) - z_m
            return np.concatenate([off.real, off.imag])

        return np.exp(optimize.least_squares(residual, [np.log(2e-6)], method="lm").x[0])

    return work, float


def trial_least_squares():
    """The published laws alone: S, q0, eta and tau of a trial with sigma_t, Z_t and the plate's offset of each of 14 instances, from the four
    starts of this bench's fit."""
    from scipy import optimize, signal

    z_p, rate_hz, lead, n = 7.01, 2000, 40, 14
    index = np.arange(160)
    t = index / rate_hz - 0.05
    amplitude = 1.95e-6 * (1 + 0.95 * np.sin(2 * np.pi * 6 * t))

    def normal(k):
        return (0.65 + 0.03 * np.cos(2 * np.pi * 1.3 * t)) * (0.9 + 0.015 * k)

    def modelled(k, sigma_t_m, z_t, offset, area_m2, q0, eta, tau_s):
        limit = 0.375 * q0 * sigma_t_m * 20e6 / (1 - 0.5**2) * area_m2
        f_c, squeeze = normal(k), 1.25 * P0_PA * area_m2 * amplitude**2
        rest = sigma_t_m * np.log(limit / f_c)
        steady = equilibrium(rest, squeeze, f_c, sigma_t_m)
        share = 1 - np.exp(-1 / rate_hz / tau_s)
        gap = signal.lfilter([share], [1, share - 1], steady, zi=[(1 - share) * steady[0]])[0]
        k_c = limit * np.exp(-gap / sigma_t_m) / sigma_t_m + 2 * squeeze / gap**3
        z_c = k_c * (eta - 1j) / OMEGA
        return (z_p + 1j * offset + z_t * z_c / (z_t + z_c))[lead:]

    true = lambda k: (SIGMA_T_M * (1 + 0.01 * k), 0.47 + 3.16j * (1 + 0.01 * k), -0.02 * k)
    ripple = 0.001 * np.exp(1j * index[lead:])
    measured = [modelled(k, *true(k), 240e-6, 1.9e4, 0.36, 0.9e-3) + ripple for k in range(n)]

    def work():
        def residual(q):
            tau_s, area_m2, q0, eta = np.exp(q[:4]) * (1e-3, 300e-6, 1.4e4, 0.3)
            off = []
            for k in range(n):
                s, re, im, offset = q[4 + 4 * k : 8 + 4 * k]
                off.append(modelled(k, np.exp(s) * 1e-6, re + 1j * im, offset, area_m2, q0, eta, tau_s) - measured[k])
            off = np.concatenate(off)
            return np.r_[off.real, off.imag]

        own = np.tile([np.log(1.6), 0.5, 3.0, 0.0], n)
        starts = [np.r_[np.log(tau_ms), np.log(area), 0.0, 0.0, own] for area in (1.0, 0.5) for tau_ms in (0.7, 2.0)]
        found = (optimize.least_squares(residual, start, x_scale="jac", max_nfev=200) for start in starts)
        return np.exp(min(found, key=lambda fit: fit.cost).x[4::4]) * 1e-6

    return work, np.mean


def trial_all_laws():
    """The problem that this bench's fit solves: seven parameters of each of 14 instances and eleven of the trial, with its priors. From one
    of its four starts, without the weights that residuals get by their scatter, without its three refinements, and without its
    second fit, of the laws in doubt. The instances are followed side by side."""
    from scipy import optimize, signal

    z_p, rate_hz, lead, n = 7.01, 2000, 40, 14
    t, k = np.arange(160) / rate_hz - 0.05, np.arange(n)[:, None]
    amplitude = np.broadcast_to(1.95e-6 * (1 + 0.95 * np.sin(2 * np.pi * 6 * t)), (n, len(t)))
    normal = (0.65 + 0.03 * np.cos(2 * np.pi * 1.3 * t)) * (0.9 + 0.015 * k)
    force = normal / normal[:, lead:].mean()

    def followed(steady, tau_s, exponent):
        """The gap, whose lag grows with it."""
        gap = steady.copy()
        for i in range(1, len(t)):
            share = 1 - np.exp(-1 / rate_hz / (tau_s * (gap[:, i - 1] / 10e-6) ** exponent))
            gap[:, i] = gap[:, i - 1] + share * (steady[:, i] - gap[:, i - 1])
        return gap

    def answered(film_s):
        """The squared amplitude that the film answers to."""
        left = np.exp(-1 / rate_hz / film_s)
        return signal.lfilter([1 - left], [1, -left], amplitude**2, zi=left * amplitude[:, :1] ** 2)[0]

    def modelled(own, shared):
        ln_sigma, re, im, reactance, damping, angle, residual = own.T[:, :, None]
        area_m2, q0, eta, tau_s, film_s = np.exp(shared[:5])
        growth, exponent, tilt, bow, angle_of_all, residual_of_all = shared[5:]
        # All are at the plate's centre, where tilt and bow do nothing.
        sigma, area_m2 = np.exp(ln_sigma), area_m2 * force**growth
        limit = 0.375 * q0 * sigma * 20e6 / (1 - 0.5**2) * area_m2
        squeeze = 1.25 * P0_PA * area_m2 * answered(film_s)
        gap = followed(equilibrium(sigma * np.log(limit / normal), squeeze, normal, sigma), tau_s, exponent)
        k_c = limit * np.exp(-gap / sigma) / sigma + 2 * squeeze / gap**3
        z_c, z_t = k_c * (eta - 1j) / OMEGA, re + 1j * im
        alone = z_t * z_c / (z_t + z_c)
        seen = alone / (1 + 1j * (residual + residual_of_all) * alone) * np.exp(1j * (angle + angle_of_all))
        return (z_p + damping + 1j * reactance + seen)[:, lead:]

    own = np.zeros((n, 7))
    own[:, :4] = [(np.log(SIGMA_T_M * (1 + 0.01 * i)), 0.47, 3.16 * (1 + 0.01 * i), -0.02 * i) for i in range(n)]
    between = lambda low, high: (np.log(low * high) / 2, np.log(high / low) / 3.92)
    priors = [between(60e-6, 450e-6), between(5e3, 5e4), between(0.1, 0.6), between(1e-4, 1e-2), between(3e-5, 3e-4)]
    priors += [(0.3, 0.3), (0.25, 0.15), (0, 0.015), (-0.01, 0.02), (0, 0.02), (0, 0.003)]
    mean, std = np.array(priors).T
    true = np.r_[np.log([240e-6, 1.9e4, 0.36, 0.9e-3, 1e-5]), np.zeros(6)]
    measured = modelled(own, true) + 0.001 * np.exp(1j * np.arange(len(t))[lead:])
    of_own, of_noise = np.array([3, 1e-4, 0.02, 0.003]), 0.001 / np.sqrt(2)

    def residual(q):
        shared, own = q[:11], q[11:].reshape(n, 7)
        off = (modelled(own, shared) - measured).ravel() / of_noise
        return np.r_[off.real, off.imag, (shared - mean) / std, (own[:, 3:] / of_own).ravel()]

    def work():
        start = np.r_[mean, np.tile([np.log(1.6e-6), 0.5, 3.0, 0, 0, 0, 0], n)]
        start[0], start[3] = np.log(300e-6), np.log(0.7e-3)
        return np.exp(optimize.least_squares(residual, start, x_scale="jac", max_nfev=200).x[11::7])

    return work, np.mean


REQUIRED = [
    ("demodulate 60 s of 2 x 192 kHz to Z_m", "scipy hilbert", 20, None),
    ("demodulate 60 s of 2 x 192 kHz to Z_m", "numpy lock-in", 10, None),
    ("100 000 equilibrium gaps", "scipy brentq", 150, None),
    ("100 000 equilibrium gaps", "numpy newton", 1, None),
    ("paper fit of 60 points", "scipy least_squares", None, 1e-3),
    ("trial fit of 14 instances", "scipy least_squares", 20, 1.0),
    ("trial fit of 14 instances", "scipy least_squares, published laws alone", None, None),
]


def ratios(folder):
    measured = {}
    for path in pathlib.Path(folder).glob("*/*/new/benchmark.json"):
        named = json.loads(path.read_text())
        estimates = json.loads(path.with_name("estimates.json").read_text())
        measured[named["group_id"], named["function_id"]] = estimates["mean"]["point_estimate"] * 1e-9
    for work, rival, factor, most_s in REQUIRED:
        if not {(work, "this bench"), (work, rival)} <= measured.keys():
            print(f"{work}; {rival}: not measured")
            continue
        ours, theirs = measured[work, "this bench"], measured[work, rival]
        print(f"{work}: {duration(ours)}; {rival} {duration(theirs)}, {theirs / ours:.3g} times as long{verdict(ours, theirs, factor, most_s)}")


def verdict(ours, theirs, factor, most_s):
    required = []
    if factor is not None:
        required.append((f"{factor} times", theirs >= factor * ours))
    if most_s is not None:
        required.append((f"at most {duration(most_s)}", ours <= most_s))
    parts = [f"{words}: {'met' if met else 'MISSED'}" for words, met in required]
    return f" (required: {', '.join(parts)})" if parts else ""


def duration(seconds):
    return f"{seconds:.3g} s" if seconds >= 1 else f"{seconds * 1e3:.3g} ms"


def main():
    if sys.argv[1] == "ratios":
        return ratios(sys.argv[2])
    rivals = [hilbert, lock_in, brentq, newton, least_squares, trial_least_squares, trial_all_laws]
    work, number = {rival.__name__: rival for rival in rivals}[sys.argv[1]]()
    answer = work()
    begun = time.perf_counter()
    for _ in range(int(sys.argv[2])):
        work()
    print(time.perf_counter() - begun, number(answer))


if __name__ == "__main__":
    main()
