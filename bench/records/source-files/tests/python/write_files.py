"""Writes files of other programs into a folder, and their values by NumPy: a line of cases.txt for each array."""

import decimal
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import scipy.io
import soundfile

folder = Path(sys.argv[1])
cases = []
random = np.random.default_rng(35_000)


def case(file, name, values, scalar=False):
    values = np.asarray(values)
    is_complex = np.iscomplexobj(values)
    path = f"{len(cases)}.values"
    values.astype(np.complex128 if is_complex else np.float64).ravel(order="F").tofile(folder / path)
    kind = "scalar" if scalar else "complex" if is_complex else "real"
    cases.append(f"{file}\t{name}\t{kind}\t{path}")


n = 3001
drive, pickup = random.normal(size=n), random.normal(size=n)
forces = random.normal(size=(n, 3))
counts = np.cumsum(random.integers(-3, 4, n)).astype(np.int32)
lockin = random.normal(size=n) + 1j * random.normal(size=n)

# MATLAB
variables = {
    "out": np.column_stack([drive, pickup]),
    "row": drive[np.newaxis, :],
    "sr": np.float64(300_000.0),
    "text": "1250.5",
    "enc": counts[:, np.newaxis],
    "z": lockin[:, np.newaxis],
    "low": forces.astype(np.float32),
    "flag": (drive > 0)[:, np.newaxis],
    "cube": random.normal(size=(4, 5, 6)),
    "empty": np.zeros((0, 0)),
    "bytes": np.arange(200, dtype=np.uint8)[np.newaxis, :],
    "big": np.array([[2**40, -(2**41)]], dtype=np.int64),
}
structure = {"F": forces, "inner": {"fs": 1000.0, "x": counts[:, np.newaxis]}}
cells = np.empty((1, 3), dtype=object)
cells[0, 0], cells[0, 1], cells[0, 2] = pickup[:, np.newaxis], "words", forces
trials = np.zeros((1, 2), dtype=[("f", object)])
trials["f"][0, 0], trials["f"][0, 1] = drive[:7, np.newaxis], pickup[:9, np.newaxis]
for file, compressed in [("v5.mat", False), ("v7.mat", True)]:
    scipy.io.savemat(folder / file, variables | {"S": structure, "C": cells, "T": trials}, do_compression=compressed)
    case(file, "out[:,0]", drive)
    case(file, "out[:,1]", pickup)
    case(file, "/out[:, 1]", pickup)
    case(file, "out[7,:]", [drive[7], pickup[7]])
    case(file, "row", drive)
    case(file, "row[:,0]", drive)
    case(file, "row[0,:]", drive)
    case(file, "sr", 300_000.0, scalar=True)
    case(file, "text", 1250.5, scalar=True)
    case(file, "enc", counts)
    case(file, "z", lockin)
    case(file, "low[:,2]", forces[:, 2].astype(np.float32))
    case(file, "flag", drive > 0)
    case(file, "cube[2,:,5]", variables["cube"][2, :, 5])
    case(file, "cube[:,4,0]", variables["cube"][:, 4, 0])
    case(file, "cube[3,4,:]", variables["cube"][3, 4, :])
    case(file, "cube[3,4,5]", variables["cube"][3, 4, 5], scalar=True)
    case(file, "bytes", variables["bytes"])
    case(file, "big", variables["big"])
    case(file, "S.F[:,1]", forces[:, 1])
    case(file, "S.inner.x", counts)
    case(file, "S.inner.fs", 1000.0, scalar=True)
    case(file, "C[0]", pickup)
    case(file, "C[2][:,0]", forces[:, 0])
    case(file, "T[0].f", drive[:7])
    case(file, "T[1].f", pickup[:9])
scipy.io.savemat(
    folder / "v4.mat",
    {"out": variables["out"], "sr": 300_000.0, "z": lockin[:, np.newaxis], "enc": counts[:, np.newaxis], "text": "1250.5"},
    format="4",
)
case("v4.mat", "out[:,1]", pickup)
case("v4.mat", "z", lockin)
case("v4.mat", "enc", counts)
case("v4.mat", "sr", 300_000.0, scalar=True)
case("v4.mat", "text", 1250.5, scalar=True)

# NumPy
for name, array in [
    ("f8", drive),
    ("big", drive.astype(">f8")),
    ("f4", drive.astype("<f4")),
    ("f2", drive.astype("<f2")),
    ("i2", counts.astype(">i2")),
    ("u1", counts.astype(np.uint8)),
    ("u4", counts.astype(np.uint32)),
    ("i8", counts.astype(np.int64)),
    ("bool", drive > 0),
    ("c16", lockin),
    ("c8", lockin.astype(">c8")),
]:
    np.save(folder / f"{name}.npy", array)
    case(f"{name}.npy", "[:]", array)
    case(f"{name}.npy", "[:,0]", array)
np.save(folder / "rows.npy", forces)
np.save(folder / "columns.npy", np.asfortranarray(forces))
np.save(folder / "time.npy", np.array(["2026-01-02T03:04:05.250", "NaT"], dtype="datetime64[ms]"))
case("time.npy", "[:]", [1767323045.25, np.nan])
for file in ["rows.npy", "columns.npy"]:
    for column in range(3):
        case(file, f"[:,{column}]", forces[:, column])
        case(file, str(column), forces[:, column])
    case(file, "[17,:]", forces[17])
