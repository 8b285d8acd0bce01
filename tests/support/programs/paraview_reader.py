"""An XDMF file as ParaView's readers see it."""

import json

from processes import PROGRAMS

READERS = ("XDMF Reader", "Xdmf3 Reader S", "Xdmf3 Reader T")


def probe(pvpython, path, body):
    """Let pvpython open an XDMF file."""
    run = pvpython(PROGRAMS / "paraview_probe.py", path, body)
    lines = [line for line in run.stdout.splitlines() if line.startswith("PROBE")]
    assert lines, run.stdout + run.stderr
    return json.loads(lines[0].removeprefix("PROBE"))
