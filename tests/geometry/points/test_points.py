"""Bodies from files of particles: what is in the file is what runs; refusals with the row."""

from types import SimpleNamespace

import numpy as np
import pytest
from clouds import affine, cloud, points
from meshes import case
from point_files import write_csv, write_hdf5
from scenes import field, start, write_case

from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.clouds import overlap
from pgimp.scene.bodies.counts import count_all
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.geometry import share


@pytest.mark.parametrize("ending", ["csv", "h5"])
def test_particles_are_those_of_the_file(tmp_path, ending):
    data = cloud()
    (write_csv if ending == "csv" else write_hdf5)(tmp_path / f"p.{ending}", data)
    sim = start(case(points(tmp_path / f"p.{ending}"), dimension=2))
    assert sim.count == 60
    assert (field(sim, "x") == data["position"]).all()
    np.testing.assert_allclose(field(sim, "V"), data["volume"], rtol=1e-15)
    assert (field(sim, "v") == data["velocity"]).all()
    np.testing.assert_allclose(field(sim, "m"), data["volume"], rtol=1e-15)


def test_the_case_gives_the_velocity_that_the_file_leaves_out(tmp_path):
    data = cloud()
    del data["velocity"]
    write_csv(tmp_path / "p.csv", data)
    model = case(points(tmp_path / "p.csv"), dimension=2)
    model["bodies"]["body"]["velocity"] = {"rotation": {"about": [0.1, 0.0], "rate": 2.0}}
    x = data["position"]
    expected = 2.0 * np.stack([-x[:, 1], x[:, 0] - 0.1], axis=1)
    np.testing.assert_allclose(field(start(model), "v"), expected, atol=1e-14)


def test_a_stress_is_for_materials_that_carry_it(tmp_path):
    data = cloud() | {"stress": np.arange(360.0).reshape(60, 6) * [1, 1, 1, 1, 0, 0]}
    write_hdf5(tmp_path / "p.h5", data)
    model = case(points(tmp_path / "p.h5"), dimension=2)
    with pytest.raises(CaseError, match="follows from the deformation alone"):
        start(model)
    model["materials"]["soft"] = {"model": "hooke", "young": 100.0, "poisson": 0.3, "density": 1.0}
    sim = start(model)
    np.testing.assert_array_equal(field(sim, "sigma"), data["stress"][:, :4])


def test_a_mean_stress_that_the_volume_gives_is_refused(tmp_path):
    """A metal's pressure follows from J: it keeps the deviator of a file, and no pressure."""
    stress = np.tile([3.0, 1.0, 2.0, 0.5, 0.0, 0.0], (60, 1))
    write_hdf5(tmp_path / "p.h5", cloud() | {"stress": stress})
    model = case(points(tmp_path / "p.h5"), dimension=2)
    steel = {"model": "von-mises", "young": 100.0, "poisson": 0.3, "density": 1.0}
    model["materials"]["soft"] = steel | {"yield-stress": 50.0}
    with pytest.raises(CaseError, match="a mean stress of 2, but the pressure of 'von-mises'"):
        start(model)
    write_hdf5(tmp_path / "p.h5", cloud() | {"stress": stress - [2.0, 2.0, 2.0, 0.0, 0.0, 0.0]})
    sim = start(model)
    sim.particles.v[:] = 0.0
    kept = field(sim, "sigma")[:, [0, 3]]
    for volumes in (sim.particles.V, sim.particles.V0):  # so small that forces move nothing
        volumes *= 1e-9
    sim.advance()
    np.testing.assert_allclose(field(sim, "sigma")[:, [0, 3]], kept, rtol=1e-6)


