"""Writes a long file of drive and pickup without gaps, and a map for it: write_dense.py FOLDER FORMAT BYTES."""

import sys
from pathlib import Path

import h5py
import numpy as np
import soundfile
from nptdms import ChannelObject, TdmsWriter

BLOCK = 1 << 20
HEADER_73 = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2024 HDF5 schema 1.00 ."


def block(rate_hz):
    """Returns whole periods of the modulation and of the carrier, so that blocks follow each other without a jump."""
    t = np.arange(BLOCK) / BLOCK
    periods = round(BLOCK / rate_hz * 6.0), round(BLOCK / rate_hz * 35e3)
    envelope = 1.0 + 0.95 * np.sin(2 * np.pi * periods[0] * t)
    drive = 0.25 * envelope * np.sin(2 * np.pi * periods[1] * t)
    pickup = 0.2 * envelope * np.sin(2 * np.pi * periods[1] * t - 1.5)
    return np.stack([drive, pickup], 1), periods[1] * rate_hz / BLOCK, periods[0] * rate_hz / BLOCK


def npy(path, values, count):
    shape = f"({count * BLOCK}, 2)"
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}"
    header += " " * ((-len(header) - 11) % 64) + "\n"
    with open(path, "wb") as file:
        file.write(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode())
        for _ in range(count):
            file.write(values.astype("<f8").tobytes())


def sound(kind, subtype):
    def write(path, values, count):
        with soundfile.SoundFile(path, "w", RATES_HZ.get(kind, RATE_HZ), 2, subtype, format=kind) as file:
            for _ in range(count):
                file.write(values)

    return write


def hdf5(path, values, count):
    with h5py.File(path, "w") as file:
        data = file.create_dataset("x", (count * BLOCK, 2), "f8", chunks=(8192, 2))
        for i in range(count):
            data[i * BLOCK : (i + 1) * BLOCK] = values


def matlab73(path, values, count):
    with h5py.File(path, "w", userblock_size=512) as file:
        data = file.create_dataset("x", (2, count * BLOCK), "f8", chunks=(2, 8192))
        data.attrs["MATLAB_class"] = np.bytes_("double")
        for i in range(count):
            data[:, i * BLOCK : (i + 1) * BLOCK] = values.T
    with open(path, "r+b") as file:
        file.write(HEADER_73.ljust(116) + b" " * 8 + (0x0200).to_bytes(2, "little") + b"IM")


def tdms(path, values, count):
    with TdmsWriter(path) as file:
        for _ in range(count):
            channels = [ChannelObject("g", name, values[:, i].copy()) for i, name in enumerate("ab")]
            file.write_segment(channels)


def csv(path, values, count):
    text = "".join("%.6f,%.6f\n" % (drive, pickup) for drive, pickup in values)
    with open(path, "w") as file:
        file.write("drive,pickup\n")
        for _ in range(count):
            file.write(text)


RATE_HZ = 400_000
RATES_HZ = {"FLAC": 192_000}
MATRIX, FILE = ('"x[:,0]"', '"x[:,1]"'), ('"[:,0]"', '"[:,1]"')
# Writer, end of the name, bytes of a row, sources of both channels.
FORMATS = {
    "NPY": (npy, "npy", 16, FILE),
    "RF64": (sound("RF64", "DOUBLE"), "rf64", 16, FILE),
    "WAV": (sound("WAV", "FLOAT"), "wav", 8, FILE),
    "FLAC": (sound("FLAC", "PCM_24"), "flac", 2.3, FILE),
    "HDF5": (hdf5, "h5", 16, MATRIX),
    "v7.3": (matlab73, "mat", 16, MATRIX),
    "TDMS": (tdms, "tdms", 16, ('"g/a"', '"g/b"')),
    "CSV": (csv, "csv", 18, ('"drive"', '"pickup"')),
}

folder, kind, size = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
write, extension, row_bytes, (drive, pickup) = FORMATS[kind]
rate_hz = RATES_HZ.get(kind, RATE_HZ)
values, carrier_hz, modulation_hz = block(rate_hz)
write(str(folder / f"dense.{extension}"), values, max(1, int(size / row_bytes / BLOCK)))
rate = '"file"' if write.__name__ == "write" else f"{rate_hz}.0"
(folder / "map.toml").write_text(f"""format = 1
files = 'dense\\.{extension}'
[carrier]
hz = {carrier_hz}
[modulation]
hz = {modulation_hz}
index = 0.95
[drive]
from = {drive}
rate_hz = {rate}
volts_per_unit = 20.0
[pickup]
from = {pickup}
quantity = "displacement"
metres_per_unit = 2.0e-6
[plate]
modal_mass_kg = 8.0e-3
resonance_hz = 35000.0
force_factor_n_per_v = 0.13
centre_m = 0.05
""")
print(extension)
