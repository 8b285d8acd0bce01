"""Sweeps begin at forces extrapolated from the last two steps, also after a restart."""

import pytest
from run_files import digests
from scenes import SOFT, box, finish, scene, start, write_case

import pgimp
from pgimp.case.schema import Case
from pgimp.errors import DamagedError
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.io.checkpoints.checkpointwriter import write
from pgimp.kernels.contact.surfaces.soft import solve_softly
from pgimp.mpi.comm import Serial
from pgimp.solver.simulation import Simulation


def pressed(end=3.0, **parts):
    """A block that a ram presses on a floor, from rest."""
    block = box([2.0, 0.0], [6.0, 3.0]) | {"formulation": "total-lagrangian"}
    ram = {"rigid": {"velocity": [0.0, -0.1]},
           "region": {"box": {"min": [0.0, 3.0], "max": [8.0, 6.0]}}}  # fmt: skip
    return scene(
        2, {"block": block, "ram": ram}, cells=[8, 8], end=end, step={"courant": 0.3},
        materials={"soft": SOFT | {"young": 1000.0}}, gravity=[0.0, -1.0],
        boundaries={"y-min": {"unilateral": {"friction": 0.3}}},
        contact=[{"bodies": "all", "friction": 0.3}],
    ) | parts  # fmt: skip


def counted(case, cold, steps=60):
    """Sweeps of each step, and the last line of the history; `cold` steps know no last forces."""
    sim = start(case)
    contact, found = sim.rank.contact, []
    call = contact.call

    def note(kernel, *arguments):
        if cold and kernel is solve_softly:
            arguments = *arguments[:2], arguments[2][:0], *arguments[3:]
        result = call(kernel, *arguments)
        found.extend([result] * (kernel is solve_softly))
        return result

    contact.call = note
    for _ in range(steps):
        sim.advance()
    return found, sim.diagnostics()


def test_fewer_sweeps_find_the_same_forces():
    warm, one = counted(pressed(), False)
    cold, other = counted(pressed(), True)
    assert len(warm) == len(cold)
    assert sum(warm[10:]) < 0.75 * sum(cold[10:])
    # Patches give way by half of what the last forces would give, of which the cold know nothing.
    for name in ("contact.all.normal-impulse", "strain-energy"):
        assert one[name] == pytest.approx(other[name], rel=1e-2)


def test_a_resumed_run_begins_at_the_same_forces(tmp_path):
    """An older checkpoint has none: sweeps begin at zero, and end within the tolerance."""
    case = pressed(end=0.5, checkpoint={"every": 0.2, "keep": 9}, output={"every": 0.1})
    write_case(tmp_path / "case.yaml", case)
    run = pgimp.run(tmp_path / "case.yaml", output=tmp_path / "run", quiet=True)
    whole, last = digests(run.path), pgimp.open(run.path).history["kinetic-energy"][-1]
    first, *others = sorted((run.path / "checkpoints").iterdir())
    file, case = CheckpointFile(first), Case.model_validate(case)
    rows = {name: file.read(name, 0, file.count) for name in file.rows}
    stored = {name: file.read_whole(name) for name in file.whole}
    forces = stored.pop("contact-forces")
    sim = Simulation(case, Serial(), file)
    assert (sim.rank.contact.kept_forces == forces).all()
    changed = tmp_path / first.name
    write(changed, Serial(), file.about, rows, stored)
    older = Simulation(case, Serial(), CheckpointFile(changed))
    assert not older.rank.contact.kept_forces.size
    assert finish(older).diagnostics()["kinetic-energy"] == pytest.approx(last, rel=1e-2)
    for change in (forces[:, 1:], forces + 0.5, forces * 1e30):
        write(changed, Serial(), file.about, rows, stored | {"contact-forces": change})
        with pytest.raises(DamagedError, match=r"contact.forces|forces of contact"):
            Simulation(case, Serial(), CheckpointFile(changed))
    for path in others:
        path.unlink()
    info = run.path / "run.json"
    info.write_text(info.read_text().replace('"state": "done"', '"state": "running"'))
    pgimp.run(tmp_path / "case.yaml", output=run.path, resume=True, quiet=True)
    assert digests(run.path) == whole
