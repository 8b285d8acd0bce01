"""Shows a run in ParaView: particles in their size, coloured by a field; picture and movie.

In a terminal, with ParaView's pvpython (on a machine without a display: xvfb-run -a pvpython ...):

    pvpython cases/in_paraview.py block3d.out                          writes block3d-von-mises.png
    pvpython cases/in_paraview.py block3d.out --movie block3d.avi
    pvpython cases/in_paraview.py block3d.out --frames block3d-frames  a PNG for each frame
    pvpython cases/in_paraview.py --help

In ParaView: View > Python Shell, Run Script, choose this file; then, in the shell,

    show("/path/to/block3d.out", field="stress.xx", camera="y-min")

and go on with mouse and menus. The state can be saved as usual.
"""

import argparse
import json
import math
import os
import re
import shutil
import sys
import tempfile

# This file has the name of ParaView's package: its folder must not be searched for that.
HERE = os.path.dirname(os.path.realpath(globals().get("__file__", "")))
sys.path[:] = [path for path in sys.path if os.path.realpath(path) != HERE]

try:
    from paraview import servermanager, simple
except ImportError:
    sys.exit(
        "in_paraview.py: this is no Python of ParaView's. Run it with pvpython, or from the Python "
        "shell of ParaView. On Debian: apt-get install paraview python3-paraview xvfb"
    )

COMPONENTS = {3: "x y z".split(), 6: "xx yy zz xy yz xz".split()}
COMPONENTS[9] = "xx xy xz yx yy yz zx zy zz".split()
CAMERAS = {
    "corner": (0.44, -0.77, 0.46),
    "x-min": (-1, 0, 0),
    "x-max": (1, 0, 0),
    "y-min": (0, -1, 0),
    "y-max": (0, 1, 0),
    "z-min": (0, 0, -1),
    "z-max": (0, 0, 1),
}
# Units of the fields, of length, mass and time; those of these consistent sets have names.
KINDS = {
    "velocity": "L/T",
    "stress": "S",
    "displacement": "L",
    "pressure": "S",
    "von-mises": "S",
    "mass": "M",
    "density": "M/L\u00b3",
    "volume": "V",
    "initial-volume": "V",
    "velocity-gradient": "1/T",
    "radius": "L",
    "principal-stress": "S",
    "max-shear": "S",
    "recovered-stress": "S",
    "strain-energy-density": "S",
    "kinetic-energy-density": "S",
    "contact-pressure": "S",
    "traction": "S",
    "gap": "L",
    "slip": "L",
    "wear-work": "SL",
}
PRESSURES = {
    "m, kg, s": "Pa",
    "mm, t, s": "MPa",
    "mm, g, ms": "MPa",
    "mm, kg, ms": "GPa",
    "cm, g, us": "Mbar",
}
OUTLIERS = 0.005
ROOM = 0.25
MOST_SAMPLED = 200_000
MOVIES = (".avi", ".ogv", ".mp4")
MOST_LOOKED_AT = 200
MARGIN = 1.15
LABELS = 65  # pixels, of the axes in 2D
FILLED = 0.8  # of the width; the rest is for the bar of colours
BELOW, LEFT_AND_BELOW = 2, 3  # of the bits of a grid's axes
INK = [0.15, 0.15, 0.15]
NOTHING = [0.8, 0.8, 0.8]


class Wrong(Exception):
    """Something is missing or makes no sense; the message is for people."""


class Scene:
    """What `show` has made.

    Attributes
    ----------
    reader, display, view
        ParaView's proxies of the data, of its looks, and of the window.
    field : str
        What gives the colours.
    times : list of float
        Times of the frames.
    """

    def __init__(self, reader, display, view, field, times):
        self.reader, self.display, self.view = reader, display, view
        self.field, self.times = field, times

    def go(self, index):
        """Show a frame; -1 is the last."""
        if not -len(self.times) <= index < len(self.times):
            raise Wrong(f"there is no frame {index}: there are {len(self.times)}, from 0, or -1")
        self.view.ViewTime = self.times[index]
        simple.GetAnimationScene().AnimationTime = self.times[index]
        simple.Render(self.view)


