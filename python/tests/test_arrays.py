"""Arrays into the analysis: every form of them that is right, and a clear error for each that is wrong."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import friction_bench as fb

Arguments = dict[str, Any]
RATE_HZ = 96_000.0
CARRIER_HZ = 30_000.0


def tone(count: int = 9600) -> np.ndarray:
    """A carrier, exact in float32 and as 16-bit integers times 2**-10."""
    samples = 800 * np.cos(2 * np.pi * CARRIER_HZ * np.arange(count) / RATE_HZ)
    return np.round(samples) * 2.0**-10


def envelope(samples: Any) -> bytes:
    values, time_s = fb.envelopes(samples, RATE_HZ, carrier_hz=CARRIER_HZ)
    assert values.dtype == np.complex128 and time_s.dtype == np.float64 and values.shape == time_s.shape
    return values.tobytes() + time_s.tobytes()


def unaligned(samples: np.ndarray) -> np.ndarray:
    records = np.zeros(len(samples), np.dtype([("flag", "u1"), ("value", "f8")]))
    records["value"] = samples
    return records["value"]


def read_only(samples: np.ndarray) -> np.ndarray:
    copy = samples.copy()
    copy.flags.writeable = False
    return copy


FORMS: dict[str, Callable[[np.ndarray], Any]] = {
    "single": lambda x: x.astype("f4"),
    "half": lambda x: x.astype("f2"),
    "extended": lambda x: x.astype(np.longdouble),
    "big-endian": lambda x: x.astype(">f8"),
    "big-endian single": lambda x: x.astype(">f4"),
    "every other": lambda x: np.repeat(x, 2)[::2],
    "a column": lambda x: np.stack([x, -x], axis=1)[:, 0],
    "backwards": lambda x: x[::-1].copy()[::-1],
    "not aligned": unaligned,
    "read-only": read_only,
    "a list": lambda x: x.tolist(),
    "a series": lambda x: pd.Series(x, index=np.arange(len(x)) + 7),
    "a masked array without masked values": lambda x: np.ma.masked_invalid(x),
}


@pytest.mark.parametrize("form", FORMS)
def test_each_form_of_an_array_has_the_same_envelope(form: str) -> None:
    samples = tone()
    assert envelope(FORMS[form](samples)) == envelope(samples)


@pytest.mark.parametrize("dtype", ["i2", "i4", "i8", ">i2"])
def test_integers_are_their_numbers(dtype: str) -> None:
    assert envelope((tone() * 2**10).astype(dtype)) == envelope(tone() * 2**10)


def test_unsigned_integers_and_files_are_read(tmp_path: Path) -> None:
    samples = tone() * 2**10 + 1000
    assert envelope(samples.astype("u2")) == envelope(samples)
    samples.tofile(tmp_path / "samples")
    assert envelope(np.memmap(tmp_path / "samples", "f8", "r")) == envelope(samples)


@pytest.mark.parametrize("dtype", ["f4", "f8"])
def test_contiguous_floats_are_not_copied(dtype: str) -> None:
    samples = tone().astype(dtype)
    assert fb.as_samples(samples).ctypes.data == samples.ctypes.data
    assert fb.as_samples(samples[100:]).ctypes.data == samples[100:].ctypes.data
    assert fb.as_samples(samples[::2]).ctypes.data != samples.ctypes.data
    assert fb.as_samples(samples[::2]).dtype == samples.dtype


def test_a_lost_sample_is_lost_in_its_envelopes_alone() -> None:
    samples = tone()
    samples[4800] = np.nan
    values, time_s = fb.envelopes(samples, RATE_HZ, carrier_hz=CARRIER_HZ)
    lost = np.isnan(values)
    assert lost.any() and abs(time_s[lost].mean() - 0.05) < 1e-3
    assert np.abs(np.abs(values[~lost]) - 800 / 1024).max() < 1e-3


def test_the_impedance_is_that_of_its_definition() -> None:
    drive, pickup = tone(), 1e-3 * np.roll(tone(), 4)
    z_m, time_s = fb.impedance(drive, pickup, RATE_HZ, carrier_hz=CARRIER_HZ, drive_volts_per_unit=2.0)
    force, same_s = fb.envelopes(2.0 * drive, RATE_HZ, carrier_hz=CARRIER_HZ)
    motion, _ = fb.envelopes(pickup, RATE_HZ, carrier_hz=CARRIER_HZ)
    assert (time_s == same_s).all()
    expected = force / (2j * np.pi * CARRIER_HZ * motion)
    known = np.isfinite(z_m)
    assert known.any() and np.abs(z_m[known] / expected[known] - 1).max() < 1e-9


WRONG: dict[str, tuple[Any, str]] = {
    "complex": (tone().astype("c8"), "is complex"),
    "objects": (np.array([1, "a", None], object), "no real numbers"),
    "truth values": (tone() > 0, "True and False"),
    "texts": (np.array(["1", "2"]), "has texts"),
    "dates": (np.zeros(3, "M8[s]"), "dates or durations"),
    "rows": (tone().reshape(1, -1), "the shape (1, 9600)"),
    "a number": (1.0, "is one number"),
    "nothing": ([], "is empty"),
    "None": (None, "no real numbers"),
    "ragged": ([[1.0], [1.0, 2.0]], "is no array"),
    "masked": (np.ma.masked_less(tone(), 0), "is a masked array"),
    "infinite": (np.where(np.arange(50) < 7, 0.5, np.inf), "an infinite value at index 7"),
    "lost": (np.full(50, np.nan), "NaN alone"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_no_signal_is_refused_by_name(kind: str) -> None:
    value, words = WRONG[kind]
    with pytest.raises(fb.FrictionBenchError, match="`pickup` ?") as refused:
        fb.impedance(tone(), value, RATE_HZ, carrier_hz=CARRIER_HZ)
    assert words in str(refused.value)
    assert isinstance(refused.value, ValueError)


def description(**changes: Any) -> Arguments:
    arguments: Arguments = {
        "carrier_hz": CARRIER_HZ, "modulation_hz": 6.0, "modulation_index": 0.95,
        "plate": fb.Plate(resonance_hz=30e3, modal_mass_kg=8e-3, force_factor_n_per_v=0.13, centre_m=0.05),
        "intervals": [("unloaded", 0.0, 0.1)],
    }
    return arguments | changes


TIMES = np.arange(100) * 1e-3
ARGUMENTS: dict[str, tuple[Arguments, list[str]]] = {
    "unequal lengths": ({"normal": (TIMES, TIMES[1:])}, ["`normal` has 100 times and 99 values"]),
    "times that return": ({"normal": (np.roll(TIMES, 1), TIMES)}, ["the times of `normal` do not ascend", "at index 1"]),
    "repeated times": ({"position": (TIMES * 0, TIMES)}, ["the times of `position` do not ascend"]),
    "an unknown time": ({"lateral": (np.where(TIMES < 0.05, TIMES, np.nan), TIMES)}, ["the times of `lateral`: NaN at index 50"]),
    "an infinite force": ({"lateral": (TIMES, TIMES + np.inf)}, ["the values of `lateral`: an infinite value"]),
    "no pair": ({"normal": TIMES}, ["`normal` is no pair"]),
    "no modulation": ({"modulation_hz": None}, ["modulation_hz"]),
    "a modulation index above 1": ({"modulation_index": 1.5}, ["`modulation_index` is 1.5"]),
    "a slip in a name": ({"plate": {"resonance_Hz": 3e4}}, ["resonance_Hz", "did you mean `resonance_hz`"]),
    "a plate without mass": ({"plate": {"resonance_hz": 3e4}}, ["modal_mass_kg", "plate"]),
    "a negative mass": ({"plate": {**vars(description()["plate"]), "modal_mass_kg": -1}}, ["`plate.modal_mass_kg` is -1"]),
    "no scale": ({"drive_volts_per_unit": 0.0}, ["`drive_volts_per_unit` is 0"]),
    "an unknown interval": ({"intervals": [("rest", 0, 1)]}, ["rest", "unloaded"]),
    "no direction": ({"intervals": [("exploration", 0, 1)]}, ["needs a `direction`"]),
    "an interval that ends first": ({"intervals": [("unloaded", 1, 0)]}, ["intervals.0"]),
    "a carrier above half the rate": ({"carrier_hz": 60e3}, ["carrier_hz"]),
    "an unknown setting": ({"settings": {"contact_area": 1e-4}}, ["contact_area_m2"]),
    "a protocol that is none": ({"protocol": "format ="}, ["protocol"]),
    "an array as constant": ({"carrier_hz": {1, 2}}, ["carrier_hz"]),
    "a number as plate": ({"plate": 3}, ["plate", "write a dict"]),
    "a number as participant": ({"participant": {"id": 3, "session": 1}}, ["participant.id", "write a text"]),
    "a number as intervals": ({"intervals": [3]}, ["write a dict"]),
    "a number as list of intervals": ({"intervals": 3}, ["`intervals` is no list", "(\"unloaded\", 0.2, 1.0)"]),
    "a number as manifest": ({"manifest": 3}, ["`manifest` is of type int"]),
    "a number as scale of the pickup": ({"pickup_scale": 2e-6}, ["`pickup_scale` is of type float", "Pickup("]),
    "no plate": ({"plate": None}, ["`plate` is missing", "pass it"]),
    "half a trial": ({"manifest": {"trial": {"number": 1}}}, ["dict `trial`: key `attempt` is missing"]),
    "two slips": ({"plate": {"resonance_Hz": 3e4}, "room": {"pressure": 1e5}}, ["resonance_Hz", "`pressure`"]),
}


@pytest.mark.parametrize("kind", ARGUMENTS)
def test_an_argument_that_is_wrong_is_refused_by_name(kind: str) -> None:
    changes, words = ARGUMENTS[kind]
    with pytest.raises(fb.FrictionBenchError) as refused:
        fb.analyze(tone(), tone(), RATE_HZ, **description(**changes))
    for word in words:
        assert word in str(refused.value)
    if "protocol" not in changes:
        message = str(refused.value)
        assert "line" not in message, "the user wrote no text with lines"
        assert not any(word in message for word in ["struct", "in quotes", "in brackets", "table", "sequence", "f64", "[channels"]), message


def test_signals_of_other_lengths_and_rates_are_refused() -> None:
    with pytest.raises(fb.FrictionBenchError, match="`drive` has 9600 samples and `pickup` 9599"):
        fb.analyze(tone(), tone()[1:], RATE_HZ, **description())
    for rate_hz in [0.0, -1.0, np.nan, np.inf, 1e12]:
        with pytest.raises(fb.FrictionBenchError, match="`rate_hz` is"):
            fb.analyze(tone(), tone(), rate_hz, **description())
        with pytest.raises(fb.FrictionBenchError, match="`rate_hz` is"):
            fb.envelopes(tone(), rate_hz, carrier_hz=CARRIER_HZ)
    with pytest.raises(fb.FrictionBenchError, match="`rate_hz` is missing"):
        fb.analyze(tone(), tone(), **description())
    with pytest.raises(fb.FrictionBenchError, match="`carrier_hz` is of arrays"):
        fb.analyze("study", carrier_hz=3e4)
    with pytest.raises(fb.FrictionBenchError, match="50001"):
        fb.envelopes(tone(), RATE_HZ, carrier_hz=50_001)


def test_numbers_of_numpy_and_rates_that_are_not_whole_are_read() -> None:
    base = fb.analyze(tone(), tone(), RATE_HZ, **description()).to_json()
    numbers = {"carrier_hz": np.int32(30_000), "modulation_hz": np.float32(6.0), "drive_volts_per_unit": np.int64(1)}
    assert fb.analyze(tone(), tone(), np.float32(RATE_HZ), **description(**numbers)).to_json() == base
    time_s = fb.envelopes(tone(), 95_999.5, carrier_hz=CARRIER_HZ)[1]
    assert time_s[10] == round(time_s[10] * 95_999.5) / 95_999.5
    assert fb.analyze(tone(), tone(), 95_999.5, **description()).results["recordings"]
