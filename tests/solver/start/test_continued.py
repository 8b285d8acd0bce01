"""Cases that go on from a run's last frame or checkpoint, against one run of the whole time."""

import json

import numpy as np
import pytest
from going_on import FIELDS, at_end, columns, going_on, last, run_to, until
from rank_scenes import flowing, metals
from scenes import box, scene
from two_blocks import flying

import pgimp
from pgimp.cli import main
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial

HOOKE = {"model": "hooke", "young": 1.0e5, "poisson": 0.0, "density": 1000.0}


def both(case, folder, first, end, kind="checkpoints", **parts):
    """Simulations at the end: of the whole, and of a case that goes on at a time `first`."""
    file = last(run_to(until(case, first, **parts), folder), kind)
    rest = going_on(until(case, round(end - first, 9), **parts), file)
    return at_end(until(case, end, **parts)), at_end(rest)


def require_same(whole, rest, within=1e-12, but=(), body=None):
    """Columns are equal to rounding, of all bodies or of one; masses and ids exactly."""
    names = whole.core.scene.body_names
    whole, rest = columns(whole), columns(rest)
    mine = np.full(len(whole["id"]), True) if body is None else whole["body"] == names.index(body)
    for name, values in whole.items():
        if name in but or not values.size or values.dtype != float:
            continue
        scale = np.abs(values[mine]).max(initial=1e-300)
        np.testing.assert_allclose(
            rest[name][mine], values[mine], rtol=0, atol=within * scale, err_msg=name
        )
    for name in ("id", "body", "m", "V0"):
        assert np.array_equal(whole[name], rest[name])


@pytest.fixture(scope="module")
def flows(tmp_path_factory):
    """A scene of soils, fluids, a gas and rubber; a multiple of the 8 steps between two shifts."""
    return both(flowing(), tmp_path_factory.mktemp("flows"), 0.24, 0.36)


@pytest.mark.slow(100)
@pytest.mark.parametrize("body", ["soft", "sand", "rock", "clay", "grains", "water", "mud", "gas"])
def test_a_body_that_flows_goes_on_from_a_checkpoint(flows, body):
    whole, rest = flows
    assert set(whole.core.scene.body_names) == set(flowing()["bodies"])
    require_same(whole, rest, body=body)


@pytest.mark.slow(60)
@pytest.mark.parametrize("body", ["flies", "meets", "falls"])
def test_metals_go_on_from_a_checkpoint(body, tmp_path):
    """All states but damage, which rounding decides in particles that bear no shear stress yet."""
    whole, rest = both(metals(), tmp_path, 0.45, 0.47)
    damage = whole.core.scene.materials.states.first("damage", 1)
    state = [np.delete(columns(each)["state"], damage, axis=1) for each in (whole, rest)]
    np.testing.assert_allclose(*state, rtol=0, atol=1e-12 * np.abs(state).max())
    require_same(whole, rest, body=body, but=("state",))


@pytest.mark.parametrize("kind", ["frames", "checkpoints"])
def test_rubber_goes_on(kind, tmp_path):
    whole, rest = both(flying(), tmp_path, 1.6, 2.0, kind)
    require_same(whole, rest)


@pytest.mark.parametrize("kind", ["frames", "checkpoints"])
def test_a_bar_goes_on(kind, tmp_path):
    bar = scene(1, box([1.0], [6.0], [0.5]), cells=[8], boundaries={"x-max": "fixed"})
    require_same(*both(bar, tmp_path, 0.4, 0.7, kind))


@pytest.mark.parametrize("kind", ["frames", "checkpoints"])
def test_a_compressed_column_keeps_its_mass_and_its_motion(kind, tmp_path):
    """Frames have current volumes, which are no masses over the density."""
    case = scene(
        2, box([0.0, 0.0], [0.5, 1.0]), cells=[5, 14], cell=0.1, gravity=[0.0, -9.81],
        boundaries=dict.fromkeys(("x-min", "x-max", "y-min"), "slip"), materials={"soft": HOOKE},
    )  # fmt: skip
    whole, rest = both(case, tmp_path, 0.1, 0.2, kind, step=5.0e-4)
    volume = columns(rest)["V"].sum()
    assert volume < 0.49 and rest.diagnostics()["mass"] == pytest.approx(500.0, rel=1e-14)
    require_same(whole, rest)


