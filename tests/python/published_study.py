"""Recomputes the table of statistics and the points of Figs. 13 to 15 from the Parquet tables, with nothing of this project.

Arguments: folder of the tables, table as CSV, folder of the figures. Prints as JSON what was compared and how far apart it is.
"""

import itertools
import json
import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet
from scipy import stats

tables, table, figures = map(Path, sys.argv[1:4])

instances = pd.read_parquet(tables / "estimates.parquet")
samples = pd.read_parquet(tables / "samples.parquet")
metadata = pyarrow.parquet.read_schema(tables / "estimates.parquet").metadata
assumed = json.loads(metadata[b"settings"])
printed = pd.read_csv(table)

instances["z_t"] = instances.re_z_t_n_s_per_m + 1j * instances.im_z_t_n_s_per_m
instances["z_p"] = instances.re_z_p_n_s_per_m + 1j * instances.im_z_p_n_s_per_m
instances["rigid"] = instances.re_rigid_z_t_n_s_per_m + 1j * instances.im_rigid_z_t_n_s_per_m
samples["z_m"] = samples.re_z_m_n_s_per_m + 1j * samples.im_z_m_n_s_per_m
samples["z_m_own"] = samples.re_z_m_model_n_s_per_m + 1j * samples.im_z_m_model_n_s_per_m
samples["z_m_averaged"] = samples.re_z_m_averaged_n_s_per_m + 1j * samples.im_z_m_averaged_n_s_per_m

INSTANCE = ["recording", "instance", "method"]
EXPLORATION = ["recording", "exploration", "method"]
constants = ["z_p", "z_t", "rigid", "carrier_hz", "averaged_sigma_t_m", "mu0", "at_rest_up_to_amplitude_m",
             "contact_area_m2", "loss_factor"]
samples = samples.merge(instances[INSTANCE + constants], on=INSTANCE)
omega = 2 * np.pi * samples.carrier_hz


# ---- the model of Eqs. 7, 9, 14 to 19 and 21, as SCIENCE.md has it ----

SKIN = (assumed["contact_area_m2"], assumed["sigma_q0_rad_per_m"])


def asperity_limit_n(sigma_t_m, skin=SKIN):
    modulus = assumed["young_modulus_pa"] / (1 - assumed["poisson_ratio"] ** 2)
    area_m2, q0_rad_per_m = skin
    return 0.375 * q0_rad_per_m * sigma_t_m * modulus * area_m2


def squeeze_n(amplitude_m, gap_m, area_m2=assumed["contact_area_m2"]):
    return 1.25 * assumed["ambient_pressure_pa"] * area_m2 * (amplitude_m / gap_m) ** 2


def equilibrium_gap_m(sigma_t_m, amplitude_m, normal_n, skin=SKIN):
    """Bisects Eq. 17, of which the left side less the right rises with the gap."""
    rest_m = sigma_t_m * np.log(asperity_limit_n(sigma_t_m, skin) / normal_n)
    low, high = rest_m, rest_m + 1e-3
    for _ in range(200):
        middle = 0.5 * (low + high)
        surplus = normal_n * (1 - np.exp((rest_m - middle) / sigma_t_m)) - squeeze_n(amplitude_m, middle, skin[0])
        low, high = np.where(surplus < 0, middle, low), np.where(surplus < 0, high, middle)
    return 0.5 * (low + high)


def stiffness_n_per_m(sigma_t_m, gap_m, normal_n, skin=SKIN):
    asperity_n = asperity_limit_n(sigma_t_m, skin) * np.exp(-gap_m / sigma_t_m)
    return asperity_n / sigma_t_m + 2 * (normal_n - asperity_n) / gap_m


def contact_impedance(k_c, omega, loss_factor=assumed["loss_factor"]):
    return k_c / (1j * omega) + loss_factor * k_c / omega


# ---- quantities of each frame, again from Z_m, Z_p and Z_t ----

apart = {}
METHODS = ["paper", "dynamic", "trial"]
assert set(instances.method) == set(METHODS), "methods"
alone = instances[instances.method != "trial"]
for name in ["contact_area_m2", "loss_factor"]:
    assert np.allclose(alone[name], assumed[name], rtol=1e-12), name


