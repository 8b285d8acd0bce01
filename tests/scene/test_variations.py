"""Materials that vary in space: what particles then carry."""

import numpy as np
import pytest
from rank_scenes import PAIR, VARIED
from scenes import BAR, SOFT, box, field, finish, scene, start

import pgimp
from pgimp.errors import CaseError
from pgimp.mpi.comm import Serial
from pgimp.scene.bodies.counts import count_particles
from pgimp.scene.bodies.populate import populate
from pgimp.scene.checks.facts import examine
from pgimp.scene.geometry import release, share
from pgimp.scene.scene import Scene


def particles(case):
    """Scene, particles and their number; nothing is compiled."""
    loaded = pgimp.load(case)
    made = Scene(loaded)
    share(loaded, Serial())
    lattice, counts, _ = count_particles(made, Serial())
    return made, populate(made, lattice, counts, (0, lattice.planes)), int(counts.sum())


def flat(value):
    """A variation that is none: one layer."""
    return {"layers": [[-100.0, value]], "over": "x"}


def crash(materials):
    bodies = {"flies": box([1.0, 2.0], [4.0, 5.0], [4.0, 0.5]),
              "meets": box([4.5, 1.5], [7.5, 4.5], [-3.0, 0.2], "stiff")}  # fmt: skip
    return scene(
        2, bodies, cells=[9, 8], materials=materials, step={"courant": 0.3}, end=0.4,
        gravity=[0.0, -2.0], boundaries={"y-min": "slip"},
    )  # fmt: skip


def test_what_does_not_vary_has_the_bits_of_numbers():
    numbers = finish(start(crash(PAIR)))
    carried = {
        "soft": SOFT | {"young": flat(SOFT["young"]), "density": flat(SOFT["density"])},
        "stiff": PAIR["stiff"] | {"poisson": flat(PAIR["stiff"]["poisson"])},
    }
    layers = finish(start(crash(carried)))
    assert layers.step == numbers.step > 10
    for name in ("x", "v", "F", "sigma", "m"):
        assert np.array_equal(field(layers, name), field(numbers, name)), name
    assert layers.diagnostics() == numbers.diagnostics()


# -- what particles carry


def cloud(folder, **columns):
    """A body of nine particles of a file, in 2D."""
    x = np.stack(np.meshgrid([1.0, 1.5, 2.0], [1.0, 1.5, 2.0]), axis=-1).reshape(-1, 2)
    lines = [",".join(["x", "y", "volume", *columns])]
    for i, place in enumerate(x.tolist()):
        lines.append(",".join(map(repr, [*place, 0.25, *(each[i] for each in columns.values())])))
    (folder / "cloud.csv").write_text("\n".join(lines) + "\n")
    return {"material": "soft", "region": {"points": {"file": str(folder / "cloud.csv")}}}


def test_columns_of_points(tmp_path):
    young, rho = np.linspace(50.0, 90.0, 9).tolist(), np.linspace(1.0, 3.0, 9).tolist()
    varies = {"young": {"column": "e"}, "density": {"column": "rho", "times": 2.0}}
    case = scene(2, cloud(tmp_path, e=young, rho=rho), materials={"soft": SOFT | varies})
    made, p, n = particles(case)
    assert n == 9
    assert np.array_equal(p.m, 0.5 * np.array(rho))
    lam, mu = 0.3 * np.array(young) / (1.3 * 0.4), np.array(young) / 2.6
    expected = np.stack([lam, mu, 2.0 * np.array(rho), young], axis=1)
    np.testing.assert_allclose(p.own, expected, rtol=1e-15)
    assert made.case.materials["soft"].typical("young") == 70.0

    case["bodies"]["body"] = cloud(tmp_path, rho=rho)
    with pytest.raises(CaseError, match=r"no column 'e', from which materials\.soft\.young is"):
        particles(case)
    case["bodies"]["body"] = cloud(tmp_path, e=[*young[:4], -1.0, *young[5:]], rho=rho)
    message = r"young: the particle at \(1.5, 1.5\) of body 'body', line 6 of .*cloud.csv, has "
    with pytest.raises(CaseError, match=f"{message}.*young -1.*must be above 0, got -1"):
        particles(case)
    case["bodies"]["body"] = box([1.0, 1.0], [2.0, 2.0])
    with pytest.raises(CaseError, match=r"body 'body' has none: region: \{points"):
        particles(case)


