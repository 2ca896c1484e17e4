"""Writes a recording of the bench as files of other programs, each format in a folder with its import map.

Usage: write_formats.py RECORDING FOLDER FORMAT...

`marks.toml` of a folder states the recording's intervals, `rules.toml` has rules in their place."""

import sys
import tomllib
from pathlib import Path

import numpy as np

# Full scale of a converter of 24 bits.
CODES = 2**23


class Recording:
    def __init__(self, path):
        import soundfile

        self.manifest = tomllib.loads((path / "recording.toml").read_text())
        samples, self.rate_hz = soundfile.read(path / "signals.wav", dtype="float32", always_2d=True)
        channels = self.manifest["channels"]
        self.drive = channels["drive"]
        self.pickup = channels["pickup"]
        self.signals = samples[:, [self.drive["index"], self.pickup["index"]]].astype(np.float64)
        self.forces = np.loadtxt(path / "force.csv", delimiter=",", skiprows=1)
        self.position = np.loadtxt(path / "position.csv", delimiter=",", skiprows=1)

    def codes(self):
        """The converter's integers, of which the samples are fractions of the full scale."""
        codes = np.round(self.signals * CODES)
        assert np.array_equal(codes / CODES, self.signals), "samples of 24 bits"
        return codes.astype(np.int32)


class Files:
    """Array names and scales of a map."""

    def __init__(self, files, drive, pickup, rate, normal, lateral, force_time, position, position_time):
        self.files = files
        self.drive, self.pickup, self.rate = drive, pickup, rate
        self.normal, self.lateral, self.force_time = normal, lateral, force_time
        self.position, self.position_time = position, position_time
        self.unit = 1.0
        self.forces_file = self.position_file = None


RULES = 'unloaded = "normal < 0.05 N for 0.3 s"\nexploration = "40 to 60 mm/s for 0.5 s"'


def write_map(folder, recording, files):
    rate = files.rate if isinstance(files.rate, (int, float)) else f"'{files.rate}'"
    electrical = f"""[drive]
from = '{files.drive}'
rate_hz = {rate}
volts_per_unit = {recording.drive["volts_per_unit"] * files.unit!r}
[pickup]
from = '{files.pickup}'
quantity = "displacement"
metres_per_unit = {recording.pickup["metres_per_unit"] * files.unit!r}
phase_rad = {recording.pickup["phase_rad"]}
"""
    write_maps(folder, recording, files, electrical)


def write_maps(folder, recording, files, electrical):
    manifest, plate = recording.manifest, recording.manifest["plate"]
    forces_file = f"file = '{files.forces_file}'\n" if files.forces_file else ""
    position_file = f"file = '{files.position_file}'\n" if files.position_file else ""
    text = f"""format = 1
files = '{files.files}'
[carrier]
hz = {manifest["carrier_hz"]}
[modulation]
hz = {manifest["modulation_hz"]}
index = {manifest["modulation_index"]}
{electrical}[normal]
{forces_file}from = '{files.normal}'
time = '{files.force_time}'
newtons_per_unit = 1.0
clock = "same"
[lateral]
{forces_file}from = '{files.lateral}'
newtons_per_unit = 1.0
[position]
{position_file}from = '{files.position}'
time = '{files.position_time}'
metres_per_unit = 1.0
[plate]
modal_mass_kg = {plate["modal_mass_kg"]}
resonance_hz = {plate["resonance_hz"]}
force_factor_n_per_v = {plate["force_factor_n_per_v"]}
centre_m = {plate["centre_m"]}
[intervals]
"""
    (folder / "marks.toml").write_text(text + "marks = 'marks.csv'\n")
    (folder / "rules.toml").write_text(text + RULES + "\n")
    write_marks(folder, manifest)


def write_marks(folder, manifest):
    lines = ["kind,direction,start_s,end_s"]
    for interval in manifest["intervals"]:
        direction = interval.get("direction", "")
        lines.append(f"{interval['kind']},{direction},{interval['start_s']!r},{interval['end_s']!r}")
    (folder / "marks.csv").write_text("\n".join(lines) + "\n")


