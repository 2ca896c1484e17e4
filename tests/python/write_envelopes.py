"""Writes the complex envelopes of a recording of the bench as a lock-in amplifier keeps them, with their import map.

Usage: write_envelopes.py RECORDING FOLDER ORDER:TAU_S:RATE_HZ...

Each folder is named by its argument. The filter is `order` equal RC low-passes; the values are RMS, under exp(-iωt)."""

import sys
from pathlib import Path

import numpy as np
import scipy.io
import scipy.signal

from write_formats import Files, Recording, write_maps


def envelopes(recording, order, tau_s, rate_hz):
    step = round(recording.rate_hz / rate_hz)
    assert recording.rate_hz == step * rate_hz, "a whole divisor of the rate"
    carrier = 2 * np.pi * recording.manifest["carrier_hz"]
    # The bilinear transform of 1 / (1 + s τ) at the converter's rate.
    numerator, denominator = scipy.signal.bilinear([1.0], [tau_s, 1.0], fs=recording.rate_hz)
    times = np.arange(len(recording.signals)) / recording.rate_hz
    oscillator = np.sqrt(2.0) * np.exp(1j * carrier * times)
    for channel in recording.signals.T:
        mixed = channel * oscillator
        for _ in range(order):
            mixed = scipy.signal.lfilter(numerator, denominator, mixed)
        yield mixed[::step]


def write(recording, folder, case):
    order, tau_s, rate_hz = case.split(":")
    order, tau_s, rate_hz = int(order), float(tau_s), float(rate_hz)
    folder.mkdir(parents=True)
    drive, pickup = envelopes(recording, order, tau_s, rate_hz)
    forces, position = recording.forces, recording.position
    variables = {"U": drive, "z": pickup, "sr": rate_hz, "t": forces[:, 0], "F": forces[:, 1:], "x": position[:, 1], "t_x": position[:, 0]}
    scipy.io.savemat(folder / "session.mat", variables)
    files = Files(r"session\.mat", None, None, None, "F[:,0]", "F[:,1]", "t", "x", "t_x")
    electrical = f"""[envelopes]
drive = "U"
pickup = "z"
rate_hz = "sr"
volts_per_unit = {recording.drive["volts_per_unit"]!r}
metres_per_unit = {recording.pickup["metres_per_unit"]!r}
phase_rad = {recording.pickup["phase_rad"]!r}
quantity = "displacement"
convention = "exp(-iwt)"
rms = true
low_pass = {{ order = {order}, tau_s = {tau_s!r} }}
"""
    write_maps(folder, recording, files, electrical)


if __name__ == "__main__":
    recording = Recording(Path(sys.argv[1]))
    for case in sys.argv[3:]:
        write(recording, Path(sys.argv[2]) / case, case)