def test_masses_are_those_of_the_densities():
    """At the middle of its box a particle has the mean density of a linear one."""
    rho = {"table": [[0.0, 1.0], [4.0, 9.0]], "over": "y"}
    case = scene(2, box([0.0, 0.0], [3.0, 4.0]), materials={"soft": SOFT | {"density": rho}})
    _, p, n = particles(case)
    assert p.m[:n].sum() == pytest.approx(3.0 * 4.0 * 5.0, rel=1e-14)
    # Where the surface cuts particles as well: what is left of them lies at its centroid.
    case["bodies"]["body"] = box([0.1, 0.2], [2.7, 3.3])
    _, p, n = particles(case)
    assert p.m[:n].sum() == pytest.approx(2.6 * 3.1 * (1.0 + 2.0 * 1.75), rel=1e-13)


def test_state_and_stress_at_the_start_vary_too():
    gas = {"model": "ideal-gas", "gamma": 1.5, "density": 2.0}
    gas["energy"] = {"table": [[0.0, 1.0], [4.0, 3.0]], "over": "x"}
    made, p, n = particles(scene(2, box([0.0, 0.0], [4.0, 2.0]), materials={"soft": gas}))
    energy = 1.0 + 0.5 * p.x[:n, 0]
    np.testing.assert_allclose(p.state[:n, 0], energy, rtol=1e-15)
    np.testing.assert_allclose(p.sigma[:n, :3], -np.tile(energy, (3, 1)).T, rtol=1e-15)
    assert made.setting.materials[0].energy_at_start == (0,)  # an Own


def test_random_fields_do_not_depend_on_which_particles_are_made():
    field = {"random": {"mean": 50.0, "cov": 0.2, "correlation": 1.0}}
    case = scene(2, box([1.0, 0.0], [7.0, 4.0]), materials={"soft": SOFT | {"young": field}})
    loaded = pgimp.load(case)
    made = Scene(loaded)
    lattice, counts, _ = count_particles(made, Serial())
    whole = populate(made, lattice, counts, (0, lattice.planes))
    part = populate(made, lattice, counts, (5, 9))
    rows = np.searchsorted(whole.id, part.id)
    assert 10 < len(rows) < len(whole.id)
    assert np.array_equal(whole.own[rows], part.own)
    assert len(np.unique(whole.own[:, 0])) == len(whole.id)


def test_fields_show_parameters():
    from pgimp.physics.fields import Source

    bodies = {"a": box([1.0, 1.0], [3.0, 3.0]), "b": box([4.0, 1.0], [6.0, 3.0], material="stiff")}
    made, p, n = particles(scene(2, bodies, cells=[20, 8], materials=VARIED))
    source = Source(p, np.arange(n), 2, made.materials.body_material)
    shown = {name: made.fields[f"parameter-{name}"].values(source)
             for name in ("young", "poisson", "density")}  # fmt: skip
    a = p.body[:n] == 0
    assert np.array_equal(shown["poisson"][a], np.full(a.sum(), 0.3))
    np.testing.assert_allclose(shown["poisson"][~a], 0.1 + 0.3 / 24.0 * p.x[:n][~a, 0])
    assert (shown["young"][~a] == 300.0).all()
    assert np.ptp(shown["young"][a]) > 1.0
    assert set(shown["density"][a]) == {1.0}


REFUSED = [
    ({"young": {"table": [[0.0, 1.0], [2.0, 3.0]], "over": "x"}},
     r"materials.soft.young: the particle at \(2.25, .*\) of body 'body' lies at x 2.25, where"),
    ({"young": {"random": {"mean": 1.0, "deviation": 9.0, "distribution": "normal",
                           "correlation": 1.0}}},
     r"materials.soft.young: the particle at .* has young -.*: must be above 0, got -"),
    ({"young": {"table": [[0.0, 1.0], [2.0, 3.0]], "over": "z"}}, "young.over: the case, 2D, has"),
    ({"young": {"random": {"mean": 1.0, "cov": 0.1, "correlation": [1.0, 2.0, 3.0]}}},
     "young.random.correlation: expected a length, or 2, one a direction, got a list of 3"),
    ({"young": {"column": "volume"}}, "young: the column 'volume' of particles has a meaning"),
]  # fmt: skip


@pytest.mark.parametrize(("parts", "text"), REFUSED)
def test_what_no_particle_may_have(parts, text):
    case = scene(2, box([1.0, 0.0], [4.0, 4.0]), materials={"soft": SOFT | parts})
    with pytest.raises(CaseError, match=text):
        particles(case)


