"""Reads a run by VTK alone, and compares it with what pgimp reads: vtk_probe.py DIR REFERENCE.npz.

Started by tests, and by scripts/vtk with several versions of VTK, in environments without pgimp.
Prints a line for each difference, and at the end one for the version; ends with 1 if they differ.
"""

import sys
from pathlib import Path

import numpy as np
from vtkmodules.numpy_interface.dataset_adapter import numpy_support
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkIOHDF import vtkHDFReader

arrays_of = numpy_support.vtk_to_numpy
TIMES = vtkStreamingDemandDrivenPipeline.TIME_STEPS()
TIME = vtkStreamingDemandDrivenPipeline.UPDATE_TIME_STEP()


def opened(path):
    """A reader of a file that knows its times and arrays."""
    reader = vtkHDFReader()
    assert reader.CanReadFile(str(path)), f"VTK cannot read {path}"
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    return reader


def leaves(reader):
    """The data sets of what a reader shows now: several parts, or one."""
    shown = reader.GetOutputDataObject(0)
    if not shown.IsA("vtkCompositeDataSet"):
        yield shown
        return
    walk = shown.NewIterator()
    walk.InitTraversal()
    while not walk.IsDoneWithTraversal():
        yield walk.GetCurrentDataObject()
        walk.GoToNextItem()


def arrays(*readers):
    """Points, fields and cells of what readers show now, parts one after the other."""
    found, before = {}, 0
    for grid in (grid for reader in readers for grid in leaves(reader)):
        drawn = vtkGeometryFilter()  # what every picture begins with must not crash
        drawn.SetInputData(grid)
        drawn.Update()
        if grid.GetNumberOfPoints():
            found.setdefault("position", []).append(arrays_of(grid.GetPoints().GetData()).copy())
        for data in (grid.GetPointData(), grid.GetCellData()):
            for index in range(data.GetNumberOfArrays()):
                array = data.GetArray(index)
                found.setdefault(array.GetName(), []).append(arrays_of(array).copy())
        cells = grid.GetNumberOfCells()
        if cells:
            numbers = arrays_of(grid.GetCells().GetConnectivityArray()).copy()
            nodes = grid.GetCell(cells - 1).GetNumberOfPoints()
            found.setdefault("connectivity", []).append(numbers.reshape(cells, nodes) + before)
        before += grid.GetNumberOfPoints()
    return {name: np.concatenate(values) for name, values in found.items()}


def differences(wanted, found, whole=True):
    """What differs in a frame; fields that it does not have must be no numbers, or -1."""
    for name, values in wanted.items():
        if len(values) == 0:
            if len(found.get(name, ())):
                yield f"{name} is not empty"
        elif name not in found:
            yield f"{name} is not there"
        elif name == "connectivity":
            if not np.array_equal(found[name].ravel(), values.ravel()):
                yield "the cells are others"
        elif found[name].shape != values.shape:
            yield f"{name} has the shape {found[name].shape}, not {values.shape}"
        elif not np.array_equal(found[name], values.astype(found[name].dtype), equal_nan=True):
            yield f"{name} has other values"
        elif found[name].dtype.itemsize < values.dtype.itemsize:
            yield f"{name} is rounded"
    for name in found.keys() - wanted.keys():
        values = found[name]
        if whole and not (np.isnan(values) if values.dtype.kind == "f" else values == -1).all():
            yield f"{name} has values that no frame has"


def check(directory, frames):
    """Yield what VTK reads otherwise: frames, the series, its parts on processes, single arrays."""
    for kind in sorted({name.split("-")[0] for name in frames}):
        own = {name: frame for name, frame in frames.items() if name.startswith(kind)}
        series = directory / f"{kind}.vtkhdf"
        reader = opened(series)
        times = [float(frame.pop("time")) for frame in own.values()]
        said = reader.GetOutputInformation(0).Get(TIMES)
        if len(times) > 1 and [float(time) for time in said] != times:
            yield f"{kind}: times {said}, not {times}"
        for time, (name, frame) in zip(times, own.items(), strict=True):
            alone = opened(directory / "frames" / f"{name}.h5")
            alone.Update()
            yield from (f"{name}: {line}" for line in differences(frame, arrays(alone)))
            for count in (1, 2, 3):
                readers = [opened(series) for _ in range(count)]
                for piece, each in enumerate(readers):
                    each.GetOutputInformation(0).Set(TIME, time)
                    each.UpdatePiece(piece, count, 0)
                found, expected = arrays(*readers), dict(frame)
                if count > 1 and "id" in found:
                    order = np.argsort(found["id"])
                    found = {key: values[order] for key, values in found.items()}
                    found["connectivity"] = expected["connectivity"]
                what = f"{name} in {series.name}, {count} processes"
                yield from (f"{what}: {line}" for line in differences(expected, found))
        yield from single(reader, kind, times, list(own.values()))


def single(reader, kind, times, frames):
    """Yield what differs if only one array is read, from the last frame to the first."""
    names = [name for name in frames[0] if name not in ("connectivity", "position")]
    for name in names:
        for chosen in (reader.GetPointDataArraySelection(), reader.GetCellDataArraySelection()):
            chosen.DisableAllArrays()
            if chosen.ArrayExists(name):
                chosen.EnableArray(name)
        for time, frame in zip(times[::-1], frames[::-1], strict=True):
            if name not in frame or len(frame[name]) == 0:
                continue
            reader.UpdateTimeStep(time)
            found = arrays(reader)
            if set(found) != {name, "position", "connectivity"}:
                yield f"{kind}, only {name}: there are {', '.join(found)}"
            for line in differences({name: frame[name]}, found, whole=False):
                yield f"{kind}, only {name} at {time}: {line}"


def main(directory, reference):
    frames = {}
    with np.load(reference) as file:
        for key in file.files:
            name, _, what = key.partition("/")
            frames.setdefault(name, {})[what] = file[key]
    lines = list(check(Path(directory), frames))
    for line in lines:
        print(line)
    print(f"VTK {vtkVersion.GetVTKVersion()}: {len(frames)} frames, {len(lines)} differences")
    return int(bool(lines))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