def show(
    run,
    field=None,
    camera=None,
    limits=None,
    body=None,
    scale=1.0,
    size=(1200, 800),
    palette="Viridis (matplotlib)",
):
    """Open a run and set the view up.

    Parameters
    ----------
    run : str
        The run directory.
    field : str, optional
        Field or component: von-mises, stress.xx, velocity (its magnitude); by default von-mises, or
        the first of stress.xx, velocity and volume that is there.
    camera : str or three numbers, optional
        ``corner`` (in 3D the default), a face such as ``y-min``, or the direction towards the eye.
    limits : two numbers, optional
        Values of the first and the last colour; by default those of the particles at all times,
        without the half per cent at an end that would stretch the scale by more than a quarter.
    body : int, optional
        Only the body of this number, in the order of the case, from 0.
    scale : float
        Radius of the spheres over half the side of a particle's box.
    size : two int
        Width and height of pictures.
    palette : str
        One of ParaView's colour maps.

    Returns
    -------
    Scene
        Reader, display and view, to go on with.

    Raises
    ------
    Wrong
        If there is nothing to show, or an argument makes no sense.
    """
    directory = os.path.abspath(run)
    path = os.path.join(directory, "particles.xdmf")
    if not os.path.isdir(directory):
        raise Wrong(f"there is no run directory {run}")
    if not os.path.exists(path):
        raise Wrong(f"{run} has no particles.xdmf: no run, or one without frames (output.every)")
    reader = simple.XDMFReader(FileNames=[path])
    reader.UpdatePipelineInformation()
    times = reader.TimestepValues
    times = list(times) if hasattr(times, "__len__") else [times]
    if not times:
        raise Wrong(f"{run} has no frames yet")
    reader.UpdatePipeline(times[-1])
    name, component = _field(field, reader)
    label = _label(reader, name, component)
    units = _units(directory)
    source = _only(reader, body) if body is not None else reader
    low, high, bounds = _survey(source, times, name, component)
    if limits is not None:
        low, high = limits
    flat = bounds[4] == bounds[5] == 0.0

    simple._DisableFirstRenderCameraReset()  # the first picture would undo the camera below
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize = list(size)
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    display = simple.Show(source, view)
    display.SetRepresentationType("Point Gaussian")
    display.GaussianRadius = scale
    display.ScaleByArray = 1
    display.SetScaleArray = ["POINTS", "radius"]
    display.UseScaleFunction = 0
    display.OpacityByArray = 0
    display.Emissive = 0
    display.Ambient, display.Diffuse = 0.25, 0.85
    display.ShaderPreset = "Plain circle" if flat else "Sphere"
    words = label.replace("von-mises", "von Mises stress").replace("-", " ").replace(".", " ")
    title = _with_unit(words, units.get(KINDS.get(name)))
    _colour(display, view, title, name, component, low, high, palette)
    _outline(os.path.join(directory, "rigid.xdmf"), view)
    _aim(view, camera, bounds, size, flat, units.get("L"))
    _time(reader, view, units.get("T", ""))
    scene = Scene(source, display, view, label, times)
    scene.go(-1)
    return scene


def _arrays(source):
    """Return the number of components of each array."""
    data = source.PointData
    return {data[i].Name: data[i].GetNumberOfComponents() for i in range(len(data))}


def _field(text, reader):
    """Return the array of a field and the component, -1 for a magnitude or a scalar."""
    there = _arrays(reader)
    if text is None:
        text = next((one for one in ("von-mises", "stress", "velocity") if one in there), "volume")
        text += ".xx" if text == "stress" else ""
    name, _, component = text.partition(".")
    known = []
    for one, count in sorted(there.items()):
        known += [one] if count in (1, 3) else []
        known += [f"{one}.{part}" for part in COMPONENTS.get(count, ())]
    if text not in known:
        raise Wrong(f"the last frame has no field {text}; it has {', '.join(known)}")
    return name, COMPONENTS[there[name]].index(component) if component else -1


def _label(reader, name, component):
    """Return the name of what is shown, with its component."""
    return name if component < 0 else f"{name}.{COMPONENTS[_arrays(reader)[name]][component]}"


def _units(directory):
    """Return the units by the letters of `KINDS`; none if the case's label is no list of three."""
    found = {"dimensions": "3", "units": '""'}
    try:
        with open(os.path.join(directory, "case.yaml"), encoding="utf-8") as file:
            found.update(re.findall(r"^(dimensions|units): (.*)$", file.read(), re.MULTILINE))
        label, dimension = json.loads(found["units"]), int(found["dimensions"])
    except (OSError, ValueError):  # pictures need no units
        return {}
    parts = [part.strip() for part in str(label).split(",")]
    if len(parts) != 3 or not all(re.fullmatch("[A-Za-z]+", part) for part in parts):
        return {}
    length, mass, time = parts
    power = ("", "", "\u00b2", "\u00b3")
    stress = PRESSURES.get(", ".join(parts), f"{mass}/({length} {time}\u00b2)")
    across = f"/{length}{power[3 - dimension]}" if dimension < 3 else ""
    return {
        "L": length,
        "T": time,
        "L/T": f"{length}/{time}",
        "1/T": f"1/{time}",
        "M": mass + across,
        "M/L\u00b3": f"{mass}/{length}\u00b3",
        "V": length + power[dimension],
        "S": stress,
        "SL": f"{stress} {length}",
    }