@pytest.mark.parametrize("model", ["von-mises", "bingham", "mu-i"])
def test_a_mean_stress_is_refused_by_check_as_by_a_run(tmp_path, capsys, model):
    """With the line of the first particle that has one; rounding is none."""
    laws = {
        "von-mises": {"young": 100.0, "poisson": 0.3, "yield-stress": 50.0},
        "bingham": {"bulk": 100.0, "shear": 50.0, "yield-stress": 1.0, "shear-viscosity": 1.0},
        "mu-i": {
            "young": 100.0, "poisson": 0.3, "mu-s": 0.4, "mu-2": 0.6, "i0": 0.3, "grain": 0.01,
            "grain-density": 2.0,
        },
    }  # fmt: skip
    data = cloud(20)
    stress = np.tile([[2.0], [1.0], [-3.0], [0.5]], 20)
    stress[0, 5] += 1e-10
    stress[2, 7] += 3.0
    columns = dict(zip(("xx", "yy", "zz", "xy"), stress, strict=True))
    write_csv(tmp_path / "p.csv", data, **{f"stress-{k}": v for k, v in columns.items()})
    made = case(points("p.csv"), dimension=2)
    made["materials"]["soft"] = laws[model] | {"model": model, "density": 1.0}
    write_case(tmp_path / "p.yaml", made)
    said = []
    for words in (["check"], ["-o", str(tmp_path / "out")]):
        assert main([*words, str(tmp_path / "p.yaml")]) == 2
        said.append(capsys.readouterr().err)
    assert said[0] == said[1]
    x, y = data["position"][7]
    assert f"the particle at ({x:.6g}, {y:.6g}), line 11 of " in said[0]
    assert f"p.csv, has a mean stress of 1, but the pressure of '{model}'" in said[0]


@pytest.mark.parametrize(
    ("law", "state"),
    [
        ({"model": "von-mises", "yield-stress": 50.0, "young": 9e2, "poisson": 0.3},
         "plastic-strain"),
        ({"model": "ideal-gas", "gamma": 1.4, "energy": 9.0}, "internal-energy"),
        ({"model": "cam-clay", "m": 1.2, "lambda": 0.2, "kappa": 0.05, "void-ratio": 1.0,
          "shear": 30.0, "preconsolidation": 2.0}, "preconsolidation"),
    ],
)  # fmt: skip
def test_a_state_that_no_particle_can_have_is_refused_with_its_line(tmp_path, law, state):
    data = cloud(20)
    values = np.linspace(3.0, -0.5, 20)
    model = case(points(tmp_path / "p.csv"), dimension=2)
    model["materials"]["soft"] = law | {"density": 1.0}
    write_csv(tmp_path / "p.csv", data, **{state: values})
    line = 4 + int(np.argmax(values < 0.0))  # after a remark, the names and an empty line
    with pytest.raises(CaseError, match=rf"line {line} of .*, has a {state} of -0\.13"):
        start(model)
    write_csv(tmp_path / "p.csv", data, **{state: np.abs(values)})
    start(model)


def two(first, second):
    """A case of two bodies."""
    found = case(first, dimension=2)
    found["bodies"]["other"] = found["bodies"]["body"] | {"region": second}
    return found


def test_particles_in_another_body_are_refused(tmp_path):
    """One that is deeper in a body than a quarter of a box, 0.25; not one that touches it."""
    box = {"box": {"min": [0.0, -1.0], "max": [1.5, 1.5]}}
    data = {"position": np.array([[-0.2, 0.0], [0.06, 0.3]]), "volume": np.full(2, 0.05)}
    write_csv(tmp_path / "p.csv", data)
    assert start(two(box, points(tmp_path / "p.csv"))).count == 62
    data["position"][1, 0] = 0.07
    write_csv(tmp_path / "p.csv", data)
    cloud_of = points(tmp_path / "p.csv")
    for regions, name in (((box, cloud_of), "body"), ((cloud_of, box), "other")):
        with pytest.raises(
            CaseError, match=rf"\(line 5 of .* lies in '{name}': .* overlap"
        ) as error:
            start(two(*regions))
        assert "bodies.other.region: the particle at (0.07, 0.3)" in str(error.value)


