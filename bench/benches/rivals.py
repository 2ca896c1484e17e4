"""What the benchmarks are set beside: the same work in numpy and scipy, as a laboratory would write it.

`rivals.py NAME N` does NAME N times, after once to warm up, and prints the seconds that took.
"""
import sys
import time

import numpy as np

RATE_HZ, CARRIER_HZ, SECONDS = 192_000, 35_000.0, 60
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

    def work():
        ratio = signal.hilbert(drive) / signal.hilbert(pickup)
        return (signal.sosfiltfilt(sos, ratio.real) + 1j * signal.sosfiltfilt(sos, ratio.imag))[:: RATE_HZ // 2000]

    return work


def lock_in():
    """numpy: mix with a prepared reference, mean over each half millisecond."""
    drive, pickup = signals()
    reference = np.exp(-2j * np.pi * CARRIER_HZ * np.arange(len(drive)) / RATE_HZ)

    def work():
        block = RATE_HZ // 2000
        mean = lambda x: (x * reference).reshape(-1, block).mean(axis=1)
        return mean(drive) / mean(pickup)

    return work


def gaps():
    a = np.linspace(0.05e-6, 3.9e-6, 100_000)
    f_c = np.full_like(a, 0.65)
    rest = SIGMA_T_M * np.log(P_C_PA * AREA_M2 / f_c)
    squeeze = 1.25 * P0_PA * AREA_M2 * a**2
    return rest, squeeze, f_c


def brentq():
    from scipy.optimize import brentq as solve

    rest, squeeze, f_c = gaps()

    def work():
        for x0, s, f in zip(rest, squeeze, f_c):
            balance = lambda x: f * (1 - np.exp((x0 - x) / SIGMA_T_M)) - s / x**2
            solve(balance, x0, x0 + 10 * SIGMA_T_M + np.sqrt(s / f) * 2, xtol=1e-18, rtol=1e-12)

    return work


def newton():
    """numpy: all gaps at once, Newton from the squeeze film's asymptote until the step is under 1e-12."""
    rest, squeeze, f_c = gaps()

    def work():
        x = np.maximum(rest, np.sqrt(squeeze / f_c)) + 0.5 * SIGMA_T_M
        for _ in range(50):
            e = np.exp((rest - x) / SIGMA_T_M)
            value = f_c * (1 - e) - squeeze / x**2
            slope = f_c * e / SIGMA_T_M + 2 * squeeze / x**3
            step = value / slope
            x = np.maximum(x - step, rest)
            if np.max(np.abs(step) / x) < 1e-12:
                return x
        return x

    return work


if __name__ == "__main__":
    work = {"hilbert": hilbert, "lock_in": lock_in, "brentq": brentq, "newton": newton}[sys.argv[1]]()
    work()
    begun = time.perf_counter()
    for _ in range(int(sys.argv[2])):
        work()
    print(time.perf_counter() - begun)