def matlab(compressed, kind=np.float64):
    def write(folder, recording):
        import scipy.io

        forces, position = recording.forces.astype(kind), recording.position.astype(kind)
        variables = {
            "out": recording.signals.astype(kind),
            "sr": float(recording.rate_hz),
            "S": {"t": forces[:, :1], "F": forces[:, 1:]},
            "enc": position[:, 1][np.newaxis, :],
            "t_enc": position[:, 0][np.newaxis, :],
        }
        scipy.io.savemat(folder / "session.mat", variables, do_compression=compressed)
        return Files(r"session\.mat", "out[:,0]", "out[:,1]", "sr", "S.F[:,0]", "S.F[:,1]", "S.t", "enc", "t_enc")

    return write


def matlab_73(folder, recording):
    import h5py

    path = folder / "session.mat"
    with h5py.File(path, "w", userblock_size=512) as file:

        def variable(group, name, values):
            # MATLAB stores an array in the order of its columns.
            array = np.ascontiguousarray(np.atleast_2d(values).T)
            chunks = tuple(min(size, 65_536) for size in array.shape) if array.size > 1 else None
            data = group.create_dataset(name, data=array, chunks=chunks, compression="gzip" if chunks else None)
            data.attrs["MATLAB_class"] = np.bytes_("double")

        variable(file, "out", recording.signals)
        variable(file, "sr", np.array([[float(recording.rate_hz)]]))
        structure = file.create_group("S")
        structure.attrs["MATLAB_class"] = np.bytes_("struct")
        variable(structure, "t", recording.forces[:, :1])
        variable(structure, "F", recording.forces[:, 1:])
        variable(file, "enc", recording.position[:, 1:])
        variable(file, "t_enc", recording.position[:, :1])
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(116) + bytes(8) + b"\x00\x02IM"
    with open(path, "r+b") as file:
        file.write(header)
    return Files(r"session\.mat", "out[:,0]", "out[:,1]", "sr", "S.F[:,0]", "S.F[:,1]", "S.t", "enc", "t_enc")


def tdms(folder, recording):
    from nptdms import ChannelObject, TdmsWriter

    step = {"wf_increment": 1.0 / recording.rate_hz, "wf_start_offset": 0.0}
    with TdmsWriter(folder / "session.tdms") as writer:
        for start in range(0, len(recording.signals), 100_000):
            block = recording.signals[start : start + 100_000]
            channels = [ChannelObject("fast", name, block[:, k], properties=step) for k, name in enumerate(["amplifier", "LDV"])]
            writer.write_segment(channels)
        slow = {"t": recording.forces[:, 0], "Fn": recording.forces[:, 1], "Ft": recording.forces[:, 2]}
        slow |= {"t_x": recording.position[:, 0], "x": recording.position[:, 1]}
        writer.write_segment([ChannelObject("slow", name, np.ascontiguousarray(values)) for name, values in slow.items()])
    return Files(r"session\.tdms", "fast/amplifier", "fast/LDV", "file", "slow/Fn", "slow/Ft", "slow/t", "slow/x", "slow/t_x")


def hdf5(folder, recording):
    import h5py

    with h5py.File(folder / "session.h5", "w") as file:
        options = {"chunks": (8192, 2), "compression": "gzip", "shuffle": True}
        signals = file.create_dataset("daq/signals", data=recording.signals.astype(np.float32), **options)
        signals.attrs["fs"] = float(recording.rate_hz)
        file.create_dataset("force/t", data=recording.forces[:, 0])
        file.create_dataset("force/F", data=recording.forces[:, 1:].astype(">f8"), chunks=(1000, 2), compression="gzip")
        file.create_dataset("place/t", data=recording.position[:, 0])
        file.create_dataset("place/x", data=recording.position[:, 1])
    return Files(
        r"session\.h5", "/daq/signals[:,0]", "/daq/signals[:,1]", "/daq/signals@fs", "/force/F[:,0]", "/force/F[:,1]", "/force/t", "/place/x", "/place/t"
    )


