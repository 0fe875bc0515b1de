#!/usr/bin/env python3
"""Times VTK's volume ray casters on a scene of slabsplat: what a user would pick instead.

    python3 -m venv peers && peers/bin/pip install vtk
    peers/bin/python vtk_raycast.py scene.toml [--mapper cpu|gpu] [--sample 1.0] [--threads N]
                                               [--frames 12] [--width N] [--height N] [-o out.png]

`cpu` is vtkFixedPointVolumeRayCastMapper, which VTK takes where there is no GPU.
`gpu` is vtkOpenGLGPUVolumeRayCastMapper through EGL: with Mesa's software OpenGL a check, not a fair peer.
The camera turns by one degree a frame about its target, so that nothing comes from a cache.

Of a scene it reads the path in [volume] (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, .raw of bytes with its
.json), opacity and color in [classify], [shading], [camera] and [image]. A camera without an eye stays where
VTK puts it.
The last line that it prints is JSON, with the times in milliseconds.
"""

import argparse
import json
import os
import statistics
import time
import tomllib

import vtk


def parse_args():
    parser = argparse.ArgumentParser(description="Times VTK's ray casters on a scene.")
    parser.add_argument("scene")
    parser.add_argument("--mapper", default="cpu", choices=["cpu", "gpu"])
    parser.add_argument("--sample", type=float, default=1.0, help="distance of samples, in voxels")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--frames", type=int, default=12)
    parser.add_argument("--width", type=int, help="pixels, instead of the scene's")
    parser.add_argument("--height", type=int)
    parser.add_argument("-o", "--output", help="a PNG of the last frame")
    return parser.parse_args()


def raw_reader(path):
    with open(os.path.splitext(path)[0] + ".json") as file:
        desc = json.load(file)
    assert desc["type"] == "uint8", "raw files of bytes only"
    reader = vtk.vtkImageReader2()
    reader.SetFileDimensionality(3)
    # The first row of a file is that of the least y; VTK would take it for the last one.
    reader.FileLowerLeftOn()
    reader.SetDataScalarTypeToUnsignedChar()
    reader.SetDataExtent(*[end for n in desc["dims"] for end in (0, n - 1)])
    reader.SetDataSpacing(*desc["spacing"])
    reader.SetDataOrigin(*desc["origin"])
    return reader


def read_volume(path):
    """The voxels; the matrix from spaced voxels to the world if the format has one; values are samples times
    a slope, plus an intercept."""
    name = path.lower()
    is_nifti = name.endswith((".nii", ".nii.gz"))
    if name.endswith(".raw"):
        reader = raw_reader(path)
    elif is_nifti:
        reader = vtk.vtkNIFTIImageReader()
    elif name.endswith((".nrrd", ".nhdr")):
        reader = vtk.vtkNrrdReader()
    else:
        reader = vtk.vtkMetaImageReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    matrix = (reader.GetSFormMatrix() or reader.GetQFormMatrix()) if is_nifti else None
    if matrix:
        # The matrix has the offset, too: it must not be added twice.
        image.SetOrigin(0.0, 0.0, 0.0)
    scaling = (reader.GetRescaleSlope(), reader.GetRescaleIntercept()) if is_nifti else (1.0, 0.0)
    return image, matrix, scaling


def volume_property(scene, voxel, scaling):
    """Transfer function and shading. Both programs take opacity per voxel step."""
    slope, intercept = scaling
    opacity, color = vtk.vtkPiecewiseFunction(), vtk.vtkColorTransferFunction()
    for point in scene["classify"]["opacity"]:
        opacity.AddPoint((point[0] - intercept) / slope, *point[1:])
    for point in scene["classify"]["color"]:
        color.AddRGBPoint((point[0] - intercept) / slope, *point[1:])
    prop = vtk.vtkVolumeProperty()
    prop.SetColor(color)
    prop.SetScalarOpacity(opacity)
    prop.SetScalarOpacityUnitDistance(voxel)
    prop.SetInterpolationTypeToLinear()
    shading = scene.get("shading", {})
    if shading.get("model") == "phong":
        prop.ShadeOn()
        prop.SetAmbient(shading["ambient"])
        prop.SetDiffuse(shading["diffuse"])
        prop.SetSpecular(shading["specular"])
        prop.SetSpecularPower(shading["shininess"])
    return prop


def volume_mapper(args, image, voxel):
    if args.mapper == "cpu":
        mapper = vtk.vtkFixedPointVolumeRayCastMapper()
        mapper.SetNumberOfThreads(args.threads)
        # A ray for every pixel.
        mapper.SetImageSampleDistance(1.0)
    else:
        mapper = vtk.vtkOpenGLGPUVolumeRayCastMapper()
    # VTK would take fewer samples to reach a frame rate.
    mapper.SetAutoAdjustSampleDistances(0)
    mapper.SetSampleDistance(args.sample * voxel)
    mapper.SetInputData(image)
    return mapper


def place_camera(camera, desc):
    if "eye" in desc:
        camera.SetPosition(*desc["eye"])
        camera.SetFocalPoint(*desc["target"])
        camera.SetViewUp(*desc["up"])
    if desc.get("projection", "orthographic") == "perspective":
        camera.SetViewAngle(desc["fov_y"])
    else:
        camera.ParallelProjectionOn()
        # Half of the picture's height, by VTK's definition.
        camera.SetParallelScale(desc["view_height"] / 2)


def open_window(args, scene):
    """A window off screen that shows the scene, and its renderer."""
    path = os.path.join(os.path.dirname(args.scene), scene["volume"]["path"])
    image, matrix, scaling = read_volume(path)
    voxel = min(image.GetSpacing())
    volume = vtk.vtkVolume()
    volume.SetMapper(volume_mapper(args, image, voxel))
    volume.SetProperty(volume_property(scene, voxel, scaling))
    if matrix:
        volume.SetUserMatrix(matrix)
    renderer = vtk.vtkRenderer()
    renderer.AddVolume(volume)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    image = scene["image"]
    window.SetSize(args.width or image["width"], args.height or image["height"])
    window.AddRenderer(renderer)
    place_camera(renderer.GetActiveCamera(), scene["camera"])
    return window, renderer


def time_frames(window, renderer, n_frames):
    """Milliseconds of each frame, the camera's way to it not counted."""
    renderer.ResetCameraClippingRange()
    # The first frame makes gradients and tables, the second may still allocate.
    window.Render()
    window.Render()
    times_ms = []
    for _ in range(n_frames):
        renderer.GetActiveCamera().Azimuth(1.0)
        renderer.ResetCameraClippingRange()
        start_secs = time.perf_counter()
        window.Render()
        times_ms.append(1e3 * (time.perf_counter() - start_secs))
    return times_ms


def write_png(window, path):
    grabber = vtk.vtkWindowToImageFilter()
    grabber.SetInput(window)
    grabber.Update()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(path)
    writer.SetInputConnection(grabber.GetOutputPort())
    writer.Write()


def main():
    args = parse_args()
    with open(args.scene, "rb") as file:
        scene = tomllib.load(file)
    window, renderer = open_window(args, scene)
    times_ms = time_frames(window, renderer, args.frames)
    if args.output:
        write_png(window, args.output)
    answer = {
        "mapper": args.mapper,
        "threads": args.threads,
        "sample": args.sample,
        "window": window.GetClassName(),
        "median_ms": round(statistics.median(times_ms), 2),
        "min_ms": round(min(times_ms), 2),
        "frames_ms": [round(ms, 1) for ms in times_ms],
    }
    print(json.dumps(answer))


if __name__ == "__main__":
    main()
