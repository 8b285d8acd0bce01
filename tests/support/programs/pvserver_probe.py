"""Run by pvpython: what each process of a pvserver has of a frame: PORT FRAME FILE.npz."""

import sys

import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

port, frame, target = sys.argv[1:]
simple.Connect("localhost", int(port))
reader = simple.VTKHDFReader(FileName=[frame])
reader.UpdatePipeline()
values = {}
for process in range(servermanager.ActiveConnection.GetNumberOfDataPartitions()):
    grid = servermanager.Fetch(reader, process)
    data = grid.GetPointData()
    found = [data.GetArray(index) for index in range(data.GetNumberOfArrays())]
    values |= {f"{process}/{array.GetName()}": vtk_to_numpy(array).copy() for array in found}
    values[f"{process}/position"] = vtk_to_numpy(grid.GetPoints().GetData()).copy()
np.savez(target, **values)
