"""Channels of TDMS files as npTDMS reads them, as JSON; or files that npTDMS writes, and their channels."""

import json
import logging
import sys

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsFile, TdmsWriter

logging.disable(logging.WARNING)


def numbers(values):
    if values.dtype.kind == "c":
        return [[float(z.real), float(z.imag)] for z in values]
    if values.dtype.kind == "M":
        return [float(t) for t in (values - np.datetime64("1904-01-01")) / np.timedelta64(1, "s")]
    if values.dtype == object or values.dtype.kind in "US":
        return None
    return [float(value) for value in values]


def channels(path):
    found = {}
    for group in (file := TdmsFile.read(path)).groups():
        for channel in group.channels():
            found[f"{group.name}/{channel.name}"] = numbers(np.asarray(channel[:]))
    return found


def write(folder):
    rng = np.random.default_rng(1)
    noise = rng.standard_normal(1000)
    kinds = ["int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64", "float32", "float64"]
    wave = {"wf_increment": 1e-5, "wf_start_offset": 0.5, "wf_start_time": np.datetime64("2026-01-02T03:04:05.5"), "unit_string": "N"}
    with TdmsWriter(f"{folder}/types.tdms") as file:
        file.write_segment([RootObject({"title": "all types"}), GroupObject("g", {"n": 3})])
        file.write_segment([ChannelObject("g", kind, (noise * 50).astype(kind), wave) for kind in kinds])
        file.write_segment([ChannelObject("g", "complex", (noise + 1j).astype("complex64"))])
        file.write_segment([ChannelObject("g", "complex128", noise - 2j)])
        file.write_segment([ChannelObject("g", "bool", noise > 0)])
        file.write_segment([ChannelObject("g", "times", np.datetime64("2026-01-02") + np.arange(5).astype("timedelta64[ms]"))])
        file.write_segment([ChannelObject("g", "texts", ["a", "bc", ""])])
    with TdmsWriter(f"{folder}/segments.tdms") as file:
        for n in range(30):
            channel = ChannelObject("g", "x", noise[n * 10 : n * 10 + 10 + n % 3])
            file.write_segment([channel] + ([ChannelObject("g", "y", np.arange(n))] if n % 4 == 1 else []))
    return [f"{folder}/{name}.tdms" for name in ("types", "segments")]


paths = write(sys.argv[2]) if sys.argv[1] == "write" else sys.argv[2:]
json.dump({path: channels(path) for path in paths}, sys.stdout)
