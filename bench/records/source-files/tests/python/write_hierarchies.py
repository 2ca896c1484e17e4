"""Writes HDF5, MATLAB v7.3 and TDMS files into a folder, and their values by NumPy: a line of cases.txt for each array."""

import sys
from pathlib import Path

import h5py
import numpy as np
from nptdms import ChannelObject, RootObject, TdmsWriter

folder = Path(sys.argv[1])
cases = []
random = np.random.default_rng(73)


def case(file, name, values, scalar=False):
    values = np.asarray(values)
    is_complex = np.iscomplexobj(values)
    path = f"{len(cases)}.values"
    values.astype(np.complex128 if is_complex else np.float64).ravel(order="F").tofile(folder / path)
    kind = "scalar" if scalar else "complex" if is_complex else "real"
    cases.append(f"{file}\t{name}\t{kind}\t{path}")


n = 5001
x = random.normal(size=n)
wide = random.normal(size=(n, 3))
cube = random.normal(size=(40, 5, 6))
counts = random.integers(-100, 100, n)

# HDF5, in the layouts of its old and its new versions.
for libver in ["earliest", "latest"]:
    name = f"{libver}.h5"
    with h5py.File(folder / name, "w", libver=libver) as f:
        f.attrs["fs"] = 48_000
        f.attrs["operator"] = "A. B."
        g = f.create_group("a/b")
        g.attrs["rate"] = np.array([1250.5])
        stored = {
            "plain": (x, {}),
            "wide": (wide, {}),
            "cube": (cube, {}),
            "gzip": (x, {"compression": "gzip", "shuffle": True, "chunks": (700,)}),
            "lzf": (x.round(1), {"compression": "lzf", "chunks": (999,)}),
            "sums": (x, {"fletcher32": True, "chunks": (1000,)}),
            "tiles": (wide, {"compression": "gzip", "chunks": (333, 2)}),
            "growing": (wide, {"maxshape": (None, 3), "chunks": (100, 3)}),
            "growing_both": (wide, {"maxshape": (None, None), "chunks": (100, 2)}),
            "one_chunk": (x, {"chunks": (n,)}),
            "cubes": (cube, {"chunks": (7, 5, 2), "compression": "gzip"}),
            "big": (x.astype(">f8"), {}),
            "big_short": (counts.astype(">i2"), {"chunks": (64,)}),
            "half": (x.astype("f2"), {}),
            "single": (x.astype("f4"), {"compression": "gzip", "shuffle": True}),
            "flags": (x > 0, {}),
            "scaled": (counts.astype("i4"), {"scaleoffset": 0, "chunks": (512,)}),
            "row": (x[np.newaxis, :], {}),
            "column": (x[:, np.newaxis], {"chunks": (100, 1)}),
        }
        for key, (values, options) in stored.items():
            g.create_dataset(key, data=values, **options)
            path = f"a/b/{key}"
            values = np.asarray(values, dtype="f8")
            if values.ndim == 1 or 1 in values.shape:
                case(name, path, values)
            elif values.ndim == 2:
                for column in range(3):
                    case(name, f"/{path}[:,{column}]", values[:, column])
                case(name, f"{path}[17,:]", values[17])
            else:
                case(name, f"{path}[:,3,1]", values[:, 3, 1])
                case(name, f"{path}[39,:,5]", values[39, :, 5])
                case(name, f"{path}[2,4,:]", values[2, 4])
        for kind in ["i1", "u1", "u2", "<i4", ">u4", "<i8", ">u8"]:
            values = np.abs(counts).astype(kind)
            g.create_dataset(f"kind_{kind[-2:]}", data=values)
            case(name, f"a/b/kind_{kind[-2:]}", values)
        g["plain"].attrs["fs"] = np.float32(300.5)
        g["plain"].attrs["units"] = "V"
        g["plain"].attrs["gain"] = "20.5"
        for attribute, value in [("/@fs", 48_000), ("/a/b@rate", 1250.5), ("/a/b/plain@fs", 300.5), ("a/b/plain@gain", 20.5)]:
            case(name, attribute, value, scalar=True)
        f["scalar"] = 3.25
        f["one"] = np.array([[7]])
        f["text_number"] = " 96000.5 "
        f["list"] = np.array([3.0, 4.0, 5.0])
        for scalar, value in [("scalar", 3.25), ("one", 7), ("/text_number", 96_000.5), ("list[1]", 4.0), ("a/b/wide[5,2]", wide[5, 2])]:
            case(name, scalar, value, scalar=True)
        for kind in ["c8", "c16", ">c16"]:
            z = (x + 1j * x[::-1]).astype(kind)
            f[f"z{kind[1:].strip('c')}{'b' if kind[0] == '>' else ''}"] = z
        case(name, "z8", (x + 1j * x[::-1]).astype("c8"))
        case(name, "z16", x + 1j * x[::-1])
        case(name, "z16b", x + 1j * x[::-1])
        record = np.zeros(n, dtype=[("t", ">f4"), ("F", "f8", (3,)), ("in", [("raw", "i2"), ("z", "c16")]), ("name", "S4")])
        record["t"], record["F"], record["in"]["raw"], record["in"]["z"] = x, wide, counts, x * 1j
        f.create_dataset("records", data=record, chunks=(1000,), compression="gzip")
        f["records_plain"] = record
        for records in ["records", "records_plain"]:
            case(name, f"{records}.t", record["t"])
            case(name, f"{records}.F[:,2]", wide[:, 2])
            case(name, f"{records}.F[3,:]", wide[3])
            case(name, f"{records}.in.raw", counts)
            case(name, f"{records}.in.z", x * 1j)
        f["again"] = f["a/b/plain"]
        f["soft"] = h5py.SoftLink("/a/b/wide")
        f["nowhere"] = h5py.SoftLink("/missing")
        f["elsewhere"] = h5py.ExternalLink("other.h5", "/x")
        f["a/b/root"] = f["/"]
        case(name, "again", x)
        case(name, "soft[:,1]", wide[:, 1])
        # Without numbers that could be read.
        f["names"] = ["a", "b"]
        f["nothing"] = h5py.Empty("f8")
        f["none"] = np.zeros((0, 3))
        f.create_dataset("lists", (2,), dtype=h5py.vlen_dtype("i4"))
        f["reference"] = np.array([g.ref], dtype=h5py.ref_dtype)
        f["unwritten"] = np.zeros(0)
        f.create_dataset("filled", (100,), dtype="f8", fillvalue=2.5, chunks=(10,))
        case(name, "filled", np.full(100, 2.5))
        f.create_dataset("filled_plain", (100,), dtype="f4", fillvalue=-1)
        case(name, "filled_plain", np.full(100, -1.0))
        scale = f.create_dataset("time", data=np.arange(n) / 1000)
        scale.attrs["units"] = "s"
        scale.make_scale("time")
        f["a/b/plain"].dims[0].attach_scale(scale)
        case(name, "time", np.arange(n) / 1000)