@pytest.mark.parametrize("block", [1, 7])
def test_a_body_of_many_parts_is_looked_at_in_blocks_and_samples(tmp_path, monkeypatch, block):
    """Every third of 60 particles of a region of two parts, in blocks."""
    monkeypatch.setattr(overlap, "_BLOCK", 2 * block)
    monkeypatch.setattr(overlap, "_LOOKS", 50)
    half = {"box": {"min": [-2.0, -2.0], "max": [2.0, 0.0]}}
    parts = {"union": [half, {"box": {"min": [-2.0, 0.0], "max": [0.0, 2.0]}}]}
    data = cloud()
    data["position"] = np.stack([np.linspace(0.5, 1.5, 60), np.linspace(1.5, 0.5, 60)], axis=1)
    for row, message in ((3, "row 3 "), (4, "")):
        data["position"][row, 1] = -1.0
        write_hdf5(tmp_path / "p.h5", data)
        if message:
            with pytest.raises(CaseError, match=f"{message}.* lies in 'other'"):
                counted(two(points(tmp_path / "p.h5"), parts), 3)
        else:
            assert counted(two(points(tmp_path / "p.h5"), parts), 3) > 60
        data["position"][row, 1] = 1.0


@pytest.mark.parametrize("ranks", [1, 2, 5, 16])
def test_particles_of_two_files_at_nearly_the_same_place_are_refused(tmp_path, ranks):
    """Wherever the pair is, by the definition; and any number of ranks names the same one."""
    rng = np.random.default_rng(8)
    places = np.stack(np.meshgrid(*[np.arange(-1.9, 2.0, 0.2)] * 2), axis=-1).reshape(-1, 2)
    places += rng.uniform(-0.05, 0.05, places.shape)
    volume = np.full(len(places), 0.04)
    write_hdf5(tmp_path / "one.h5", {"position": places[::2], "volume": volume[::2]})
    model = two(points(tmp_path / "one.h5"), points(tmp_path / "two.h5"))
    limit = 0.1 * 0.2  # of the particle's size, which is less than that of a box, 0.25
    for _ in range(20):
        there = places[1::2].copy()
        rows, turn = rng.choice(len(there), 3, False), rng.uniform(0.0, 2.0 * np.pi, 3)
        targets = rng.choice(len(places) // 2, 3, False)
        way = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        there[rows] = places[::2][targets] + limit * np.array([[0.99], [0.3], [1.01]]) * way
        write_hdf5(tmp_path / "two.h5", {"position": there, "volume": volume[1::2]})
        number = min(targets[:2], key=lambda i: tuple(places[::2][i]))
        with pytest.raises(
            CaseError, match=r"bodies\.other\.region: two particles .* overlap"
        ) as e:
            counted(model, ranks)
        assert f"row {number} (from 0) of {tmp_path / 'one.h5'}" in str(e.value)
        there[rows[:2]] = places[1::2][rows[:2]]
        write_hdf5(tmp_path / "two.h5", {"position": there, "volume": volume[1::2]})
        assert counted(model, ranks) == len(places)


@pytest.mark.parametrize("ranks", [1, 2, 7])
@pytest.mark.parametrize("ending", ["csv", "h5"])
def test_particles_at_one_place_are_refused_with_their_rows(tmp_path, ranks, ending):
    """To a millionth of a box, 0.25, in one file; a little more apart they are anybody's own."""
    data = cloud(300)
    data["position"][:, 0] = np.sort(data["position"][:, 0])
    write = write_csv if ending == "csv" else write_hdf5
    path = tmp_path / f"p.{ending}"
    rows = [120, *range(130, 148), 299]
    place = data["position"][120].copy()
    data["position"][rows] = place + np.linspace(0.0, 1e-7, 20)[:, None]
    data["position"][[250, 280]] = data["position"][200]  # farther along x
    write(path, data)
    words = ["row {} (from 0)".format, lambda row: f"line {row + 4}"][ending == "csv"]
    named = ", ".join(words(row) for row in rows[:10])
    with pytest.raises(CaseError) as error:
        counted(case(points(path), dimension=2), ranks)
    assert (
        f"bodies.body.region: 20 particles of {path} are at "
        f"({place[0]:.6g}, {place[1]:.6g}): {named} and 10 more; leave all but one out"
    ) in str(error.value)
    data["position"][rows] = place + np.linspace(0.0, 1e-5, 20)[:, None]
    data["position"][[250, 280]] += [[0.0, 1e-6], [1e-6, 0.0]]
    write(path, data)
    assert counted(case(points(path), dimension=2), ranks) == 300


def counted(model, ranks):
    """Number of particles, as so many ranks count them."""
    model = Case.model_validate(model)
    share(model, Serial())
    lattice = Lattice(model)
    everything = [counts_of(lattice, rank, ranks) for rank in range(ranks)]
    gathered = SimpleNamespace(rank=0, size=ranks, allgather=lambda mine: everything)
    return count_all(lattice, gathered).counts.sum()


def counts_of(lattice, rank, ranks):
    """The counts that a rank sends to the others."""
    sent = []

    def allgather(mine):
        sent.append(mine)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        count_all(lattice, SimpleNamespace(rank=rank, size=ranks, allgather=allgather))
    return sent[0]


def test_no_part_of_another_region(tmp_path):
    box = {"box": {"min": [0.0, 0.0], "max": [1.0, 1.0]}}
    with pytest.raises(ValueError, match="a body of their own"):
        start(case({"union": [box, points(tmp_path / "p.csv")]}, dimension=2))


@pytest.mark.wide
def test_same_bits_on_ranks(tmp_path, mpirun, python):
    """Particles at any place of a cell: their layers are not those of the lattice's points.

    With gradients of their velocity, from neighbours that other ranks have; and resumed on others.
    """
    write_csv(tmp_path / "p.csv", cloud(400))
    model = affine(points("p.csv"), 2, end=0.1)
    model |= {key: {"every": 0.05} for key in ("output", "history")}
    write_case(tmp_path / "p.yaml", model)
    one = python(["-m", "pgimp", "p.yaml", "-o", "one"], cwd=tmp_path)
    half = ["-m", "pgimp", "p.yaml", "-o", "three", "--set", "time.end=0.05"]
    three = mpirun(3, half, cwd=tmp_path)
    assert one.returncode == three.returncode == 0, one.stderr + three.stderr
    two = mpirun(2, ["-m", "pgimp", "p.yaml", "-o", "three", "--resume"], cwd=tmp_path)
    assert two.returncode == 0 and "resuming from" in two.stdout, two.stderr
    assert main(["compare", str(tmp_path / "one"), str(tmp_path / "three")]) == 0


def test_clay_begins_under_pressure(tmp_path):
    data, pressure = cloud(20), np.linspace(3.0, -0.5, 20)
    clay = {"model": "cam-clay", "m": 1.2, "lambda": 0.2, "kappa": 0.05, "void-ratio": 1.0,
            "shear": 30.0, "preconsolidation": 4.0, "density": 1.0}  # fmt: skip
    model = case(points(tmp_path / "p.csv"), dimension=2)
    model["materials"]["soft"] = clay
    for values in (pressure, np.maximum(pressure, 0.01)):
        stress = {f"stress-{k}": -values for k in ("xx", "yy", "zz")}
        write_csv(tmp_path / "p.csv", data, **stress, **{"stress-xy": 0.0 * values})
        if values.min() < 0.0:
            line = 4 + int(np.argmax(values < 0.0))
            with pytest.raises(CaseError, match=rf"line {line} of .* 0\.132, tension, of which"):
                start(model)
        else:
            start(model)
