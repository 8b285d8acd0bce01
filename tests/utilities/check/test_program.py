"""The program of a step: what `pgimp check -v` says of it, against what a run does."""

import numpy as np
import pytest
from numba.core.registry import CPUDispatcher
from scenes import BAR, box, scene, start
from tiers import wide

from pgimp.case.schema import Case
from pgimp.jit.bound import Bound
from pgimp.kernels.loads.loads import Loads
from pgimp.solver.parts import PARTS
from pgimp.solver.rank import PHASES
from pgimp.utilities.check.program import Watch, meanings_of, report_program, watched

#: The laps of `pgimp.solver.step`, on one rank, and what comes after a step.
LAPS = "contact P2G exchange contact momentum contact momentum P2G G2P migrate migrate order"
ORDER = [*LAPS.split(), "between steps"]


def bar(**parts):
    """A damped bar that gravity pulls, with a grip at its end."""
    end = {"box": {"min": [4.5], "max": [5.5]}}
    return scene(
        1, {"b": box([0.0], [5.0], material="bar")}, cells=[8], step=0.001, materials={"bar": BAR},
        gravity=[0.1], constraints={"grip": {"body": "b", "region": end, "velocity": [0.0]}},
        damping={"mass": 1.0}, **parts,
    )  # fmt: skip


def flowing(**parts):
    """Water between walls that reflect."""
    water = {"model": "newtonian", "density": 1.0, "bulk": 100.0, "shear_viscosity": 0.01}
    walls = {f"{axis}-{end}": "slip" for axis in "xy" for end in ("min", "max")}
    return scene(2, box([0.0, 0.0], [4.0, 4.0]), materials={"soft": water}, boundaries=walls,
                 gravity=[0.0, -1.0], step=0.001, **parts)  # fmt: skip


def mixed(**parts):
    """A body of each configuration."""
    initial = box([1.0], [3.0]) | {"formulation": "total-lagrangian"}
    return scene(1, {"a": initial, "b": box([4.0], [6.0])}, materials={"soft": BAR}, step=0.001,
                 contact=[{"bodies": "all"}], **parts)  # fmt: skip


@pytest.mark.parametrize("made", [bar, wide(flowing), wide(mixed)])
def test_the_program_is_that_of_the_run(made):
    """Phases, parts and loads of the scene; watching changes no bit, and leaves nothing behind."""
    sim, plain, by_bound = start(made()), start(made()), Bound.__call__
    watch = Watch(sim)
    watch.run()
    for _ in range(watch.steps):
        plain.advance()
    for name, values in plain.particles._asdict().items():
        assert getattr(sim.particles, name).tobytes() == values.tobytes(), name
    assert Bound.__call__ is by_bound and "__call__" not in vars(CPUDispatcher)

    rows = watch.ordered()
    assert [watch.phases[n] for n in sorted(watch.phases)] == ORDER
    here = {name for name in PARTS if getattr(plain.rank, name)}
    assert {key[2].split(".")[0] for key, _ in rows if "." in key[2]} - {"contact"} == here
    names = [key[2] for key, _ in rows]
    assert names.index("particles_to_grid") < names.index("update_momentum")
    assert names.index("update_momentum") < names.index("grid_to_particles")
    (found,) = (row for key, row in rows if key[2] == "grid_to_particles")
    loads, has = plain.scene.interaction.loads.at(0.0), set(found.features)
    known = {name for name, value in zip(loads._fields, loads, strict=True) if value != ()}
    assert {name for name in Loads._fields if name in has} == known - {"tractions", "surfaces"}
    for phase in range(len(watch.phases)):
        (whole,) = (row for key, row in rows if key == (phase, "", ""))
        parts = [row for key, row in rows if key[0] == phase and not key[1] and key[2]]
        assert np.sum([row.seconds for row in parts]) <= sum(whole.seconds)
    assert all(row.meaning for _, row in rows)


def test_it_is_printed(capsys):
    """A line for each phase in its order, for kernels and parts, and for what is compiled in."""
    case = Case.model_validate(bar())
    report_program(case, 10)
    lines = capsys.readouterr().out.splitlines()
    assert "72 steps with 10 particles, " in lines[0]
    assert "one comes again where the step comes back to it" in lines[1]
    said = [line.split()[0] for line in lines if line[:2] == "  " != line[2:4]]
    assert said[:13] == [*LAPS.split(), "between"] and set(said[:12]) <= set(PHASES)
    (kernel,) = (line for line in lines if line.strip().startswith("grid_to_particles"))
    assert " ns a particle " in kernel and "Advance particles of a rank" in kernel
    (damping,) = (line for line in lines if line.strip().startswith("damping.add_forces"))
    assert " us " in damping and "forces of damping" in damping
    assert any(line.split()[:2] == ["law", "linear-1d"] for line in lines)


def test_what_settles_or_is_watched_is_said(capsys):
    """A start that comes to rest has steps of its own; `auto` a guard, between steps."""
    case = bar(start={"equilibrate": {}})
    for name in ("constraints", "damping"):
        case.pop(name)
    case["time"]["step"] = {"courant": "auto"}
    case["boundaries"] = {"x-min": "fixed"}
    report_program(Case.model_validate(case), 10)
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    names = [line[0] for line in lines]
    rest = lines.index(next(line for line in lines if line[:4] == ["a", "step", "to", "rest"]))
    assert "watch.look" in names[names.index("between") : rest]
    assert {"damping.add_forces", "relax"} <= set(names[rest:]) - set(names[:rest])


def test_a_run_of_three_steps(capsys):
    """No more are watched; one whose case cannot begin is named."""
    found = watched(Case.model_validate(bar(end=0.003)), 10)
    assert found[0].steps == 3
    assert found[0].rows[(0, "", "")].steps == 3


def test_all_loads_have_a_meaning():
    """What kernels may have is explained beside the records' fields, with a sentence of its own."""
    meanings = meanings_of(Loads)
    assert set(meanings) == set(Loads._fields)
    assert not [name for name, text in meanings.items() if text.startswith("See")]