def test_ids_are_of_the_bodies_that_go_on(tmp_path):
    """Those of all bodies stay; of one of them they begin at 0, in their order."""
    file = last(run_to(until(flying(), 0.1), tmp_path))
    case = going_on(until(flying(), 0.1), file)
    whole = columns(pgimp.Simulation(case, comm=Serial()))
    del case["bodies"]["a"]
    part = columns(pgimp.Simulation(case, comm=Serial()))
    n = len(part["id"])
    assert part["id"].tolist() == list(range(n))
    assert np.array_equal(part["x"], whole["x"][-n:])
    case["bodies"]["c"] = case["bodies"].pop("b")
    case["bodies"]["c"]["region"]["points"]["body"] = "b"
    assert np.array_equal(columns(pgimp.Simulation(case, comm=Serial()))["x"], part["x"])


# The initial configuration


def column(**parts):
    """A column on the floor, in the initial configuration, under its weight."""
    body = box([0.0, 0.0], [1.0, 6.0]) | {"formulation": "total-lagrangian"}
    walls = {"x-min": "slip", "x-max": "slip", "y-min": "slip"}
    return scene(2, body, cells=[1, 7], boundaries=walls, gravity=[0.0, -1.0], **parts)


def test_vertices_keep_their_motion_in_the_initial_configuration(tmp_path):
    whole, rest = both(column(), tmp_path, 0.3, 0.8)
    require_same(whole, rest)
    moved = columns(rest)
    assert np.abs(moved["x"] - moved["origin"]).max() > 0.1
    line = rest.diagnostics()
    for name in ("kinetic-energy", "strain-energy"):
        assert line[name] == pytest.approx(whole.diagnostics()[name], rel=1e-12)


def test_vertices_go_on_in_a_domain_that_begins_elsewhere(tmp_path):
    file = last(run_to(until(column(), 0.3), tmp_path))
    rest = going_on(until(column(), 0.2), file)
    same = at_end(rest)
    rest["grid"] = {"origin": [0.0, -2.0], "size": [1.0, 12.0], "cell": [1.0, 1.0]}
    del rest["boundaries"]["y-min"]
    rest["constraints"] = {}
    free = pgimp.Simulation(rest, comm=Serial())
    found, expected = columns(free), columns(same)
    assert np.array_equal(found["origin"], expected["origin"])
    start = columns(pgimp.Simulation(going_on(until(column(), 0.2), file), comm=Serial()))
    assert np.array_equal(found["x"], start["x"])
    free.step()
    again = columns(free)
    assert np.abs(again["x"][-4:] - start["x"][-4:] - 0.01 * again["v"][-4:]).max() < 1e-12
    rest["grid"]["cell"], rest["grid"]["size"] = [0.5, 0.5], [1.0, 12.0]
    with pytest.raises(CaseError, match="on the grid that they had"):
        pgimp.Simulation(rest, comm=Serial())


def test_a_body_goes_over_to_the_current_configuration(tmp_path):
    """Also from a frame; only back it does not go."""
    folder = run_to(until(column(), 0.3), tmp_path / "initial")
    for kind in ("frames", "checkpoints"):
        case = going_on(until(column(), 0.1), last(folder, kind))
        case["bodies"]["body"]["formulation"] = "current"
        sim = pgimp.Simulation(case, comm=Serial())
        frame = pgimp.open(folder).frames[-1]
        assert np.array_equal(columns(sim)["x"], frame["position"][:, :2])
        assert np.array_equal(columns(sim)["V"], frame["volume"])
        assert sim.diagnostics()["mass"] == 6.0
    now = run_to(case, tmp_path / "current")
    case["bodies"]["body"] |= {"formulation": "total-lagrangian"}
    case["bodies"]["body"]["region"]["points"]["file"] = last(now)
    with pytest.raises(CaseError, match="in the current configuration, and its vertices have no"):
        pgimp.Simulation(case, comm=Serial())


@pytest.mark.wide
@pytest.mark.slow(150)
def test_every_law_of_solids_goes_on_in_the_initial_configuration(tmp_path):
    """Columns side by side, each on vertices of its own."""
    laws = {name: flowing()["materials"][name] for name in ("sand", "rock", "clay")}
    laws |= {"metal": metals()["materials"]["soft"], "hot": metals()["materials"]["stiff"]}
    laws |= {
        "soft": flowing()["materials"]["soft"],
        "stiff": HOOKE | {"young": 100.0, "density": 1.0},
    }
    bodies = {
        name: box([1.0 + 4.0 * i, 0.0], [3.0 + 4.0 * i, 4.0], [0.0, -0.5], name)
        | {"formulation": "total-lagrangian"}
        for i, name in enumerate(laws)
    }
    case = scene(
        2, bodies, cells=[4 * len(laws), 8], gravity=[0.0, -1.0], boundaries={"y-min": "slip"},
        materials=laws,
    )  # fmt: skip
    require_same(*both(case, tmp_path, 0.3, 0.5), within=1e-11)