def _with_unit(text, unit):
    return f"{text} [{unit}]" if unit else text


def _only(reader, body):
    """Return the particles of a body."""
    found = simple.Threshold(Input=reader, Scalars=["POINTS", "body"])
    found.LowerThreshold = found.UpperThreshold = body
    found.UpdatePipeline()
    if not found.GetDataInformation().GetNumberOfPoints():
        raise Wrong(f"the last frame has no particle of body {body}; bodies count from 0")
    return found


def _survey(source, times, name, component):
    """Return the ends of the colours, and the bounds, of all times or of many."""
    low, high = math.inf, -math.inf
    bounds = [math.inf, -math.inf] * 3
    step = -(-len(times) // MOST_LOOKED_AT)
    chosen = sorted({*times[::step], times[-1]})
    values = []
    sample = simple.MaskPoints(Input=source)
    sample.RandomSampling = 0
    sample.MaximumNumberofPoints = MOST_SAMPLED
    for time in chosen:
        source.UpdatePipeline(time)
        array = source.PointData[name]
        data = source.GetDataInformation()
        count = data.GetNumberOfPoints()
        if not count or array is None:
            continue
        sample.OnRatio = -(-count * len(chosen) // MOST_SAMPLED)
        sample.UpdatePipeline(time)
        values += _values(servermanager.Fetch(sample), name, component)
        ends = array.GetRange(component)
        low, high = min(low, ends[0]), max(high, ends[1])
        reach = source.PointData["radius"].GetRange(0)[1]
        ends = data.GetBounds()
        for i in range(0, 6, 2):
            room = reach if ends[i] != ends[i + 1] or ends[i] != 0.0 else 0.0
            bounds[i] = min(bounds[i], ends[i] - room)
            bounds[i + 1] = max(bounds[i + 1], ends[i + 1] + room)
    simple.Delete(sample)
    if not math.isfinite(bounds[0]):
        raise Wrong("there are no particles in any frame")
    low, high = _inner(low, high, sorted(values))
    return low, high if high > low else low + (abs(low) or 1.0), bounds


def _values(data, name, component):
    """Return the finite values of an array, or of its magnitude."""
    array = data.GetPointData().GetArray(name)
    rows = range(array.GetNumberOfTuples())
    if component < 0 and array.GetNumberOfComponents() > 1:
        found = [math.hypot(*array.GetTuple(row)) for row in rows]
    else:
        found = [array.GetComponent(row, max(component, 0)) for row in rows]
    return [value for value in found if math.isfinite(value)]


def _inner(low, high, values):
    """Return the ends of the colours, without outliers that would stretch their scale by much."""
    if not values:
        return 0.0, 1.0
    last = len(values) - 1
    inner = []
    for place in (OUTLIERS * last, (1.0 - OUTLIERS) * last):
        below = math.floor(place)
        above = min(below + 1, last)
        inner.append(values[below] + (place - below) * (values[above] - values[below]))
    room = ROOM * (inner[1] - inner[0])
    if room > 0.0:
        low = low if inner[0] - low <= room else inner[0]
        high = high if high - inner[1] <= room else inner[1]
    return low, high


def _colour(display, view, title, name, component, low, high, palette):
    """Colour by an array, with a bar."""
    simple.ColorBy(display, ("POINTS", name))
    table = simple.GetColorTransferFunction(name)
    if not table.ApplyPreset(palette, True):
        raise Wrong(f"ParaView has no colour map {palette}")
    table.VectorMode = "Component" if component >= 0 else "Magnitude"
    table.VectorComponent = max(component, 0)
    table.RescaleTransferFunction(low, high)
    table.AutomaticRescaleRangeMode = "Never"
    table.NanColor = NOTHING  # of particles whose material has no such field
    display.SetScalarBarVisibility(view, True)
    bar = simple.GetScalarBar(table, view)
    bar.Title = title
    bar.ComponentTitle = ""
    bar.TitleColor = bar.LabelColor = INK
    bar.TitleFontSize, bar.LabelFontSize = 18, 16
    bar.WindowLocation = "Any Location"
    number = "%.6g" if "%" in bar.RangeLabelFormat else "{:.6g}"  # ParaView 6 has the latter
    bar.RangeLabelFormat = number
    bar.Orientation, bar.Position, bar.ScalarBarLength = "Vertical", [0.83, 0.2], 0.6


def _outline(path, view):
    """Show rigid bodies as outlines, in 3D as nets, where the run has any."""
    if not os.path.exists(path):
        return
    display = simple.Show(simple.XDMFReader(FileNames=[path]), view)
    display.SetRepresentationType("Wireframe")
    simple.ColorBy(display, None)
    display.AmbientColor = display.DiffuseColor = INK
    display.LineWidth = 2.0


def _aim(view, camera, bounds, size, flat, length):
    """Look at the bounds from a direction, in parallel projection, so that they fill the view."""
    view.InteractionMode = "2D" if flat else "3D"
    view.OrientationAxesVisibility = 0 if flat else 1
    view.OrientationAxesLabelColor = INK
    towards = _direction("z-max" if camera is None and flat else camera or "corner")
    up = (0.0, 1.0, 0.0) if abs(towards[2]) > 0.999 else (0.0, 0.0, 1.0)
    right = _unit(_cross(up, towards))
    up = _cross(towards, right)
    middle = [0.5 * (bounds[i] + bounds[i + 1]) for i in (0, 2, 4)]
    half = [0.5 * (bounds[i + 1] - bounds[i]) for i in (0, 2, 4)]
    wide, high = (sum(abs(a) * h for a, h in zip(axis, half, strict=True)) for axis in (right, up))
    room = [FILLED * size[0] / MARGIN, size[1] / MARGIN]
    if flat:
        room = [min(r, max(MARGIN * r - 2 * LABELS, 0.5 * r)) for r in room]
    view.CameraParallelProjection = 1
    view.CameraParallelScale = size[1] * max(high / room[1], wide / room[0])
    aside = (1.0 - FILLED) * view.CameraParallelScale * size[0] / size[1]
    far = 3.0 * math.hypot(*half) or 1.0
    focus = [m + aside * r for m, r in zip(middle, right, strict=True)]
    view.CameraFocalPoint = focus
    view.CameraPosition = [m + far * t for m, t in zip(focus, towards, strict=True)]
    view.CameraViewUp = list(up)
    if flat:
        line = bounds[2] == bounds[3]
        if line:
            bounds = [*bounds[:2], -0.1 * half[0], 0.1 * half[0], *bounds[4:]]
        grid = view.AxesGrid
        grid.Visibility = 1
        grid.UseCustomBounds, grid.CustomBounds = 1, bounds
        grid.ShowGrid = grid.ShowTicks = 0
        grid.AxesToLabel = BELOW if line else LEFT_AND_BELOW
        for axis in "XYZ":
            setattr(grid, f"{axis}Title", _with_unit(axis.lower(), length))
            setattr(grid, f"{axis}TitleColor", INK)
            setattr(grid, f"{axis}LabelColor", INK)
        grid.GridColor = INK


def _direction(camera):
    """Return the unit vector towards the eye."""
    if isinstance(camera, str) and camera not in CAMERAS:
        try:
            camera = [float(part) for part in camera.split(",")]
        except ValueError:
            raise Wrong(
                f"no camera {camera}: one of {', '.join(CAMERAS)}, or a direction X,Y,Z"
            ) from None
    vector = CAMERAS[camera] if isinstance(camera, str) else tuple(camera)
    if len(vector) != 3 or not 0.0 < math.hypot(*vector) < math.inf:
        raise Wrong(f"the camera's direction is three numbers, not all zero: {vector}")
    return _unit(vector)


def _unit(vector):
    length = math.hypot(*vector)
    return tuple(x / length for x in vector)


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _time(reader, view, second):
    """Write the time into the upper left corner."""
    note = simple.AnnotateTimeFilter(Input=reader)
    # Before 5.11, the format was that of printf.
    manager = servermanager.vtkSMProxyManager
    new = (manager.GetVersionMajor(), manager.GetVersionMinor()) >= (5, 11)
    note.Format = f"t = {'{time:.4g}' if new else '%.4g'} {second}".rstrip()
    text = simple.Show(note, view, "TextSourceRepresentation")
    text.WindowLocation = "Upper Left Corner"
    text.Color = INK
    text.FontSize = 20


def save(scene, path, size=(1200, 800)):
    """Save what is shown as a PNG, whole or not at all."""
    _whole(path, lambda part: simple.SaveScreenshot(part, scene.view, ImageResolution=list(size)))


def save_frames(scene, folder, size=(1200, 800)):
    """Save every frame as a PNG, named by its number."""
    os.makedirs(folder, exist_ok=True)
    for index in range(len(scene.times)):
        scene.go(index)
        save(scene, os.path.join(folder, f"frame-{index:06d}.png"), size)


def save_movie(scene, path, size=(1200, 800), rate=15):
    """Save all frames as a movie; the ending says which kind."""
    kind = _movie(path)
    animation = simple.GetAnimationScene()
    animation.UpdateAnimationUsingDataTimeSteps()
    animation.PlayMode = "Snap To TimeSteps"
    animation.GoToFirst()
    options = {
        "ImageResolution": [size[0] // 2 * 2, size[1] // 2 * 2],
        "FrameRate": rate,
        "FrameWindow": [0, len(scene.times) - 1],
    }
    try:
        _whole(path, lambda part: simple.SaveAnimation(part, scene.view, **options))
    except RuntimeError:
        raise Wrong(
            f"this ParaView cannot write {kind}: take another of {', '.join(MOVIES)}, or make one "
            "of the pictures of --frames, for instance with ffmpeg"
        ) from None


def _movie(path):
    """Return the ending of a movie's name."""
    kind = os.path.splitext(path)[1].lower()
    if kind not in MOVIES:
        raise Wrong(f"{path}: a movie ends in {', '.join(MOVIES)}; for pictures take --frames")
    return kind


def _whole(path, write):
    """Let a function write a file elsewhere and move it to its place."""
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder):
        raise Wrong(f"{path}: there is no folder {folder}")
    scratch = tempfile.mkdtemp(prefix=".paraview-", dir=folder)
    try:
        part = os.path.join(scratch, os.path.basename(path))
        write(part)
        if not os.path.exists(part) or not os.path.getsize(part):
            raise RuntimeError(f"ParaView has not written {path}")
        os.replace(part, path)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def main():
    """Do what the command line says."""
    parser = argparse.ArgumentParser(
        prog="pvpython in_paraview.py",
        description=__doc__.partition("\n")[0],
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("run", metavar="RUN.out", help="the run directory")
    add("--field", help="von-mises, stress.xx, velocity (its magnitude), ...")
    add("--camera", help=f"{', '.join(CAMERAS)}, or X,Y,Z towards the eye (--camera=-1,-2,1)")
    add("--range", nargs=2, type=float, metavar=("LOW", "HIGH"), help="ends of the colours")
    add("--body", type=int, help="only this body, by its number from 0")
    add("--frame", type=int, default=-1, help="frame of the picture")
    add("--scale", type=float, default=1.0, help="radius over half the side of a particle")
    add("--size", default="1200x800", metavar="WxH", help="pixels")
    add("--palette", default="Viridis (matplotlib)", help="one of ParaView's colour maps")
    add("-o", "--output", metavar="FILE.png", help="the picture; named by run and field if omitted")
    add("--frames", metavar="DIR", help="a PNG for each frame, into this folder")
    add("--movie", metavar="FILE", help=f"a movie: {', '.join(MOVIES)}")
    add("--rate", type=int, default=15, help="frames a second of the movie")
    args = parser.parse_args()
    pixels = re.fullmatch(r"(\d{2,5})x(\d{2,5})", args.size)
    if not pixels:
        parser.error(f"--size {args.size}: such as 1200x800")
    size = int(pixels[1]), int(pixels[2])
    if args.output and not args.output.lower().endswith(".png"):
        parser.error(f"-o {args.output}: the name must end in .png")
    try:
        if args.movie:
            _movie(args.movie)
        scene = show(
            args.run, args.field, args.camera, args.range, args.body, args.scale, size, args.palette
        )
        scene.go(args.frame)
        if args.output or not (args.frames or args.movie):
            name = os.path.basename(os.path.abspath(args.run))
            name = name[:-4] if name.endswith(".out") else name
            output = args.output or f"{name}-{scene.field}.png"
            save(scene, output, size)
            print(f"wrote {output}")
        if args.frames:
            save_frames(scene, args.frames, size)
            print(f"wrote {len(scene.times)} pictures into {args.frames}")
        if args.movie:
            save_movie(scene, args.movie, size, args.rate)
            print(f"wrote {args.movie}")
    except Wrong as error:
        print(f"in_paraview.py: {error}", file=sys.stderr, flush=True)
        os._exit(2)  # with a window open, the usual way out crashes in the graphics driver


# In ParaView's own shell there is no command line: the functions are then there to be called.
if os.path.abspath(sys.argv[0] if sys.argv else "") == os.path.abspath(
    globals().get("__file__", "-")
):
    main()
else:
    print('Now, for instance: show("/path/to/RUN.out", field="von-mises")')
