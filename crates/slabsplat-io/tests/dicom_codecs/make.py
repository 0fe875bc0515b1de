"""Small DICOM files, packed by other programs, and what pydicom reads of them: writes `*.dcm` beside itself
and prints `values.tsv`, which `dicom_codecs.rs` holds slabsplat's reader against.

    python -m venv v && v/bin/pip install numpy==2.4.6 pydicom==3.0.2 imagecodecs==2026.3.6 \
        pyjpegls==1.5.1 pylibjpeg==2.1.0 pylibjpeg-libjpeg==2.5.0 pylibjpeg-openjpeg==2.6.0
    cd crates/slabsplat-io/tests/dicom_codecs && v/bin/python make.py > values.tsv

JPEG-LS is by CharLS, JPEG 2000 by OpenJPEG, JPEG by libjpeg-turbo.
Each line has a file, a channel, how far values may be off, the sum of all values, and every seventh of them.
"""

import pathlib

import imagecodecs
import jpeg_ls
import numpy
import pydicom
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.uid import UID, RLELossless

COLUMNS, ROWS = 33, 21
FOLDER = pathlib.Path(__file__).parent
Y, X = numpy.mgrid[:ROWS, :COLUMNS]

# A disc with ramps and noise, around which all is the same, as scanners have it.
INSIDE = (X - 16) ** 2 + (Y - 10) ** 2 < 110
NOISE = (7 * X * X + 13 * Y * Y + 5 * X * Y) % 53
GRAY = numpy.where(INSIDE, 97 * X + 41 * Y + NOISE, 0)
COLORS = numpy.stack([numpy.where(INSIDE, (5 * X + k * 3 * Y + NOISE) % 256, 20 * k) for k in (1, 2, 3)], -1)


def dataset(pixels, stored, photometric="MONOCHROME2", planar=0):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = UID("1.2.840.10008.5.1.4.1.1.2")
    meta.MediaStorageSOPInstanceUID = UID("1.2.3.4")
    image = FileDataset(None, {}, file_meta=meta, preamble=bytes(128))
    image.SOPClassUID, image.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
    image.Modality, image.SeriesInstanceUID = "CT", "1.2.3"
    image.ImagePositionPatient, image.ImageOrientationPatient = [0, 0, 0], [1, 0, 0, 0, 1, 0]
    image.PixelSpacing, image.SliceThickness = [1, 1], 2
    image.Rows, image.Columns = pixels.shape[:2]
    image.SamplesPerPixel = 1 if pixels.ndim == 2 else 3
    if pixels.ndim == 3:
        image.PlanarConfiguration = planar
    image.PhotometricInterpretation = photometric
    image.BitsAllocated, image.BitsStored = 8 * pixels.itemsize, stored
    image.HighBit, image.PixelRepresentation = stored - 1, int(pixels.dtype.kind == "i")
    return image


def save(name, image, syntax, *frames):
    image.file_meta.TransferSyntaxUID = UID(syntax)
    image.PixelData = encapsulate(list(frames), has_bot=False)
    image["PixelData"].VR = "OB"
    image.save_as(FOLDER / name, enforce_file_format=True)


def charls(pixels, interleave=0, near=0):
    return bytes(jpeg_ls.encode_array(pixels, near, interleave))


def openjpeg(pixels, bits, level=0, **options):
    """Lossless at level 0, or else with so many decibels."""
    options = dict(options, codecformat="j2k", bitspersample=bits, resolutions=3, reversible=level == 0)
    return imagecodecs.jpeg2k_encode(pixels, level=level, **options)


def libjpeg(pixels, level, **options):
    return imagecodecs.jpeg8_encode(pixels, level=level, **options)


def bare_bits(pixels, stored):
    """Negative values as encoders without signs have them."""
    return (pixels & ((1 << stored) - 1)).astype(numpy.uint16)