for libver in ["earliest", "latest"]:
    with h5py.File(folder / f"links_{libver}.h5", "w", libver=libver) as f:
        virtual = h5py.VirtualLayout(shape=(100,), dtype="f8")
        virtual[:] = h5py.VirtualSource("other.h5", "x", shape=(100,))
        f.create_virtual_dataset("virtual", virtual)
        f["g/elsewhere"] = h5py.ExternalLink("other.h5", "/x")
        f["plain"] = np.arange(7.0)
        f["g/inner"] = np.arange(5.0)
        many = f.create_group("many")
        for i in range(20):
            many[f"x{i}"] = np.arange(3.0) + i
        many["there"] = h5py.ExternalLink("third.h5", "/y")

# A layout of version 2, as HDF5 1.6 wrote it, has as many bytes as one of version 3 for a single axis.
with h5py.File(folder / "layout_2.h5", "w") as f:
    f["x"] = np.arange(9.0) / 4
content = bytearray((folder / "layout_2.h5").read_bytes())
place = content.index(b"\x08\x00\x18\x00") + 8
assert content[place : place + 2] == b"\x03\x01"
address = content[place + 2 : place + 10]
content[place : place + 24] = b"\x02\x02\x01" + bytes(5) + address + (9).to_bytes(4, "little") + (8).to_bytes(4, "little")
(folder / "layout_2.h5").write_bytes(content)

