"""Small HDF5 files for `tests/hdf5.rs`, which knows the values: z, y and x of a voxel as one number.
They are packed, since HDF5 leaves much room.

    python -m venv v && v/bin/pip install h5py==3.16.0 numpy==2.4.6 netCDF4==1.7.5.1
    cd crates/slabsplat-io/tests/hdf5 && v/bin/python make.py
"""

import gzip
import pathlib

import h5py
import netCDF4
import numpy

SHAPE = (3, 4, 5)
Z, Y, X = numpy.mgrid[:3, :4, :5]
VALUES = 20 * Z + 5 * Y + X
PACKED = dict(chunks=(2, 3, 4), compression="gzip", shuffle=True)


def classic():
    """As h5py writes by default, with all types, in both byte orders."""
    with h5py.File("classic.h5", "w", libver="earliest") as file:
        for kind in "u1 i1 u2 i2 u4 i4 u8 i8 f2 f4 f8".split():
            file[f"little/{kind}"] = VALUES.astype(f"<{kind}")
            file[f"big/{kind}"] = VALUES.astype(f">{kind}")
        packed = file.create_dataset("packed/a", data=VALUES.astype(">u2"), **PACKED)
        packed.attrs["element_size_um"] = [2.0, 1.0, 0.5]
        file.create_dataset("packed/grows", data=VALUES.astype("<i2"), maxshape=(None, None, 5), **PACKED)
        file["bool"] = VALUES % 2 == 0
        file["time"] = numpy.arange(7.0)
        file["text"] = "a text"


def newer():
    """The form of HDF5 1.10 to 1.14, by all kinds of indices of chunks; one is not read."""
    with h5py.File("newer.h5", "w", libver=("v110", "v114")) as file:
        values = VALUES.astype("<i2")
        file.create_dataset("fixed", data=values, **PACKED)
        file.create_dataset("one_grows", data=values, maxshape=(None, 4, 5), **PACKED)
        file.create_dataset("two_grow", data=values, maxshape=(None, None, 5), **PACKED)
        file.create_dataset("sums", data=values, chunks=(2, 3, 4), fletcher32=True)
        sparse = file.create_dataset("sparse", SHAPE, "<i2", chunks=(1, 2, 5), fillvalue=-7)
        sparse[1, :2] = values[1, :2]
        five = numpy.stack([[100 * (3 * t + c) + values for c in range(3)] for t in range(2)])
        file.create_dataset("five", data=five, chunks=(1, 1, 2, 4, 5), compression="gzip")


def others():
    with netCDF4.Dataset("a.nc", "w", format="NETCDF4") as file:
        for name, size in zip("zyx", SHAPE):
            file.createDimension(name, size)
            file.createVariable(name, "f4", (name,))[:] = numpy.arange(size)
        file.createVariable("density", "f4", ("z", "y", "x"), zlib=True)[:] = VALUES
    with h5py.File("a.mat", "w", userblock_size=512) as file:
        file["a"] = VALUES.astype("<f8")
    with open("a.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(128))


classic()
newer()
others()
for name in ["classic.h5", "newer.h5", "a.nc", "a.mat"]:
    path = pathlib.Path(name)
    pathlib.Path(f"{name}.gz").write_bytes(gzip.compress(path.read_bytes(), mtime=0))
    path.unlink()