def make_all():
    gray = GRAY.astype(numpy.uint16)
    signed = (GRAY - 1024).astype(numpy.int16)
    wide = (GRAY * 16 + NOISE).astype(numpy.uint16)
    byte = (GRAY // 16).astype(numpy.uint8)
    colors = COLORS.astype(numpy.uint8)
    lossless_ls, near_ls = "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81"
    save("ls_12.dcm", dataset(gray, 12), lossless_ls, charls(gray))
    save("ls_8.dcm", dataset(byte, 8), lossless_ls, charls(byte))
    save("ls_16.dcm", dataset(wide, 16), lossless_ls, charls(wide))
    save("ls_signed.dcm", dataset(signed, 13), lossless_ls, charls(bare_bits(signed, 13)))
    save("ls_near.dcm", dataset(gray, 12), near_ls, charls(gray, near=5))
    save("ls_near_8.dcm", dataset(byte, 8), near_ls, charls(byte, near=2))
    for planar, (name, interleave) in enumerate([("planes", 0), ("lines", 1), ("pixels", 2)]):
        pixels = numpy.ascontiguousarray(colors.transpose(2, 0, 1)) if interleave == 0 else colors
        image = dataset(colors, 8, "RGB", int(interleave == 0))
        save(f"ls_{name}.dcm", image, lossless_ls, charls(pixels, interleave))
    save("ls_near_pixels.dcm", dataset(colors, 8, "RGB"), near_ls, charls(colors, 2, near=3))
    lossless_2000, lossy_2000 = "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91"
    save("2000_12.dcm", dataset(gray, 12), lossless_2000, openjpeg(gray, 12))
    save("2000_signed.dcm", dataset(signed, 16), lossless_2000, openjpeg(signed, 16))
    save("2000_bits.dcm", dataset(signed, 13), lossless_2000, openjpeg(bare_bits(signed, 13), 13))
    save("2000_lossy.dcm", dataset(gray, 12), lossy_2000, openjpeg(gray, 12, level=40))
    rct = openjpeg(colors, 8, mct=True)
    save("2000_rct.dcm", dataset(colors, 8, "YBR_RCT"), lossless_2000, rct)
    ict = openjpeg(colors, 8, level=35, mct=True)
    save("2000_ict.dcm", dataset(colors, 8, "YBR_ICT"), lossy_2000, ict)
    save("jpeg_12.dcm", dataset(gray, 12), "1.2.840.10008.1.2.4.51", libjpeg(gray, 97, bitspersample=12))
    for name, photometric in [("ybr", "YBR_FULL"), ("422", "YBR_FULL_422")]:
        subsampling = "422" if name == "422" else "444"
        packed = libjpeg(colors, 90, colorspace="RGB", outcolorspace="YCBCR", subsampling=subsampling)
        save(f"jpeg_{name}.dcm", dataset(colors, 8, photometric), "1.2.840.10008.1.2.4.50", packed)
    runs = dataset(colors, 8, "RGB")
    runs.compress(RLELossless, colors, encoding_plugin="pydicom", generate_instance_uid=False)
    runs.PlanarConfiguration = 1
    runs.save_as(FOLDER / "rle_planar.dcm", enforce_file_format=True)


def values(path):
    image = pydicom.dcmread(path)
    pixels = pydicom.pixels.pixel_array(path, raw=False)
    is_lossy = any(word in path.name for word in ("lossy", "ict", "jpeg"))
    planes = [pixels] if pixels.ndim == 2 else numpy.moveaxis(pixels, -1, 0)
    for channel, plane in enumerate(planes):
        plane = plane.astype(int).ravel()
        # Cosine transforms are rounded here and there, and colours once more.
        off = 0 if not is_lossy else 3 if "_ybr" in path.name or "_422" in path.name else 2
        print(path.name, channel, off, plane.sum(), " ".join(map(str, plane[::7])), sep="\t")


make_all()
for path in sorted(FOLDER.glob("*.dcm")):
    values(path)
