"""Reads one trial's recording with nothing of this project, and prints what it found as JSON."""

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import scipy
from scipy.io import wavfile

folder = Path(sys.argv[1])
drive, pickup = int(sys.argv[2]), int(sys.argv[3])

rate_hz, samples = wavfile.read(folder / "signals.wav")
force = pd.read_csv(folder / "force.csv")
position = pd.read_csv(folder / "position.csv")


def spectrum(channel):
    """Hann amplitude spectrum of the second second, whose bins are 1 Hz."""
    second = samples[rate_hz // 2 : rate_hz // 2 + rate_hz, channel].astype(float)
    return np.abs(np.fft.rfft(second * scipy.signal.windows.hann(rate_hz, sym=False))) * 4 / rate_hz


def lines(channel):
    """The strongest line, and the sidebands 6 Hz beside it relative to it."""
    amplitude = spectrum(channel)
    strongest = int(np.argmax(amplitude))
    return {
        "strongest_hz": strongest,
        "amplitude": float(amplitude[strongest]),
        "lower": float(amplitude[strongest - 6] / amplitude[strongest]),
        "upper": float(amplitude[strongest + 6] / amplitude[strongest]),
    }


def table(frame):
    """Columns, types, and the run of a table's time."""
    return {
        "columns": list(frame.columns),
        "numeric": all(kind.kind == "f" for kind in frame.dtypes),
        "missing": int(frame.isna().to_numpy().sum()),
        "rows": len(frame),
        "rate_hz": float((len(frame) - 1) / (frame.time_s.iloc[-1] - frame.time_s.iloc[0])),
        "rising": bool((frame.time_s.diff().dropna() > 0).all()),
    }


json.dump(
    {
        "rate_hz": rate_hz,
        "type": str(samples.dtype),
        "frames": samples.shape[0],
        "channels": samples.shape[1],
        "nan": int(np.isnan(samples).sum()),
        "greatest": float(np.abs(samples).max()),
        "drive": lines(drive),
        "pickup": lines(pickup),
        "force": table(force),
        "position": table(position),
        "greatest_normal_n": float(force.normal_n.max()),
        "median_touching_n": float(force.normal_n[force.normal_n > 0.3].median()),
        "position_from_m": float(position.position_m.min()),
        "position_to_m": float(position.position_m.max()),
    },
    sys.stdout,
)
