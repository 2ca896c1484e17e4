"""Writes HDF5 files of 4 GB, of which little is on the disk: contiguous, in chunks, and as MATLAB v7.3."""

import sys
from pathlib import Path

import h5py
import numpy as np

folder = Path(sys.argv[1])
rows = 2**28
end = np.array([[1.5, 7.0], [2.5, 8.0], [3.5, 9.0]])


def create(file, name, shape):
    layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
    layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    space = h5py.h5s.create_simple(shape)
    return h5py.Dataset(h5py.h5d.create(file.id, name.encode(), h5py.h5t.IEEE_F64LE, space, dcpl=layout))


with h5py.File(folder / "contiguous.h5", "w") as f:
    create(f, "x", (rows, 2))[-3:] = end
for libver in ["earliest", "latest"]:
    with h5py.File(folder / f"chunks_{libver}.h5", "w", libver=libver) as f:
        x = f.create_dataset("x", (rows, 2), "f8", chunks=(2**18, 1), maxshape=(None, 2), compression="gzip")
        x[-3:] = end
        x[: 2**20, 1] = 4.0
with h5py.File(folder / "v73.mat", "w", userblock_size=512) as f:
    x = create(f, "x", (2, rows))
    x[:, -3:] = end.T
    x.attrs["MATLAB_class"] = np.bytes_("double")