with h5py.File(folder / "userblock.h5", "w", userblock_size=2048) as f:
    f["x"] = x
case("userblock.h5", "x", x)

# As Keras writes weights: names with colons, attributes of texts.
with h5py.File(folder / "keras.h5", "w") as f:
    f.attrs["keras_version"] = b"2.11.0"
    f.attrs["layer_names"] = [b"dense", b"dense_1"]
    f["dense/dense/kernel:0"] = wide[:100]
    f["dense/dense/bias:0"] = x[:3].astype("f4")
case("keras.h5", "dense/dense/kernel:0[:,1]", wide[:100, 1])
case("keras.h5", "dense/dense/bias:0", x[:3].astype("f4"))

with h5py.File(folder / "words.h5", "w") as f:
    f["names"] = ["left", "right"]

# As MATLAB writes version 7.3: 512 bytes of header, arrays transposed, classes as attributes.
name = "v73.mat"
with h5py.File(folder / name, "w", userblock_size=512, libver="earliest") as f:
    refs = f.create_group("#refs#")

    def mark(stored, kind, **marks):
        stored.attrs["MATLAB_class"] = np.bytes_(kind)
        for key, value in marks.items():
            stored.attrs[f"MATLAB_{key}"] = value
        return stored

    def put(group, key, values, kind="double", **options):
        values = np.atleast_2d(np.asarray(values))
        if values.dtype.kind == "c":
            pair = np.zeros(values.shape, dtype=[("real", "f8"), ("imag", "f8")])
            pair["real"], pair["imag"] = values.real, values.imag
            values = pair
        return mark(group.create_dataset(key, data=values.T, **options), kind)

    def chars(group, key, text):
        return mark(group.create_dataset(key, data=np.array([[ord(c)] for c in text], dtype="u2")), "char", int_decode=np.int32(2))

    def cell(group, key, shape, members):
        stored = [member.ref for member in members]
        return mark(group.create_dataset(key, data=np.array(stored, dtype=h5py.ref_dtype).reshape(shape, order="F").T), "cell")

    column = x[:, np.newaxis]
    put(f, "out", wide, compression="gzip", chunks=(1, 1000))
    put(f, "contiguous", wide)
    put(f, "row", x)
    put(f, "col", column)
    put(f, "cube", np.zeros((1, 1)))
    del f["cube"]
    mark(f.create_dataset("cube", data=cube.transpose()), "double")
    put(f, "z", wide[:, 0] + 1j * wide[:, 1])
    put(f, "low", wide.astype("f4"), "single")
    put(f, "enc", counts[:, np.newaxis].astype("i4"), "int32")
    put(f, "flag", (column > 0).astype("u1"), "logical").attrs["MATLAB_int_decode"] = np.int32(1)
    put(f, "sr", 300_000.0)
    chars(f, "text", "1250.5")
    f["out"].attrs["rate"] = 77.0
    case(name, "/out@rate", 77.0, scalar=True)
    mark(f.create_dataset("empty", data=np.array([0, 0], dtype="u8")), "double", empty=np.uint8(1))
    s = mark(f.create_group("S"), "struct")
    put(s, "F", wide)
    inner = mark(s.create_group("inner"), "struct")
    put(inner, "fs", 1000.0)
    put(inner, "x", column)
    cells = [put(refs, "a", column), chars(refs, "b", "words"), put(refs, "c", wide), mark(refs.create_group("d"), "struct")]
    put(refs["d"], "deep", x[:9])
    cell(f, "C", (1, 4), cells)
    cell(f, "grid", (2, 2), cells)
    cell(f, "nested", (1, 1), [cell(refs, "e", (3, 1), cells[:3])])
    mark(f.create_dataset("many", data=np.full((60_000, 1), cells[0].ref, dtype=h5py.ref_dtype)), "cell")
    array = mark(f.create_group("T"), "struct")
    for key, members in [("f", [put(refs, "t0", x[:7]), put(refs, "t1", x[:8])]), ("label", [chars(refs, "t2", "i"), chars(refs, "t3", "ii")])]:
        array.create_dataset(key, data=np.array([[member.ref] for member in members], dtype=h5py.ref_dtype))
    mark(f.create_dataset("fun", data=np.zeros((1, 6), dtype="u4")), "my.Class", object_decode=np.int32(3))
    sparse = mark(f.create_group("sparse"), "double", sparse=np.uint64(3))
    sparse["jc"] = np.zeros(4, dtype="u8")
    for column_index in range(3):
        case(name, f"out[:,{column_index}]", wide[:, column_index])
        case(name, f"contiguous[:,{column_index}]", wide[:, column_index])
        case(name, f"S.F[:,{column_index}]", wide[:, column_index])
    case(name, "out[9,:]", wide[9])
    case(name, "cube[:,3,1]", cube[:, 3, 1])
    case(name, "cube[2,4,:]", cube[2, 4])
    case(name, "low[:,1]", wide[:, 1].astype("f4"))
    case(name, "z", wide[:, 0] + 1j * wide[:, 1])
    case(name, "C[2][:,1]", wide[:, 1])
    case(name, "grid[0,1][:,1]", wide[:, 1])
    for vector, values in {
        "row": x, "row[0,:]": x, "col": x, "/enc": counts, "flag": x > 0, "S.inner.x": x, "C[0]": x, "C[3].deep": x[:9],
        "grid[1,1].deep": x[:9], "nested[0][0]": x, "T[0].f": x[:7], "T[1].f": x[:8],
    }.items():
        case(name, vector, values)
    for scalar, value in [("sr", 300_000.0), ("text", 1250.5), ("S.inner.fs", 1000.0), ("row[4]", x[4]), ("out[4,2]", wide[4, 2])]:
        case(name, scalar, value, scalar=True)
