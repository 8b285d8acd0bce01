"""Bodies of meshes meet by their surfaces also where a run goes on, or in a later stage."""

import json

import numpy as np
import pytest
from run_files import digests, go_back
from scenes import SOFT, box, scene

import pgimp
from pgimp.mpi.comm import Serial

pytestmark = pytest.mark.slow(40)

OPTIONS = {"comm": Serial(), "quiet": True}
#: A square on its corner, of two triangles.
MESH = """\
$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 5.0 6.0 0.0
2 7.0 8.0 0.0
3 5.0 10.0 0.0
4 3.0 8.0 0.0
$EndNodes
$Elements
2
1 2 2 0 1 1 2 4
2 2 2 0 1 2 3 4
$EndElements
"""


def thrown(folder, *stages):
    """A case file with a mesh that is thrown at a box, and meets it from 0.3 on."""
    (folder / "square.msh").write_text(MESH)
    square = {"material": "soft", "region": {"mesh": {"file": "square.msh"}}}
    square |= {"velocity": [0.0, -3.0]}
    bodies = {"square": square, "low": box([2.1, 2.2], [8.0, 5.1])}
    bodies = {name: body | {"formulation": "total-lagrangian"} for name, body in bodies.items()}
    case = scene(2, bodies, cells=[11, 12], materials={"soft": SOFT}, end=0.6,
                 step={"courant": 0.3}, contact=[{"bodies": "all"}],
                 history={"every": {"steps": 1}}, output={"every": 0.2},
                 checkpoint={"every": {"steps": 3}, "keep": 50})  # fmt: skip
    if stages:
        case["time"] |= {"end": 0.2, "stages": [*stages]}
    path = folder / "case.yaml"
    path.write_text(json.dumps(case))
    return path


def test_a_mesh_meets_others_after_a_run_goes_on_and_in_a_later_stage(tmp_path):
    """It had no surface there any more: both bodies went through each other without a word."""
    alone = pgimp.run(thrown(tmp_path), output=tmp_path / "alone", **OPTIONS)
    impulse = alone.history["contact.all.normal-impulse"]
    assert impulse[-1] > 5.0
    stage = {"name": "later", "end": 0.6, "history": {"every": {"steps": 2}}}
    later = pgimp.run(thrown(tmp_path, stage), output=tmp_path / "stage", **OPTIONS)
    assert later.history["contact.all.normal-impulse"][-1] == pytest.approx(impulse[-1], rel=1e-3)
    path = thrown(tmp_path)
    kept = digests(alone.path)
    go_back(alone.path, 0.3)
    resumed = pgimp.run(path, output=alone.path, resume=True, **OPTIONS)
    assert digests(resumed.path) == kept
    assert np.array_equal(resumed.history["contact.all.normal-impulse"], impulse)
