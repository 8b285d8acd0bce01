"""The initial particles: the same however many points are tested at a time."""

from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import numpy as np
import pytest

from pgimp.case.schema import Case
from pgimp.errors import CaseError
from pgimp.geometry import measure
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies import lattice as lattice_module
from pgimp.scene.bodies import lattice_body as latticebody
from pgimp.scene.bodies.counts import count_all, count_particles
from pgimp.scene.bodies.lattice import Lattice
from pgimp.scene.bodies.populate import populate
from pgimp.scene.scene import Scene


def case(D, surface="cut-particles", **changes):
    cells, corner = [8, 7, 6][:D], [1.1, 0.9, 0.2][:D]
    data = {
        "format": 1,
        "dimensions": D,
        "grid": {"size": [float(n) for n in cells], "cell": [1.0] * D},
        "method": {"shape": "gimp", "particles-per-cell": [2, 3, 1][:D]},
        "time": {"end": 1.0, "step": {"courant": 0.3}},
        "materials": {"a": {"model": "hooke", "young": 1.0, "poisson": 0.3, "density": 1.0}},
        "bodies": {
            "ball": {"material": "a", "region": {"ball": {"centre": [5.5, 4.0, 3.0][:D],
                                                          "radius": 2.0}}},
            "box": {"material": "a", "region": {"box": {"min": corner,
                                                        "max": [c + 2.0 for c in corner]}}},
        },
    }  # fmt: skip
    data |= changes
    for body in data["bodies"].values():
        body["surface"] = surface
    return Case.model_validate(data)


def particles(D, surface="cut-particles"):
    scene_ = Scene(case(D, surface))
    lattice, counts, notes = count_particles(scene_, Serial())
    p = populate(scene_, lattice, counts, (0, lattice.planes))
    return p, counts, notes


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("block", [1, 7, 50])
@pytest.mark.parametrize("surface", ["cut-particles", "whole-particles"])
def test_small_blocks_make_the_same_particles(monkeypatch, D, block, surface):
    whole, counts, notes = particles(D, surface)
    monkeypatch.setattr(lattice_module, "_BLOCK", block)
    monkeypatch.setattr(latticebody, "_BLOCK", block)
    monkeypatch.setattr(latticebody, "_SLAB", 3 * block)
    monkeypatch.setattr(latticebody, "_BRICK", block)
    monkeypatch.setattr(measure, "_BATCH", block)
    parts, counts_of_parts, notes_of_parts = particles(D, surface)
    assert (counts == counts_of_parts).all()
    assert notes == notes_of_parts
    for a, b in zip(whole, parts, strict=True):
        assert a.tobytes() == b.tobytes()


@pytest.mark.parametrize("D", [1, 2, 3])
def test_ids_count_by_body_then_position(D):
    p, counts, _ = particles(D)
    n = int(counts.sum())
    assert sorted(p.id[:n]) == list(range(n))
    rows = np.argsort(p.id[:n])
    keys = [(int(p.body[r]), *p.x[r]) for r in rows]
    assert keys == sorted(keys)


def test_whole_particles_are_the_points_that_the_regions_contain():
    p, counts, _ = particles(2, "whole-particles")
    case_ = case(2, "whole-particles")
    lattice = Lattice(case_)
    points = np.stack(np.meshgrid(*lattice.coordinates, indexing="ij"), axis=-1).reshape(-1, 2)
    for body, entry in enumerate(case_.bodies.values()):
        expected = points[entry.region.contains(points)]
        assert counts[body].sum() == len(expected)
        assert (p.x[: len(p.id)][p.body == body] == expected).all()


@pytest.mark.parametrize("block", [7, 10**6])
@pytest.mark.parametrize("surface", ["cut-particles", "whole-particles"])
def test_a_point_in_two_bodies_is_named(monkeypatch, block, surface):
    monkeypatch.setattr(lattice_module, "_BLOCK", block)
    box = {"box": {"min": [4.0, 3.0], "max": [6.0, 6.0]}}
    bodies = {
        "ball": {"material": "a", "region": {"ball": {"centre": [5.5, 4.0], "radius": 2.0}}},
        "box": {"material": "a", "region": box},
    }
    with pytest.raises(CaseError, match=r"bodies\.box\.region: .* overlap in the box of"):
        count_particles(Scene(case(2, surface, bodies=bodies)), Serial())


def test_more_cells_than_can_be_numbered_are_refused():
    for side in (1e6, 1e7):  # with what else is in the number, and without it
        grid = {"size": [side] * 3, "cell": [1.0, 1.0, 1.0]}
        with pytest.raises(CaseError, match="more cells than can be numbered"):
            Scene(case(3, grid=grid))


class Gathering:
    """One of several ranks, which are threads, that only gather."""

    def __init__(self, rank, size, shelf, barrier):
        self.rank, self.size, self.shelf, self.barrier = rank, size, shelf, barrier

    def allgather(self, part):
        self.shelf[self.rank] = part
        self.barrier.wait(timeout=20)
        return list(self.shelf)


def refusal(case, size):
    """What `count_all` says of a case on so many ranks."""
    shelf, barrier = [None] * size, Barrier(size)

    def ask(rank):
        with pytest.raises(CaseError) as error:
            count_all(Lattice(case), Gathering(rank, size, shelf, barrier))
        return str(error.value)

    with ThreadPoolExecutor(size) as pool:
        (words,) = set(pool.map(ask, range(size)))
    return words


def test_of_several_overlaps_any_number_of_ranks_names_the_same():
    def slab(low, high):
        box = {"box": {"min": [low, 0.0], "max": [high, 7.0]}}
        return {"material": "a", "region": box}

    # The first pair overlaps at the far end of the grid, the second at the near one.
    bodies = {"a": slab(5.0, 8.0), "b": slab(7.0, 8.0), "c": slab(0.0, 1.0), "d": slab(0.0, 2.0)}
    overlapping = case(2, bodies=bodies)
    alone = refusal(overlapping, 1)
    assert "'a' and 'b' overlap" in alone
    assert [refusal(overlapping, size) for size in (2, 3, 5)] == [alone] * 3
