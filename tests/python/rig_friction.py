"""Writes the friction rig's file with a stimulus and an import map into a folder; prints the friction by numpy alone, as JSON.

Usage: rig_friction.py RIG FOLDER

The friction of `plain.txt` is that of the rig; in `stimulated.txt` a square of 5 Hz lowers it by 30 %, 20 ms late."""

import json
import sys
from pathlib import Path

import numpy as np

LAG_S = 0.02
MAP = """format = 1
files = '{name}\\.txt'
[drive]
from = "4"
time = "0"
volts_per_unit = 1.0
[normal]
from = "1"
time = "0"
newtons_per_unit = 1e-6
clock = "same"
[lateral]
from = "3"
newtons_per_unit = 1e-6
[position]
from = "2"
metres_per_unit = 1e-3
[contact]
body = "other"
[intervals]
marks = "marks.csv"
"""


def stimulus(times_s):
    return np.where(np.mod(5.0 * times_s, 1.0) < 0.5, 0.0, 120.0)


def about_trend(time_s, values):
    return values - np.polyval(np.polyfit(time_s, values, 1), time_s)


def contrast(time_s, mu, stimulus):
    """Share by which the friction at the greatest stimulus is below that at the least: of the plane of the friction over time and
    stimulus, delayed by the best lag of the first ones, of at most 0.2 s and half the stroke, that explain nearly as much as the best."""
    step_s = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
    lags = range(min(int(0.2 / step_s), len(mu) // 2) + 1)
    pairs = [(time_s[lag:], stimulus[: len(mu) - lag], mu[lag:]) for lag in lags]
    shares = np.array([np.corrcoef(about_trend(t, s), about_trend(t, m))[0, 1] ** 2 for t, s, m in pairs])
    is_good = np.append(shares >= 0.8 * np.max(shares), False)
    first = int(np.argmax(is_good))
    t, s, m = pairs[first + int(np.argmax(shares[first : first + int(np.argmin(is_good[first:]))]))]
    terms = np.column_stack([np.ones_like(t), s, t - t.mean()])
    offset, slope, _ = np.linalg.lstsq(terms, m, rcond=None)[0]
    return 1.0 - (offset + slope * stimulus.max()) / (offset + slope * stimulus.min())


def main(rig, folder):
    header = Path(rig).read_text().splitlines()[0] + "\tStimulus [V]"
    time_s, normal_un, position_mm, lateral_un = np.loadtxt(rig, delimiter="\t", skiprows=1).T
    # The rig reverses every 2 s.
    strokes = [(8.55 + 2.0 * k, 10.0 + 2.0 * k) for k in range(20)]
    lines = ["kind,direction,start_s,end_s"]
    for index, (start_s, end_s) in enumerate(strokes):
        lines.append(f"exploration,{['left_to_right', 'right_to_left'][index % 2]},{start_s},{end_s}")
    (folder / "marks.csv").write_text("\n".join(lines) + "\n")
    answers = {}
    for name, lowered in [("plain", 0.0), ("stimulated", 0.3)]:
        lateral = lateral_un * (1.0 - lowered * stimulus(time_s - LAG_S) / 120.0)
        columns = np.column_stack([time_s, normal_un, position_mm, lateral, stimulus(time_s)])
        np.savetxt(folder / f"{name}.txt", columns, delimiter="\t", header=header, comments="", fmt="%.15g")
        (folder / f"{name}.toml").write_text(MAP.format(name=name))
        answers[name] = []
        for start_s, end_s in strokes:
            inside = (time_s >= start_s) & (time_s <= end_s)
            mu = np.abs(lateral[inside]) / normal_un[inside]
            answer = {"mu": mu.tolist(), "mean": mu.mean(), "contrast": contrast(time_s[inside], mu, stimulus(time_s[inside]))}
            answers[name].append(answer)
    json.dump(answers, sys.stdout)


main(sys.argv[1], Path(sys.argv[2]))