def test_a_law_that_is_another_one_at_some_places():
    water = {"model": "newtonian", "bulk": 10.0, "density": 1.0}
    water["shear-viscosity"] = {"layers": [[0.0, 0.1], [2.0, 0.0]], "over": "x"}
    case = scene(2, box([1.0, 0.0], [4.0, 4.0]), materials={"soft": water})
    with pytest.raises(CaseError, match=r"\(1.25, .*shear-viscosity 0.1: with that the law is"):
        particles(case)


def test_exact_solutions_are_of_uniform_bodies():
    young = {"layers": [[0.0, 100.0]], "over": "x"}
    case = scene(
        1, box([0.0], [8.0]), materials={"soft": BAR | {"young": young}}, cells=[10],
        boundaries={"x-min": "fixed"}, exact={"vibrating-bar": {"amplitude": 0.01}},
    )  # fmt: skip
    with pytest.raises(CaseError, match="young: the exact solution is that of a uniform body"):
        pgimp.load(case)


def test_facts_are_those_of_all_particles():
    """The greatest wave speed and density, and the ranges of what varies."""
    bodies = {"a": box([0.0, 1.0], [3.0, 5.0]), "b": box([4.0, 1.0], [6.0, 3.0], material="stiff")}
    case = crash(VARIED) | {"bodies": bodies}
    loaded = pgimp.load(case)
    made = Scene(loaded)
    lattice, counts, _ = count_particles(made, Serial())
    soft, stiff = examine(made, lattice, counts).bodies
    p = populate(made, lattice, counts, (0, lattice.planes))
    a = p.body == 0
    young, rho = made.materials.variations.fields["parameter-young"], p.m / p.V0
    from pgimp.physics.fields import Source

    E = young.values(Source(p, np.flatnonzero(a), 2, made.materials.body_material))
    c = np.sqrt(E * 0.7 / (1.3 * 0.4) / rho[a])
    assert soft.wave_speed == pytest.approx(c.max(), rel=1e-12)
    assert soft.density == 1.7
    assert soft.varies["young"] == pytest.approx((E.min(), E.mean(), E.max()))
    assert stiff.varies["poisson"] == pytest.approx((0.15 + 0.3 / 96, 0.1625, 0.175 - 0.3 / 96))


def test_samples_carry_as_much():
    """What `pgimp check` times: kernels of the same types, whatever the place of the sample."""
    from pgimp.utilities.model.sample_cases import plain

    made, sample = (Scene(pgimp.load(crash(VARIED))), Scene(plain(pgimp.load(crash(VARIED)), 100)))
    assert (
        sample.materials.variations.layouts[0].varying
        == made.materials.variations.layouts[0].varying
    )
    assert sample.materials.variations.width == made.materials.variations.layouts[0].width


def test_files_are_read_once_and_forgotten(tmp_path):
    """A table from a file, whose numbers are not known when the case is read."""
    (tmp_path / "soil.csv").write_text("depth,young,poisson\n0.0,50.0,0.1\n4.0,90.0,0.3\n")
    over = {"table": str(tmp_path / "soil.csv"), "over": "depth", "surface": 4.0}
    varies = {"young": over, "poisson": over, "density": over | {"column": "young"}}
    made, p, n = particles(scene(2, box([1.0, 0.0], [3.0, 4.0]), materials={"soft": SOFT | varies}))
    depth = 4.0 - p.x[:n, 1]
    young, poisson = 50.0 + 10.0 * depth, 0.1 + 0.05 * depth
    np.testing.assert_allclose(p.own[:n, 1], young / (2.0 + 2.0 * poisson), rtol=1e-14)
    np.testing.assert_allclose(p.m[:n], 0.25 * young, rtol=1e-14)
    assert "Young's modulus [stress]" in made.fields["parameter-young"].meaning
    release(made.case)
    assert made.case.materials["soft"].variations["young",].typical is None
    (tmp_path / "soil.csv").write_text("depth,young,poisson\n0.0,50.0,0.1\n4.0,90.0,0.5\n")
    with pytest.raises(CaseError, match=r"poisson: the particle at .* must be below 0\.5, got"):
        particles(scene(2, box([1.0, -0.0], [3.0, 4.0]), materials={
            "soft": SOFT | varies | {"poisson": over | {"times": 1.1}}
        }))  # fmt: skip
