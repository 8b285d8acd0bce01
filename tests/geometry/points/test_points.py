"""Bodies from files of particles: what is in the file is what runs; refusals with the row."""

import os
import time
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from meshes import case
from point_files import write_csv, write_hdf5
from scenes import field, start, write_case

import pgimp
from pgimp.case.schema import Case
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene import overlap
from pgimp.scene.counts import count_all
from pgimp.scene.geometry import share
from pgimp.scene.lattice import Lattice


def cloud(n=60, dimension=2):
    rng = np.random.default_rng(4)
    return {
        "position": rng.uniform(-1.5, 1.5, (n, dimension)),
        "volume": rng.uniform(0.01, 0.06, n),
        "velocity": rng.uniform(-0.1, 0.1, (n, dimension)),
    }


def points(path):
    return {"points": {"file": str(path)}}


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


def damaged():
    good = "x,y,volume\n0,0,0.1\n"
    return {
        "nan.csv": (good + "nan,0,0.1\n", "line 3: the position is not finite"),
        "inf.csv": (good + "0,0,inf\n", "line 3: the volume is not finite"),
        "zero.csv": (good + "\n0,1,0\n", "line 4: the volume must be above zero, is 0"),
        "word.csv": (good + "0,one,0.1\n", "line 3, column y: 'one' is no number"),
        "short.csv": (good + "0,0.1\n", "line 3: 2 values, expected 3"),
        "head.csv": ("0,0,0.1\n", "missing x, y, volume; unknown '0', '0.1'; '0' more than once"),
        "key.csv": ("x,y,volume,mass\n0,0,1,1\n", "unknown 'mass'. Expected x,y,volume and, if"),
        "half.csv": ("x,y,volume,velocity-x\n0,0,1,1\n", "columns: missing velocity-y. Expected"),
        "all.csv": (
            "# by a test\nx,z,velocity-y,stress-xx,stress-yz,\x1b[31mred,x\n",
            r"line 2, .*: missing y, volume, velocity-x, stress-yy, stress-zz, stress-xy; z, "
            r"stress-yz, which a case in 2D does not have: leave them out; unknown "
            r"'\\x1b\[31mred'; 'x' more than once\. Expected x,y,volume and, if wanted, "
            r"velocity-x,velocity-y; stress-xx,stress-yy,stress-zz,stress-xy; velocity-grad",
        ),
        "escape.csv": (
            good + "0,\x1b]0;title\x07,0.1\n",
            r"line 3, column y: '\\x1b\]0;title\\x07' is no",
        ),
        "none.csv": ("x,y,volume\n", "holds no particle"),
        "out.csv": (
            good + "\n0,7,0.1\n",
            r"reaches 5 beyond the domain at y-max: to 7 with the particle at \(0, 7\), line 4 of ",
        ),
        "noise.csv": (np.random.default_rng(2).bytes(3000), "cannot"),
        "noise.h5": (np.random.default_rng(2).bytes(3000), "cannot read the particles"),
        "empty.h5": (b"", "it is empty"),
        "what.dat": (good, "must end in .h5, .hdf5 or .csv"),
    }