records = np.zeros(n, dtype=[("t", "<f8"), ("F", ">f4", (3,)), ("n", "<i2")])
records["t"], records["F"], records["n"] = drive, forces, counts
np.save(folder / "records.npy", records)
case("records.npy", "t", drive)
case("records.npy", "F[:,2]", forces[:, 2].astype(np.float32))
case("records.npy", "n", counts)
arrays = {"out": variables["out"], "z": lockin, "fs": np.float64(10_000.0), "rate": np.array("250.5"), "rec": records}
np.savez(folder / "stored.npz", **arrays)
np.savez_compressed(folder / "deflated.npz", **arrays)
for file in ["stored.npz", "deflated.npz"]:
    case(file, "out[:,0]", drive)
    case(file, "out[:,1]", pickup)
    case(file, "z", lockin)
    case(file, "fs", 10_000.0, scalar=True)
    case(file, "rate", 250.5, scalar=True)
    case(file, "rec.F[:,1]", forces[:, 1].astype(np.float32))

# Sound
sound = np.clip(variables["out"] / 5.0, -0.99, 0.99)
for file, format, subtype in [
    ("u8.wav", "WAV", "PCM_U8"),
    ("i16.wav", "WAV", "PCM_16"),
    ("i24.wav", "WAV", "PCM_24"),
    ("i32.wav", "WAV", "PCM_32"),
    ("f32.wav", "WAV", "FLOAT"),
    ("f64.wav", "WAV", "DOUBLE"),
    ("extensible.wav", "WAVEX", "PCM_24"),
    ("i24.rf64", "RF64", "PCM_24"),
    ("f64.rf64", "RF64", "DOUBLE"),
    ("i16.w64", "W64", "PCM_16"),
    ("f64.w64", "W64", "DOUBLE"),
    ("i16.flac", "FLAC", "PCM_16"),
    ("i24.flac", "FLAC", "PCM_24"),
    ("i8.flac", "FLAC", "PCM_S8"),
]:
    soundfile.write(folder / file, sound, 192_000, format=format, subtype=subtype)
    read, _ = soundfile.read(folder / file, always_2d=True)
    case(file, "[:,0]", read[:, 0])
    case(file, "[:,1]", read[:, 1])
    case(file, "1", read[:, 1])
long = np.clip(random.normal(size=(600_000, 1)) / 6.0, -0.99, 0.99)
soundfile.write(folder / "long.flac", long, 96_000, subtype="PCM_24")
case("long.flac", "[:,0]", soundfile.read(folder / "long.flac")[0])

# Tables
time = np.arange(n) / 1000.0
frame = pd.DataFrame({"time (s)": time, "Fn [N]": forces[:, 0], "count": counts, "who": ["a"] * n})
frame.to_csv(folder / "english.csv", index=False)
frame.to_csv(folder / "german.csv", index=False, sep=";", decimal=",", encoding="utf-8-sig", lineterminator="\r\n")
frame.to_csv(folder / "tabs.tsv", index=False, sep="\t", lineterminator="\r")
for file in ["english.csv", "german.csv", "tabs.tsv"]:
    case(file, "time (s)", time)
    case(file, "time", time)
    case(file, "Fn [N]", forces[:, 0])
    case(file, "Fn", forces[:, 0])
    case(file, "1", forces[:, 0])
    case(file, "[:,2]", counts)
np.savetxt(folder / "blanks.txt", forces, header="x y z")
case("blanks.txt", "y", forces[:, 1])
np.savetxt(folder / "commas.txt", forces, delimiter=",")
case("commas.txt", "2", forces[:, 2])
frame["count"] = frame["count"].astype("Int32")
frame.loc[3, "count"] = pd.NA
frame["when"] = pd.to_datetime(1_700_000_000 + np.arange(n), unit="s")
frame["small"] = counts.astype(np.uint8)
frame["flag"] = drive > 0
frame["f4"] = drive.astype(np.float32)
for file, compression, groups in [("snappy.parquet", "snappy", 1000), ("gzip.parquet", "gzip", n), ("plain.parquet", None, n)]:
    frame.to_parquet(folder / file, index=False, compression=compression, row_group_size=groups)
    case(file, "time (s)", time)
    case(file, "count", frame["count"].astype(float))
    case(file, "when", 1_700_000_000.0 + np.arange(n))
    case(file, "small", counts.astype(np.uint8))
    case(file, "flag", drive > 0)
    case(file, "f4", drive.astype(np.float32))
    case(file, "1", forces[:, 0])
exact = pd.DataFrame({
    "F": [decimal.Decimal(int(c)).scaleb(-3) for c in counts],
    "since": pd.to_timedelta(np.arange(n), unit="ms"),
})
exact.to_parquet(folder / "exact.parquet", index=False)
case("exact.parquet", "F", counts / 1000.0)
case("exact.parquet", "since", np.arange(n) / 1000.0)
for codec in ["zstd", "brotli", "lz4"]:
    exact.to_parquet(folder / f"{codec}.parquet", index=False, compression=codec)

(folder / "cases.txt").write_text("\n".join(cases))