def agree(what, ours, theirs):
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    assert ours.shape == theirs.shape, f"{what}: {ours.shape} and {theirs.shape}"
    assert (np.isfinite(ours) == np.isfinite(theirs)).all(), what
    known = np.isfinite(ours)
    scale = np.max(np.abs(ours[known]), initial=1e-300)
    apart[what] = float(np.max(np.abs(ours[known] - theirs[known]), initial=0) / scale)


finger = samples.z_m - samples.z_p
v_p = omega * samples.amplitude_m
skin = finger / samples.z_t
# `trial` measures the area and the loss factor that the other methods assume.
z_c = contact_impedance(samples.k_c_n_per_m, omega, samples.loss_factor)
for column, again in {
    "reaction_force_n": np.abs(finger) * v_p,
    "reaction_force_phase_rad": np.angle(finger),
    "contact_force_n": np.abs(z_c * (1 - skin)) * v_p,
    "skin_per_plate": np.abs(skin),
    "skin_per_plate_phase_rad": np.angle(skin),
    "plate_power_w": 0.5 * np.real(finger) * v_p**2,
    "skin_power_w": 0.5 * np.real(samples.z_t) * (np.abs(skin) * v_p) ** 2,
    "film_force_n": squeeze_n(samples.amplitude_m, samples.gap_m, samples.contact_area_m2),
}.items():
    agree(column, samples[column], again)

# Z_m⁰ is read where the amplitude at the pickup counts as rest, or over the lowest 5 ms; both methods at the same samples.
pickup_m = samples.amplitude_m / samples.amplitude_ratio
at_rest = samples[pickup_m <= samples.at_rest_up_to_amplitude_m * (1 + 1e-12)]
z_m0 = at_rest.groupby(INSTANCE).z_m.mean().rename("z_m0").reset_index()
rigid = instances.merge(z_m0, on=INSTANCE, how="left")
agree("re_rigid_z_t", rigid.rigid.to_numpy().real, (rigid.z_m0 - rigid.z_p).to_numpy().real)
agree("im_rigid_z_t", rigid.rigid.to_numpy().imag, (rigid.z_m0 - rigid.z_p).to_numpy().imag)
for _, of in samples[samples.method == "paper"].groupby(["recording", "instance"]):
    below = of.amplitude_m[of.amplitude_m < assumed["rest_amplitude_m"]]
    interval_s = (of.time_s.max() - of.time_s.min()) / (len(of) - 1)
    lowest = of.amplitude_m.sort_values().iloc[: max(round(5e-3 / interval_s), 1)]
    expected = below.max() if len(below) else lowest.max()
    assert of.at_rest_up_to_amplitude_m.iloc[0] == expected, "samples at rest"

# What `dynamic` takes for the amplitude under the finger is the ratio times that at the pickup, which `paper` takes.
of_paper, of_dynamic = (samples[samples.method == name].reset_index(drop=True) for name in ["paper", "dynamic"])
agree("amplitude_m", of_dynamic.amplitude_m, of_dynamic.amplitude_ratio * of_paper.amplitude_m)
assert (of_paper.amplitude_ratio == 1).all() and (of_dynamic.amplitude_ratio != 1).any(), "amplitude_ratio"

# The average of a participant, and what the published model says with it.
whose = instances.participant.where(instances.participant != "", instances.recording)
agree("averaged_sigma_t_m", instances.averaged_sigma_t_m,
      instances.sigma_t_m.groupby([whose, instances.method]).transform("mean"))
paper = samples[samples.method == "paper"]
omega_paper = omega[paper.index]
normal_n = paper.normal_n.groupby([paper.recording, paper.instance]).transform("mean")
sigma_m = paper.averaged_sigma_t_m
gap_m = equilibrium_gap_m(sigma_m, paper.amplitude_m, normal_n)
z_c0 = contact_impedance(normal_n / sigma_m, omega_paper)
z_t = paper.rigid * z_c0 / (z_c0 - paper.rigid)
z_c = contact_impedance(stiffness_n_per_m(sigma_m, gap_m, normal_n), omega_paper)
modelled = paper.z_p + z_t * z_c / (z_t + z_c)
agree("re_z_m_averaged", paper.re_z_m_averaged_n_s_per_m, modelled.to_numpy().real)
agree("im_z_m_averaged", paper.im_z_m_averaged_n_s_per_m, modelled.to_numpy().imag)
agree("gap_averaged", paper.gap_averaged_m, gap_m)
agree("mu_averaged", paper.mu_averaged,
      paper.mu0 * asperity_limit_n(sigma_m) * np.exp(-gap_m / sigma_m) / normal_n)


