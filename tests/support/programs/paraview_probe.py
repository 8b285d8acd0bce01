"""Run by pvpython: what each of ParaView's XDMF readers makes of a file, printed as JSON."""

import json
import sys

from paraview import servermanager, simple

READERS = {
    "XDMF Reader": ("XDMFReader", "FileNames"),
    "Xdmf3 Reader S": ("Xdmf3ReaderS", "FileName"),
    "Xdmf3 Reader T": ("Xdmf3ReaderT", "FileName"),
}


def arrays(source):
    """Return the points and all point arrays of what a source shows now, as nested lists."""
    grid = servermanager.Fetch(source)
    data = grid.GetPointData()
    identity = data.GetGlobalIds()
    found = {"points": [grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())]}
    for index in range(data.GetNumberOfArrays()):
        array = data.GetArray(index)
        found[array.GetName()] = [array.GetTuple(i) for i in range(array.GetNumberOfTuples())]
    return {
        "kind": grid.GetClassName(),
        "cells": grid.GetNumberOfCells(),
        "global ids": identity.GetName() if identity else None,
        "arrays": found,
    }


def probe(reader, body):
    """Return the times of a reader, what it shows at each, and a threshold by body at the last."""
    reader.UpdatePipelineInformation()
    times = reader.TimestepValues
    times = list(times) if hasattr(times, "__len__") else [times]  # a single one is a float
    shown = []
    for time in times:
        reader.UpdatePipeline(time)
        shown.append(arrays(reader))
    threshold = simple.Threshold(Input=reader, Scalars=["POINTS", "body"])
    threshold.LowerThreshold = threshold.UpperThreshold = body
    threshold.UpdatePipeline(times[-1])
    return {"times": times, "shown": shown, "threshold": arrays(threshold)}


path, body = sys.argv[1], float(sys.argv[2])
results = {
    name: probe(getattr(simple, proxy)(**{names: [path]}), body)
    for name, (proxy, names) in READERS.items()
}
print("PROBE" + json.dumps(results))