@pytest.mark.parametrize("name", damaged())
def test_damaged_files_are_refused(tmp_path, name):
    text, message = damaged()[name]
    (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(CaseError, match=message):
        start(case(points(tmp_path / name), dimension=2))


def test_a_row_outside_of_the_grid_is_named(tmp_path):
    data = cloud()
    data["position"][41] = [-2.5, 1.0]
    write_hdf5(tmp_path / "p.h5", data)
    with pytest.raises(CaseError, match=r"x-min: .* \(-2\.5, 1\), row 41 \(from 0\) of ") as error:
        start(case(points(tmp_path / "p.h5"), dimension=2))
    assert "unit" not in str(error.value)
    data["position"] *= 1000.0
    data["position"][41] *= 0.5  # in 4 x 4
    write_hdf5(tmp_path / "p.h5", data)
    with pytest.raises(
        CaseError, match=r"as mm for m\? Times 0\.001, and volumes times 1e-06, its"
    ):
        start(case(points(tmp_path / "p.h5"), dimension=2))


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


def test_wrong_datasets_are_refused(tmp_path):
    for change, message in (
        ({"volume": None}, "no dataset 'volume'"),
        ({"volume": np.ones(59)}, "59 rows of volume, but 60"),
        ({"position": np.ones((60, 4))}, "'position' has the shape \\(60, 4\\)"),
        ({"position": np.ones((60, 3))}, "row 0 \\(from 0\\): position has a part along"),
        (
            {"stress": np.eye(60, 6)[::-1]},
            r"row 54 \(from 0\): stress has a part along a direction that the case, 2D",
        ),
        (
            {"velocity-gradient": np.ones((60, 9))},
            r"row 0 \(from 0\): velocity-gradient has a part along a direction",
        ),
        ({"velocity-gradient": np.ones((60, 6))}, "'velocity-gradient' has the shape"),
        ({"velocity-gradient": np.ones((60, 4)), "velocity": None}, "gradient, but no velocity"),
        ({"volume": np.full(60, b"x")}, "'volume' is no dataset of numbers"),
    ):
        data = {k: v for k, v in (cloud() | change).items() if v is not None}
        write_hdf5(tmp_path / "p.h5", data)
        with pytest.raises(CaseError, match=message):
            start(case(points(tmp_path / "p.h5"), dimension=2))


def test_a_promise_of_more_particles_than_memory_holds_is_refused_at_once(tmp_path):
    """Also where reading would find nothing wrong for hours: all rows are sound."""
    with h5py.File(tmp_path / "p.h5", "w") as file:
        more = {"chunks": True, "compression": "gzip", "fillvalue": 1.0}
        file.create_dataset("position", (10**12, 2), "f8", **more)
        file.create_dataset("volume", (10**12,), "f8", **more)
    message = r"cannot use .*p\.h5: it claims 1,000,000,000,000 particles, but the memory that is"
    begin = time.perf_counter()
    with pytest.raises(CaseError, match=message):
        start(case(points(tmp_path / "p.h5"), dimension=2))
    assert time.perf_counter() - begin < 30.0


def linked():
    """What makes of an HDF5 file, by a name, one whose velocity is elsewhere; and the refusal."""

    def replaced(file, link):
        del file["velocity"]
        file["velocity"] = link

    def raw(file, name):
        del file["velocity"]
        file.create_dataset("velocity", (60, 2), "f8", external=[(name, 0, 960)])

    def view(file):
        layout = h5py.VirtualLayout((60, 2), "f8")
        layout[:] = h5py.VirtualSource("fifo", "velocity", (60, 2))
        del file["velocity"]
        file.create_virtual_dataset("velocity", layout)

    def through(file):
        file["other"] = h5py.ExternalLink("fifo", "/")
        replaced(file, h5py.SoftLink("/other/velocity"))

    def circle(file):
        file["there"] = h5py.SoftLink("/velocity")
        replaced(file, h5py.SoftLink("/there"))

    return {
        "external": (
            lambda f: replaced(f, h5py.ExternalLink("fi\x1bfo", "velocity")),
            r"'velocity' is a link into the file fi\\x1bfo; copy",
        ),
        "nowhere": (
            lambda f: replaced(f, h5py.SoftLink("/nowhere")),
            "'velocity' is a link to nowhere",
        ),
        "circle": (circle, "'velocity' is a link that leads in a circle"),
        "through": (through, "'velocity' is a link into the file fifo"),
        "raw": (lambda f: raw(f, "fifo"), "the data of 'velocity' are in another file, fifo"),
        "device": (lambda f: raw(f, "/dev/zero"), "are in another file, /dev/zero"),
        "view": (view, "'velocity' is a view of other datasets"),
    }


@pytest.mark.parametrize("kind", linked())
def test_data_that_lie_in_other_files_are_refused_and_not_opened(tmp_path, monkeypatch, kind):
    """Nobody writes to the pipe: whoever opened it would wait for ever."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("fifo")
    os.mkfifo("fi\x1bfo")
    write_hdf5(tmp_path / "p.h5", cloud())
    change, message = linked()[kind]
    with h5py.File("p.h5", "r+") as file:
        change(file)
    with pytest.raises(CaseError, match=message):
        start(case(points(tmp_path / "p.h5"), dimension=2))


def test_links_within_the_file_are_followed(tmp_path):
    data = cloud()
    write_hdf5(tmp_path / "p.h5", data)
    with h5py.File(tmp_path / "p.h5", "r+") as file:
        file["a/b/speeds"] = file["velocity"]
        del file["velocity"]
        file["velocity"] = h5py.SoftLink("a/link")
        file["a/link"] = h5py.SoftLink("b/./speeds")
    sim = start(case(points(tmp_path / "p.h5"), dimension=2))
    assert (field(sim, "v") == data["velocity"]).all()


@pytest.mark.parametrize("ending", ["csv", "h5"])
@pytest.mark.parametrize("kind", ["fifo", "device", "folder", "dangling"])
def test_what_is_no_file_is_refused_at_once(tmp_path, kind, ending):
    path = tmp_path / f"p.{ending}"
    if kind == "fifo":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/zero" if kind == "device" else "nowhere")
    with pytest.raises(CaseError, match=r"cannot read the particles .*p\.(csv|h5): "):
        start(case(points(path), dimension=2))


def test_no_part_of_another_region(tmp_path):
    box = {"box": {"min": [0.0, 0.0], "max": [1.0, 1.0]}}
    with pytest.raises(ValueError, match="a body of their own"):
        start(case({"union": [box, points(tmp_path / "p.csv")]}, dimension=2))


# -- gradients of the velocity, for method.affine


def affine(region, D, **parts):
    found = case(region, dimension=D, **parts)
    found["method"]["affine"] = True
    return found


def scattered(D, seed, n=9, spread=0.3):
    """Particles near the points of a lattice in the square from -1.5 to 1.5, and a linear field."""
    rng = np.random.default_rng(seed)
    along = (np.arange(n) + 0.5) / n * 3.0 - 1.5
    x = np.stack(np.meshgrid(*[along] * D), axis=-1).reshape(-1, D)
    x = rng.permutation(x + rng.uniform(-spread, spread, x.shape) * 3.0 / n)
    gradient, constant = rng.normal(size=(D, D)), rng.normal(size=D)
    volume = np.full(len(x), (3.0 / n) ** D)
    return {"position": x, "volume": volume, "velocity": constant + x @ gradient.T}, gradient


@pytest.mark.parametrize("ending", ["csv", "h5"])
@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("n", [5, 9, 14])
def test_the_gradient_of_a_linear_field_is_exact(tmp_path, D, n, ending):
    """Of particles coarser than the lattice's (0.25) and finer; at the surface too."""
    data, gradient = scattered(D, D, n)
    (write_csv if ending == "csv" else write_hdf5)(tmp_path / f"p.{ending}", data)
    sim = start(affine(points(tmp_path / f"p.{ending}"), D))
    L = field(sim, "L").reshape(-1, D, D)
    assert len(L) == len(data["volume"])
    assert np.abs(L - gradient).max() < 1e-12


def test_a_smooth_field_has_its_gradient_by_second_order(tmp_path):
    """Against the derivative: 4 times less for half the distance in the interior."""
    errors = []
    for n in (10, 20):
        data, _ = scattered(2, 3, n, 0.0)
        x, y = data["position"].T
        data["velocity"] = np.stack([np.sin(x + 2 * y), x * x * y], axis=1)
        write_hdf5(tmp_path / "p.h5", data)
        L = field(start(affine(points(tmp_path / "p.h5"), 2, cell=6.0 / n / 1.5)), "L")
        wave = np.cos(x + 2 * y)
        exact = np.stack([wave, 2 * wave, 2 * x * y, x * x], axis=1)
        interior = (np.abs(data["position"]) < 1.0).all(axis=1)
        errors.append(np.abs(L - exact)[interior].max())
    assert errors[1] < 0.35 * errors[0] and errors[0] < 0.3


def test_few_neighbours_or_neighbours_on_a_line_give_the_solution_of_least_norm(tmp_path):
    gradient = np.array([[1.0, 2.0, 0.5], [-0.5, 0.3, 0.7], [0.2, 0.4, -0.9]])
    line = np.array([0.6, 0.0, 0.8])
    groups = {
        "line": (np.arange(4)[:, None] * 0.2 * line - 1.0, np.outer(line, line)),
        "pair": (np.array([[1.0, 1.0, -1.0], [1.0, 1.2, -1.0]]), np.diag([0.0, 1.0, 0.0])),
        "plane": (
            np.array([[0.2 * i, 0.2 * j, 1.5] for i in range(4) for j in range(3)]),
            np.diag([1.0, 1.0, 0.0]),
        ),
        "alone": (np.array([[-1.5, 1.5, -1.5]]), np.zeros((3, 3))),
    }
    x = np.concatenate([place for place, _ in groups.values()])
    expected = np.concatenate(
        [np.tile(gradient @ within, (len(place), 1, 1)) for place, within in groups.values()]
    )
    data = {"position": x, "volume": np.full(len(x), 0.25**3), "velocity": x @ gradient.T}
    write_hdf5(tmp_path / "p.h5", data)
    L = field(start(affine(points(tmp_path / "p.h5"), 3)), "L").reshape(-1, 3, 3)
    np.testing.assert_allclose(L, expected, atol=1e-12)


@pytest.mark.parametrize("ending", ["csv", "h5"])
@pytest.mark.parametrize("D", [1, 2, 3])
def test_a_gradient_in_the_file_is_taken_as_it_is(tmp_path, D, ending):
    data, _ = scattered(D, D)
    given = np.random.default_rng(3).normal(size=(len(data["volume"]), D, D))
    if ending == "csv":
        names = [f"velocity-gradient-{a}{b}" for a in "xyz"[:D] for b in "xyz"[:D]]
        write_csv(
            tmp_path / "p.csv",
            data,
            **dict(zip(names, given.reshape(len(given), -1).T, strict=True)),
        )
    else:
        padded = np.zeros((len(given), 3, 3))
        padded[:, :D, :D] = given
        write_hdf5(tmp_path / "p.h5", data | {"velocity-gradient": padded})
    sim = start(affine(points(tmp_path / f"p.{ending}"), D))
    assert (field(sim, "L") == given.reshape(len(given), -1)).all()
    assert start(case(points(tmp_path / f"p.{ending}"), dimension=D)).count == len(given)


def test_a_frame_of_a_spinning_disk_goes_on_spinning(tmp_path):
    """A frame as a cloud has the gradients that the other run has, but for its surface."""
    disk = {"ball": {"centre": [0.1, 0.0], "radius": 1.2}}
    spin = affine(disk, 2, end=0.02, output={"fields": ["velocity"]})
    spin["bodies"]["body"] |= {
        "surface": "whole",
        "velocity": {"rotation": {"about": [0.1, 0.0], "rate": 2.0}},
    }
    sim = start(spin)
    pgimp.run(spin, comm=Serial(), output=tmp_path / "spin", quiet=True)
    expected = np.tile([0.0, -2.0, 2.0, 0.0], (sim.count, 1))
    np.testing.assert_allclose(field(sim, "L"), expected, atol=1e-12)
    frames = sorted((tmp_path / "spin/frames").glob("particles-*.h5"))
    first = start(affine(points(frames[0]), 2))
    np.testing.assert_allclose(field(first, "L"), expected, atol=1e-12)
    assert first.count == sim.count
    while not sim.finished:
        sim.advance()
    last = start(affine(points(frames[-1]), 2))
    assert np.abs(field(last, "L") - field(sim, "L")).max() < 0.05 * 2.0


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