# ---- the table ----

samples["abs_z_m"] = np.abs(samples.z_m)
samples["re_z_m"] = samples.re_z_m_n_s_per_m
samples["abs_im_z_m"] = np.abs(samples.im_z_m_n_s_per_m)
rows = []


def row(name, over, value=np.nan, std=np.nan, n=0, p=np.nan):
    rows.append({"statistic": name, "method": method, "over": over, "value": value, "std": std, "n": n, "p": p})


def spread(name, over, values):
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    n = len(values)
    row(name, over, values.mean() if n else np.nan, values.std(ddof=1) if n > 1 else np.nan, n)


def correlation(name, over, x, y, coefficient=stats.spearmanr):
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    varies = len(x) >= 3 and np.ptp(x) > 0 and np.ptp(y) > 0
    found = coefficient(x, y) if varies else (np.nan, np.nan)
    p = found[1]
    if varies and coefficient is stats.spearmanr:
        p = exact(x, y) if len(x) <= 8 else max(p, 2 / math.factorial(len(x)))
    row(name, over, found[0], n=len(x), p=p)


def exact(x, y):
    """The two-sided p-value of Spearman's coefficient over all orders of the ranks."""
    x, y = (ranks - ranks.mean() for ranks in map(stats.rankdata, (x, y)))
    sums = np.array(list(itertools.permutations(y))) @ x
    return np.mean(np.abs(sums) >= abs(x @ y) - 1e-6)


def r_squared(measured, modelled):
    measured, modelled = np.asarray(measured), np.asarray(modelled)
    return 1 - np.sum(np.abs(measured - modelled) ** 2) / np.sum(np.abs(measured - measured.mean()) ** 2)


def within(values, x, y):
    """Spearman's coefficient within each trial."""
    for _, trial in values.groupby("recording", sort=False):
        known = trial[np.isfinite(trial[x]) & np.isfinite(trial[y])]
        yield stats.spearmanr(known[x], known[y])[0] if len(known) >= 3 else np.nan


def levels_of_mean(name, column, one):
    spread(name, "instances", one[column])
    spread(name, "trials", one.groupby("recording")[column].mean())
    known = one[one.participant != ""]
    spread(name, "participants", known.groupby("participant")[column].mean())


def medians(name, values):
    values = np.asarray([value for value in values if np.isfinite(value)])
    row(name, "trials, median", np.median(values), n=len(values))
    spread(name, "trials", values)


def ranges(one_samples, keys, column):
    return one_samples.groupby(keys, sort=False)[column].agg(lambda of: of.max() - of.min())


CHANGES = ["instances", "explorations", "trials", "participants"]


def changes(one_samples, column):
    """Maximum less minimum of instances and of explorations, and means of the latter over trials and participants."""
    of = ranges(one_samples, ["participant", "recording", "exploration"], column).rename("change").reset_index()
    known = of[of.participant != ""]
    return (ranges(one_samples, ["recording", "instance"], column), of.change,
            of.groupby("recording", sort=False).change.mean(), known.groupby("participant").change.mean())