with open(folder / name, "r+b") as file:
    file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Thu Nov 26 12:00:00 2026 HDF5 schema 1.00 .".ljust(124))
    file.write(b"\0\x02IM")

# TDMS
wave = {"wf_increment": 1 / 250_000, "wf_start_offset": 0.5, "unit_string": "V", "fs": 250_000.0, "gain": "12.5"}
with TdmsWriter(folder / "labview.tdms") as file:
    for part in np.array_split(np.arange(n), 7):
        channels = [ChannelObject("m s", "drive", x[part], wave), ChannelObject("m s", "F/x", counts[part].astype("i2"))]
        file.write_segment([RootObject({"rate": 1000}), *channels, ChannelObject("m s", "z", x[part] * 1j)])
    times = np.datetime64("2026-01-02T03:04:05") + np.arange(5).astype("timedelta64[s]")
    file.write_segment([ChannelObject("m s", "time", times), ChannelObject("m s", "notes", ["a", "b"])])
case("labview.tdms", "m s/drive", x)
case("labview.tdms", "m s/F/x", counts)
case("labview.tdms", "m s/z", x * 1j)
case("labview.tdms", "m s/time", times.astype("datetime64[s]").astype("f8"))
for scalar, value in [("/m s/drive@fs", 250_000.0), ("m s/drive@gain", 12.5), ("/@rate", 1000.0), ("m s/drive[3]", x[3])]:
    case("labview.tdms", scalar, value, scalar=True)

(folder / "cases.txt").write_text("\n".join(cases) + "\n")
