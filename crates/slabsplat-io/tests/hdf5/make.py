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


def kinds():
    """What fewer programs write, behind a block of 1024 bytes; the last five are not read."""
    with h5py.File("kinds.h5", "w", userblock_size=1024) as file:
        chunks = dict(chunks=(2, 3, 4))
        values = VALUES.astype("<i2")
        file.create_dataset("scaled", data=values, scaleoffset=0, **chunks)
        file.create_dataset("scaled_floats", data=VALUES.astype(">f4"), scaleoffset=2, **chunks)
        file.create_dataset("lzf", data=values, compression="lzf", shuffle=True, fletcher32=True, **chunks)
        unpacked = file.create_dataset("unpacked", SHAPE, "<i2", chunks=SHAPE, compression="gzip")
        unpacked.id.write_direct_chunk((0, 0, 0), values.tobytes(), filter_mask=1)
        shrunk = file.create_dataset("shrunk", data=numpy.zeros((5, 5, 9), "<i2"), maxshape=(None,) * 3, **chunks)
        shrunk.resize(SHAPE)
        shrunk[...] = values
        file.create_dataset("sized", data=values).attrs["element_size_um"] = [3, 2, 1]
        file.create_dataset("szip", data=values, compression="szip", chunks=(2, 4, 4))
        n_bit = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        n_bit.set_chunk((2, 3, 4))
        n_bit.set_filter(h5py.h5z.FILTER_NBIT, 0)
        h5py.h5d.create(file.id, b"n_bit", h5py.h5t.STD_I16LE, h5py.h5s.create_simple(SHAPE), n_bit).write(
            h5py.h5s.ALL, h5py.h5s.ALL, values
        )
        layout = h5py.VirtualLayout(SHAPE, "<i2")
        layout[:] = h5py.VirtualSource(file["sized"])
        file.create_virtual_dataset("virtual", layout)
        file.create_dataset("external", SHAPE, "<i2", external=[("/none", 0, h5py.h5f.UNLIMITED)])
        file["link"] = h5py.SoftLink("/sized")
    with h5py.File("newest.h5", "w", libver="latest") as file:
        file.create_dataset("packed", data=values, **PACKED)
        file["plain"] = values


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
kinds()
others()
for name in ["classic.h5", "newer.h5", "kinds.h5", "newest.h5", "a.nc", "a.mat"]:
    path = pathlib.Path(name)
    pathlib.Path(f"{name}.gz").write_bytes(gzip.compress(path.read_bytes(), mtime=0))
    path.unlink()