def npy(folder, recording):
    np.save(folder / "session.npy", np.asfortranarray(recording.signals))
    np.save(folder / "force.npy", recording.forces)
    np.save(folder / "place.npy", recording.position.astype(">f8"))
    files = Files(r"session\.npy", "[:,0]", "[:,1]", recording.rate_hz, "[:,1]", "[:,2]", "[:,0]", "[:,1]", "[:,0]")
    files.forces_file, files.position_file = "force.npy", "place.npy"
    return files


def npz(folder, recording):
    forces, position = recording.forces, recording.position
    np.savez_compressed(
        folder / "session.npz", codes=recording.codes(), fs=np.float64(recording.rate_hz), forces=forces, x=position[:, 1], t_x=position[:, 0]
    )
    files = Files(r"session\.npz", "codes[:,0]", "codes[:,1]", "fs", "forces[:,1]", "forces[:,2]", "forces[:,0]", "x", "t_x")
    files.unit = 1.0 / CODES
    return files


def tables(write, suffix):
    def write_all(folder, recording):
        import pandas

        write(pandas.DataFrame(recording.signals, columns=["U", "LDV"]), folder / f"session.{suffix}")
        write(pandas.DataFrame(recording.forces, columns=["t", "Fn", "Ft"]), folder / f"force.{suffix}")
        write(pandas.DataFrame(recording.position, columns=["t", "x"]), folder / f"place.{suffix}")
        files = Files(rf"session\.{suffix}", "U", "LDV", recording.rate_hz, "Fn", "Ft", "t", "x", "t")
        files.forces_file, files.position_file = f"force.{suffix}", f"place.{suffix}"
        return files

    return write_all


def sound(suffix, options):
    def write(folder, recording):
        import soundfile

        # The upper 24 bits of 32, or 16 bits.
        codes = {"PCM_24": lambda codes: codes << 8, "PCM_16": lambda codes: ((codes + 128) >> 8).clip(-32_768, 32_767).astype(np.int16)}
        convert = codes.get(options["subtype"])
        samples = convert(recording.codes()) if convert else recording.signals
        soundfile.write(folder / f"session.{suffix}", samples, recording.rate_hz, **options)
        files = Files(rf"session\.{suffix}", "[:,0]", "[:,1]", "file", "Fn", "Ft", "t", "x", "t")
        np.savetxt(folder / "force.csv", recording.forces, delimiter=",", header="t,Fn,Ft", comments="", fmt="%.17g")
        np.savetxt(folder / "place.csv", recording.position, delimiter=",", header="t,x", comments="", fmt="%.17g")
        files.forces_file, files.position_file = "force.csv", "place.csv"
        return files

    return write


FORMATS = {
    "v5": matlab(compressed=False),
    "v7": matlab(compressed=True),
    "v7.3": matlab_73,
    "TDMS": tdms,
    "HDF5": hdf5,
    "NPY": npy,
    "NPZ": npz,
    "CSV with points": tables(lambda table, path: table.to_csv(path, index=False), "csv"),
    "CSV with commas": tables(lambda table, path: table.to_csv(path, index=False, sep=";", decimal=","), "csv"),
    "Parquet": tables(lambda table, path: table.to_parquet(path, index=False), "parquet"),
    "FLAC": sound("flac", {"subtype": "PCM_24"}),
    "v7 of singles": matlab(compressed=True, kind=np.float32),
    "FLAC of 16 bits": sound("flac", {"subtype": "PCM_16"}),
    "RF64": sound("rf64", {"format": "RF64", "subtype": "DOUBLE"}),
}


def main(recording, folder, *formats):
    recording, folder = Recording(Path(recording)), Path(folder)
    for name in formats:
        place = folder / name
        place.mkdir(parents=True)
        write_map(place, recording, FORMATS[name](place, recording))


if __name__ == "__main__":
    main(*sys.argv[1:])