# Ranks


@pytest.mark.slow(60)
@pytest.mark.parametrize("scene_of, first", [(flowing, 0.24), (column, 0.3)])
def test_same_bits_on_ranks(scene_of, first, tmp_path, mpirun):
    """Supports of deformed particles begin elsewhere than those of undeformed ones."""
    file = last(run_to(until(scene_of(), first), tmp_path / "before"))
    (tmp_path / "case.yaml").write_text(json.dumps(going_on(until(scene_of(), 0.1), file)))
    for n in (1, 3):
        run = mpirun(n, ["-m", "pgimp", "case.yaml", "-o", f"{n}"], cwd=tmp_path)
        assert run.returncode == 0, run.stderr
    assert main(["compare", str(tmp_path / "1"), str(tmp_path / "3")]) == 0


# What cannot go on


@pytest.fixture(scope="module")
def before(tmp_path_factory):
    """A run of two blocks with frames that a case can go on from."""
    return run_to(until(flying(), 0.1), tmp_path_factory.mktemp("before"))


def refusal(case):
    with pytest.raises(CaseError) as caught:
        pgimp.Simulation(case, comm=Serial())
    return " ".join(str(caught.value).split())


CHANGES = {
    "density": ({"materials": {"soft": {"model": "neo-hookean", "young": 100.0, "poisson": 0.3,
                                        "density": 2.0}}},
                "mass over initial volume is 1, and the density of 'a' 2"),
    "law": ({"materials": {"soft": {"model": "hooke", "young": 100.0, "poisson": 0.3,
                                    "density": 1.0}}},
            "'a' was of the law neo-hookean, and is of hooke here"),
    "geometry": ({"geometry": "plane-stress"}, "plane-strain, and this one is in 2D, plane-stress"),
}  # fmt: skip


@pytest.mark.parametrize("kind", ["frames", "checkpoints"])
@pytest.mark.parametrize("change", CHANGES)
def test_a_case_of_another_state_is_refused(before, kind, change):
    parts, words = CHANGES[change]
    assert words in refusal(going_on(until(flying(), 0.1), last(before, kind)) | parts)


def test_a_body_that_the_file_does_not_have_is_refused(before):
    case = going_on(until(flying(), 0.1), last(before))
    case["bodies"]["c"] = case["bodies"].pop("a")
    assert "it has no body 'c', but a, b; name the one to go on with" in refusal(case)


def test_fields_that_a_frame_lacks_are_named(tmp_path):
    folder = run_to(until(flying(), 0.1) | {"output": {"fields": ["velocity"]}}, tmp_path)
    words = refusal(going_on(until(flying(), 0.1), last(folder, "frames")))
    assert "a frame without stress, deformation, mass, initial-volume" in words
    assert f"fields: [{', '.join(FIELDS)}]" in words and "checkpoints/step-*.h5" in words


def test_rounded_frames_are_refused(tmp_path):
    output = {"fields": FIELDS, "precision": "float32"}
    folder = run_to(until(flying(), 0.1) | {"output": output}, tmp_path)
    words = refusal(going_on(until(flying(), 0.1), last(folder, "frames")))
    assert "rounded to 32 bits" in words and "output.precision: float64" in words


def test_a_frame_of_vertices_motion_is_refused(tmp_path):
    folder = run_to(until(column(), 0.05), tmp_path)
    words = refusal(going_on(until(column(), 0.1), last(folder, "frames")))
    assert "that of vertices, which frames do not have: take a checkpoint" in words


def test_a_damaged_checkpoint_is_refused(before, tmp_path):
    data = bytearray(open(last(before), "rb").read())
    data[-100] ^= 1
    (tmp_path / "step-1.h5").write_bytes(data)
    words = refusal(going_on(until(flying(), 0.1), tmp_path / "step-1.h5"))
    assert "do not have their checksum" in words


def test_a_table_has_no_body(tmp_path):
    (tmp_path / "p.csv").write_text("x,y,volume\n1.5,1.5,0.25\n")
    case = until(flying(), 0.1)
    case["bodies"]["a"]["region"] = {"points": {"file": str(tmp_path / "p.csv"), "body": "a"}}
    assert "a table has no body: leave out `body`" in refusal(case)
