"""What other programs read of the volumes in tests/data/README.md: prints `values.tsv`, which `real_data.rs` holds
slabsplat's readers against.

    python -m venv v && v/bin/pip install nibabel==5.4.2 pynrrd==1.1.3 simpleitk==2.5.7
    v/bin/python crates/slabsplat-io/tests/reference/values.py FOLDER > crates/slabsplat-io/tests/reference/values.tsv

Places are of the first and the last voxel's middle, in RAS+ millimetres, or `-` where that program reads none of the
file. Values are those of five voxels, k/6 along x and z and 1 - k/6 along y, after the file's own scaling.
pynrrd reads no patterns of file names, so `nrrd/headsq/quarter.nhdr` is not among them.
"""

import pathlib
import sys

import nibabel
import nrrd
import numpy
import SimpleITK

LPS = numpy.diag([-1.0, -1.0, 1.0, 1.0])


def by_nibabel(path):
    image = nibabel.load(path)
    return numpy.asanyarray(image.dataobj), image.header.get_data_dtype(), image.affine


def by_pynrrd(path):
    values, header = nrrd.read(str(path))
    affine = None
    if "space directions" in header:
        affine = numpy.eye(4)
        affine[:3, :3] = header["space directions"].T
        affine[:3, 3] = header["space origin"]
        space = header["space"].lower()
        assert space in ("left-posterior-superior", "lps"), space
        affine = LPS @ affine
    return values, values.dtype, affine


def by_simpleitk(path):
    if path.is_dir():
        reader = SimpleITK.ImageSeriesReader()
        reader.SetFileNames(reader.GetGDCMSeriesFileNames(str(path)))
        image = reader.Execute()
    else:
        image = SimpleITK.ReadImage(str(path))
    values = SimpleITK.GetArrayFromImage(image).T
    affine = numpy.eye(4)
    affine[:3, :3] = numpy.reshape(image.GetDirection(), (3, 3)) @ numpy.diag(image.GetSpacing())
    affine[:3, 3] = image.GetOrigin()
    # It takes a TIFF's inches for millimetres, and reads no OME.
    return values, values.dtype, None if path.suffix == ".tif" else LPS @ affine


READERS = {"nifti": by_nibabel, "nrrd": by_pynrrd, "mha": by_simpleitk, "tiff": by_simpleitk, "dicom": by_simpleitk}

PATHS = [
    "nifti/mni152_t1_1mm_uint8.nii.gz",
    "nifti/mni152_2009c_t1_1mm_int16.nii.gz",
    "nifti/head_t1_mr_uint8_slope.nii.gz",
    "nifti/engine_256x256x128_uint8.nii.gz",
    "nrrd/embryo_256_uint8.nrrd",
    "nrrd/stroke_flair_1mm_uint8.nrrd",
    "nrrd/headsq_64x64x93_int16.nrrd",
    "nrrd/tooth/tooth.nhdr",
    "mha/ct_lung_115x157x129_int16.mha",
    "mha/fuel.mha",
    "mha/nucleon.mha",
    "mha/marschnerlobb.mha",
    "mha/HeadMRVolume.mhd",
    "tiff/neuron_409x415x119_uint8.tif",
    "tiff/ct_phantom_aniso.ome.tif",
    "dicom/ct_phantom_head",
]


def place(affine, index):
    if affine is None:
        return "-"
    return " ".join(f"{coordinate:.4f}" for coordinate in (affine @ [*index, 1])[:3])


def row(folder, path):
    values, stored, affine = READERS[path.split("/")[0]](folder / path)
    size = values.shape
    fractions = [(k / 6, 1 - k / 6, k / 6) for k in range(1, 6)]
    voxels = [tuple(int(n * f + 1e-9) for n, f in zip(size, fraction)) for fraction in fractions]
    exact = values.astype(numpy.float64)
    return [
        path,
        " ".join(map(str, size)),
        f"{exact.min():.6g} {exact.max():.6g}",
        f"{exact.mean():.8g}",
        place(affine, (0, 0, 0)),
        place(affine, [n - 1 for n in size]),
        " ".join(f"{exact[voxel]:.6g}" for voxel in voxels),
    ]


def main():
    folder = pathlib.Path(sys.argv[1])
    print("\t".join(["path", "dims", "range", "mean", "first voxel", "last voxel", "values"]))
    for path in PATHS:
        print("\t".join(row(folder, path)), flush=True)


main()