for method in METHODS:
    one = instances[instances.method == method].copy()
    frames = samples[samples.method == method]

    known = one[one.participant != ""]
    means = known.groupby("participant").sigma_t_m.mean().sort_values(kind="stable")
    typical = means.index[(len(means) - 1) // 2]
    spread("sigma_t_typical_participant_m", "instances", known[known.participant == typical].sigma_t_m)
    levels_of_mean("sigma_t_m", "sigma_t_m", one)

    by_trial = frames.groupby("recording", sort=False)
    medians("r2_impedance", [r_squared(of.z_m, of.z_m_averaged) for _, of in by_trial])
    own = frames.groupby(["recording", "instance"], sort=False)
    r2 = pd.Series({key: r_squared(of.z_m, of.z_m_own) for key, of in own})
    medians("r2_impedance_own_fit", r2.groupby(level=0).mean())
    spread("spearman_abs_z_m_mu", "trials", list(within(frames, "abs_z_m", "measured_mu")))
    medians("spearman_k_c_mu", within(frames, "k_c_n_per_m", "measured_mu"))
    spread("spearman_mu_estimated_mu", "trials", list(within(frames, "mu", "measured_mu")))

    mu = changes(frames, "measured_mu")
    for name, column in {
        "spearman_delta_abs_z_m_delta_mu": "abs_z_m",
        "spearman_acoustic_force_delta_mu": "reaction_force_n",
        "spearman_film_force_delta_mu": "film_force_n",
        "spearman_delta_gap_delta_mu": "gap_m",
        "spearman_delta_re_z_m_delta_mu": "re_z_m",
        "spearman_delta_im_z_m_delta_mu": "abs_im_z_m",
        "pearson_delta_mu_estimated_delta_mu": "mu",
    }.items():
        coefficient = stats.pearsonr if name.startswith("pearson") else stats.spearmanr
        for over, x, y in zip(CHANGES, changes(frames, column), mu):
            correlation(name, over, x, y, coefficient)
    each = frames.groupby(["recording", "instance"], sort=False)
    of_instances = each[["re_z_m", "abs_im_z_m", "measured_mu"]].agg(lambda of: of.max() - of.min()).reset_index()
    spread("spearman_within_trials_delta_re_z_m_delta_mu", "trials", list(within(of_instances, "re_z_m", "measured_mu")))
    spread("spearman_within_trials_delta_im_z_m_delta_mu", "trials", list(within(of_instances, "abs_im_z_m", "measured_mu")))
    estimated = changes(frames, "mu")
    for over in ["instances", "trials", "participants"]:
        level = CHANGES.index(over)
        line = stats.linregress(mu[level], estimated[level]) if len(mu[level]) > 1 else None
        row("slope_delta_mu_estimated_delta_mu", over, line.slope if line else np.nan,
            line.stderr if line and len(mu[level]) > 2 else np.nan, len(mu[level]))

    for name, column in {"spearman_mu0_im_z_t": "im_z_t_n_s_per_m", "spearman_mu0_re_z_t": "re_z_t_n_s_per_m"}.items():
        trials = one.groupby("recording")[["mu0", column]].mean()
        people = known.groupby("participant")[["mu0", column]].mean()
        for over, values in {"trials": trials, "instances": one, "participants": people}.items():
            correlation(name, over, values.mu0, values[column])

    has_gap = np.isfinite(frames.mu)
    row("r2_mu", "samples", r_squared(frames.measured_mu[has_gap], frames.mu[has_gap]), n=len(frames))
    drifts, variations = [], []
    for _, trial in one.groupby("recording", sort=False):
        z_t = trial.z_t.to_numpy()
        parts = np.abs(z_t - z_t.mean()) / np.abs(z_t.mean())
        several = len(parts) > 1
        drifts.append(parts.max() if several else np.nan)
        variations.append(math.sqrt(np.sum(parts**2) / (len(parts) - 1)) if several else np.nan)
    spread("drift_z_t_within_trial", "trials", drifts)
    spread("variation_z_t_within_trial", "trials", variations)
    one["rigid_over_z_t"] = np.abs(one.rigid) / np.abs(one.z_t)
    levels_of_mean("rigid_z_t_over_z_t", "rigid_over_z_t", one)
    skin = (one.contact_area_m2, one.q0_rad_per_m)
    gap_m = equilibrium_gap_m(one.sigma_t_m, 5e-6, 1.0, skin)
    one["fall"] = 1 - stiffness_n_per_m(one.sigma_t_m, gap_m, 1.0, skin) * one.sigma_t_m
    levels_of_mean("k_c_fall_5um_1n", "fall", one)

KEY = ["statistic", "method", "over"]
again = pd.DataFrame(rows)
both = printed.merge(again, on=KEY, how="outer", suffixes=("", "_again"), indicator=True, validate="one_to_one")
missing = both[both._merge != "both"][KEY].to_dict("records")
assert not missing, f"rows of one side alone: {missing}"
for _, pair in both.iterrows():
    name = f"{pair.statistic} {pair.method} over {pair.over}"
    assert pair.n == pair.n_again, f"{name}: n = {pair.n} and {pair.n_again}"
    for number in ["value", "std", "p"]:
        ours, theirs = pair[number], pair[f"{number}_again"]
        assert math.isnan(ours) == math.isnan(theirs), f"{name}: {number} = {ours} and {theirs}"
        if not math.isnan(ours):
            apart[f"{name}, {number}"] = abs(ours - theirs) / max(abs(theirs), 1e-3 if number != "value" else 1e-9)


# ---- the points of the figures ----

def points(figure, panel, series):
    drawn = pd.read_csv(figures / f"{figure}.csv")
    drawn = drawn[(drawn.panel == panel) & (drawn.series == series)]
    return drawn[["x", "y"]].dropna().to_numpy()


def drawn_among(what, found, all_points):
    """Every point drawn is one of these, to a millionth of the axes' extent; there are some."""
    all_points = np.asarray(all_points, dtype=float)
    all_points = all_points[np.isfinite(all_points).all(axis=1)]
    extent = np.maximum(np.ptp(all_points, axis=0), 1e-12)
    assert len(found) > 0, f"{what}: nothing is drawn"
    nearest = [np.min(np.max(np.abs(all_points - point) / extent, axis=1)) for point in found]
    apart[what] = float(max(nearest))


# Of the typical trial the exploration with the most instances.
sigma = instances[instances.method == "dynamic"].groupby("recording", sort=False).sigma_t_m.mean()
typical = sigma.sort_values(kind="stable").index[(len(sigma) - 1) // 2]
counts = instances[instances.recording == typical].groupby("exploration").instance.nunique()
exploration = counts.idxmax()
for method in METHODS:
    shown = samples[(samples.recording == typical) & (samples.exploration == exploration) & (samples.method == method)]
    quantities = [shown.re_z_m, -shown.im_z_m_n_s_per_m, shown.k_c_n_per_m * 1e-6, shown.gap_m * 1e6, shown.mu]
    models = [shown.re_z_m_averaged_n_s_per_m, -shown.im_z_m_averaged_n_s_per_m, shown.k_c_averaged_n_per_m * 1e-6,
              shown.gap_averaged_m * 1e6, shown.mu_averaged]
    # Fig. 13 has room for two: `trial` stands in the place of `dynamic`.
    in_fig13 = enumerate(zip(quantities, models)) if method != "dynamic" else []
    for at, (quantity, model) in in_fig13:
        for side, x, model_x in [(0, shown.amplitude_m * 1e6, shown.amplitude_m * 1e6), (1, shown.measured_mu, shown.mu_averaged)]:
            panel = "abcdefghij"[2 * at + side]
            drawn_among(f"fig13 {panel} {method}", points("fig13_instances", panel, method), np.column_stack([x, quantity]))
            if (at, side) != (4, 1):
                drawn_among(f"fig13 {panel} {method} model", points("fig13_instances", panel, f"{method}, model"),
                            np.column_stack([model_x, model]))

    frames = samples[samples.method == method]
    keys = ["recording", "instance"]
    measured = ranges(frames, keys, "measured_mu")
    for panel, column, factor in [("a", "abs_z_m", 1), ("b", "gap_m", 1e6), ("c", "mu", 1)]:
        change = ranges(frames, keys, column)
        found = points("fig14_variation", panel, method)
        assert len(found) == len(measured), f"fig14 {panel}: {len(found)} points of {len(measured)}"
        drawn_among(f"fig14 {panel} {method}", found, np.column_stack([measured, change * factor]))

    if method == "paper":
        shown = shown[["amplitude_m", "measured_mu"]]
        drawn_among("fig13 i measured", points("fig13_instances", "i", "measured"),
                    np.column_stack([shown.amplitude_m * 1e6, shown.measured_mu]))
        resting = at_rest[(at_rest.method == "paper") & np.isfinite(at_rest.mu)]
        means = resting.groupby(["recording", "instance"])[["measured_mu", "mu"]].mean()
        found = points("fig15_agreement", "a", "Zₜ read here")
        assert len(found) == len(means), f"fig15: {len(found)} initialisations of {len(means)}"
        drawn_among("fig15 initialisation", found, means)

    panel = {"paper": "a", "dynamic": "b", "trial": "c"}[method]
    drawn_among(f"fig15 {method}", points("fig15_agreement", panel, method), np.column_stack([frames.measured_mu, frames.mu]))

worst = max(apart, key=apart.get)
people = sorted(set(instances.participant))
print(json.dumps({"compared": len(apart), "rows": len(both), "worst": worst, "apart": apart[worst], "people": people}))
