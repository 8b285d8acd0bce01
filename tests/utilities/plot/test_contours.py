"""``pgimp plot --contours``: outlines keep the area, fields that are linear stay as they are."""

import numpy as np
import pytest
from plotted import hdf5, numbers, table

from pgimp.utilities.plot.camera import camera
from pgimp.utilities.plot.contours.bodies import bodies_of, refuse
from pgimp.utilities.plot.contours.drawing import levels, rows_within
from pgimp.utilities.plot.quantity import Quantity
from pgimp.utilities.plot.runs import PlotFrame
from pgimp.utilities.plot.selection import Selection

RUNS = ("plates", "block")
SPACING = (0.5, 0.25)
FLAT = camera(None, 2, None)
FIELD = Quantity("velocity.x", "velocity", 0)


class Case:
    """A run's case: a domain of 20 x 10 with these faces."""

    dimension = 2
    corners = ((0.0, 0.0), (20.0, 10.0))
    spacing = SPACING

    def __init__(self, faces=None):
        self.case = {"boundaries": faces or {}}


class Bodies:
    """A frame of bodies, each of particles with places (n, 2) and one deformation (2, 2)."""

    path = "made"

    def __init__(self, *parts, known=True):
        self.bodies = [f"body{number}" for number in range(len(parts))]
        x = np.concatenate([np.atleast_2d(place) for place, _ in parts])
        self.count = len(x)
        F = np.zeros((self.count, 3, 3))
        F[:] = np.eye(3)
        of = np.repeat(np.arange(len(parts)), [len(np.atleast_2d(place)) for place, _ in parts])
        F[:, :2, :2] = np.array([deformation for _, deformation in parts])[of]
        volume = 0.125 * np.linalg.det(F)
        self.fields = {
            "id": np.arange(self.count),
            "position": np.c_[x, np.zeros(self.count)],
            "radius": 0.5 * np.sqrt(volume),
            "volume": volume,
            "deformation": F.reshape(-1, 9),
            "body": of,
            "velocity": np.c_[3.0 + 2.0 * x[:, 0] - 5.0 * x[:, 1], x],
        }
        if not known:
            del self.fields["deformation"]

    def __len__(self):
        return self.count

    def __contains__(self, name):
        return name in self.fields

    def rows(self, name, first, last):
        return self.fields[name][first:last]


def lattice(columns, rows, deformation=None, at=(5.0, 3.0)):
    """Particles side by side."""
    F = np.eye(2) if deformation is None else np.asarray(deformation)
    place = np.stack(np.meshgrid(np.arange(columns) * 0.5, np.arange(rows) * 0.25), axis=-1)
    return place.reshape(-1, 2) @ F.T + at, F


def seen(*parts, faces=None, known=True, mirrored=(), field=True):
    frame = Bodies(*parts, known=known)
    chosen = Selection(spacing=SPACING, mirrored=mirrored)
    return bodies_of(PlotFrame(Case(faces), frame), chosen, FIELD, FLAT, field=field)


TURNED = np.array([[0.8, -0.6], [0.6, 0.8]])
SHEARED = np.array([[1.0, 0.9], [0.0, 1.0]])


@pytest.mark.parametrize("shape", [(10, 12), (3, 4), (12, 1), (1, 1)])
@pytest.mark.parametrize("deformation", [np.eye(2), TURNED, TURNED @ SHEARED, np.diag([1.7, 0.6])])
def test_area_is_that_of_the_particles(shape, deformation):
    """Within one per cent; of a particle alone, whose corners are all there is, within six."""
    (body,) = seen(lattice(*shape, deformation), field=False)
    area = shape[0] * shape[1] * 0.125 * np.linalg.det(deformation)
    least = {(10, 12): 0.005, (3, 4): 0.01, (12, 1): 0.012, (1, 1): 0.06}[shape]
    assert body.outline.area == pytest.approx(area, rel=least)
    assert len(body.outline.lines) == 1


def test_uneven_particles_have_no_cracks():
    """Those that are displaced by a tenth of their distance, in any direction."""
    place, F = lattice(20, 20)
    place = place + np.random.default_rng(1).uniform(-0.1, 0.1, place.shape) * SPACING
    (body,) = seen((place, F), field=False)
    assert len(body.outline.lines) == 1
    assert body.outline.area == pytest.approx(400 * 0.125, rel=0.02)


def test_holes_and_parts():
    place, F = lattice(12, 12)
    hole = (abs(place - (7.75, 4.375)) < (0.8, 0.4)).all(axis=1)
    far, _ = lattice(3, 3, at=(15.0, 3.0))
    (body,) = seen((np.concatenate([place[~hole], far]), F), field=False)
    assert len(body.outline.areas) == 2 and len(body.outline.lines) == 3
    assert body.outline.area == pytest.approx((144 - hole.sum() + 9) * 0.125, rel=0.01)


def test_each_body_has_its_own_outline():
    """Also where they touch; those that have no particle yet have none."""
    parts = [lattice(4, 4), (np.zeros((0, 2)), np.eye(2)), lattice(4, 4, at=(7.0, 3.0))]
    found = seen(*parts, field=False)
    assert [body.name for body in found] == ["body0", "body2"]
    assert [body.outline.area for body in found] == pytest.approx([2.0, 2.0], rel=0.01)


def test_halves_become_one_at_a_plane_of_symmetry():
    (body,) = seen(lattice(8, 8, at=(0.25, 3.0)), mirrored=((0, 0.0),))
    assert len(body.outline.lines) == 1
    assert body.outline.area == pytest.approx(16.0, rel=0.005)
    x, y, values = rows_within(body, FLAT)
    assert x.min() < -3.7
    left = dict(zip(zip(x.round(6), y.round(6), strict=True), values, strict=True))
    for (a, b), value in left.items():
        assert left.get((round(-a, 6) + 0.0, b), value) == pytest.approx(value)


@pytest.mark.parametrize("shift", [0.0, 0.13])
def test_periodic_faces_are_no_outline(shift):
    """A band across a seam: two lines from face to face, and the area in the domain."""
    faces = {"x-min": "periodic", "x-max": "periodic"}
    place, F = lattice(40, 8, at=(0.25 + shift, 3.0))
    (body,) = seen((place, F), faces=faces, field=False)
    assert body.outline.area == pytest.approx(40 * 8 * 0.125, rel=0.005)
    assert len(body.outline.lines) == 2
    for line in body.outline.lines:
        assert sorted([line[0, 0], line[-1, 0]]) == [0.0, 20.0]
    place = lattice(6, 6, at=(18.75 + shift, 3.0))[0]
    place[:, 0] %= 20.0
    (body,) = seen((place, F), faces=faces, field=False)
    assert body.outline.area == pytest.approx(36 * 0.125, rel=0.01)
    assert len(body.outline.lines) == 2 == len(body.outline.areas)


def test_outlines_without_deformation():
    """From places and volumes alone: as exact where nothing turned; a shear leaves no cracks."""
    for deformation, least in ((np.eye(2), 0.005), (SHEARED, 0.02), (TURNED, 0.02)):
        (body,) = seen(lattice(30, 60, deformation), known=False, field=False)
        assert body.outline.area == pytest.approx(30 * 60 * 0.125, rel=least)
        assert len(body.outline.lines) == 1
    (body,) = seen(lattice(1, 1), known=False, field=False)
    assert body.outline.area == pytest.approx(0.125, rel=0.06)


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("deformation", [np.eye(2), TURNED @ SHEARED, np.diag([1.7, 0.6])])
def test_linear_fields_stay_as_they_are(deformation, known):
    """Up to the outline, with particles at any distances."""
    place, F = lattice(12, 12, deformation)
    noise = np.random.default_rng(2).uniform(-0.08, 0.08, place.shape) * SPACING
    (body,) = seen((place + noise, F), known=known)
    x, y, values = rows_within(body, FLAT)
    assert len(values) > 250
    np.testing.assert_allclose(values, 3.0 + 2.0 * x - 5.0 * y, atol=1e-9)


def test_fields_of_rows_and_of_what_is_no_number():
    """A row tells no slope across; a particle alone none at all; nan counts as no particle."""
    (body,) = seen(lattice(12, 1))
    x, _, values = rows_within(body, FLAT)
    np.testing.assert_allclose(values, 3.0 + 2.0 * x - 15.0, atol=1e-9)
    (body,) = seen(lattice(1, 1))
    np.testing.assert_allclose(rows_within(body, FLAT)[2], -2.0)
    frame = Bodies(lattice(12, 12))
    frame.fields["velocity"][::7, 0] = np.nan
    snapshot = PlotFrame(Case(), frame)
    (body,) = bodies_of(snapshot, Selection(spacing=SPACING), FIELD, FLAT, field=True)
    x, y, values = rows_within(body, FLAT)
    np.testing.assert_allclose(values, 3.0 + 2.0 * x - 5.0 * y, atol=1e-9)
    frame.fields["velocity"][:, 0] = np.nan
    (body,) = bodies_of(snapshot, Selection(spacing=SPACING), FIELD, FLAT, field=True)
    assert not len(rows_within(body, FLAT)[2])


def test_round_numbers_between_colours():
    np.testing.assert_allclose(levels(0.13, 0.97, 10, exact=False), np.linspace(0.1, 1.0, 10))
    np.testing.assert_allclose(levels(0.0, 3.0, 4, exact=True), [0.0, 0.75, 1.5, 2.25, 3.0])
    for high in np.geomspace(1.0, 10.0, 50):
        assert 12 <= len(levels(0.0, high, 12, exact=False)) - 1 <= 26


def test_commands(runs, plot, tmp_path):
    """Vectors, a table of what is drawn, outlines of particles, sections."""
    words = "--field velocity.y --frame 0,-1 --contours -o fig.svg --csv drawn.csv"
    status, _, said = plot("plates.out", *words.split())
    assert status == 0, said
    drawn = table(tmp_path / "drawn.csv")
    assert [*drawn] == ["run", "frame", "time", "body", "x", "y", "velocity.y"]
    frame = hdf5(runs, "plates.out")
    there = set(drawn["body"])
    assert there == {"low", "high"}
    last = np.array(drawn["frame"]) == drawn["frame"][-1]
    values = numbers(drawn, "velocity.y")[last]
    assert np.median(values) == pytest.approx(np.median(frame["velocity"][:, 1]), rel=0.05)
    text = (tmp_path / "fig.svg").read_text()
    assert "<clipPath" in text and "<image" not in text.replace('<image xlink:href="data', "", 1)
    assert plot("plates.out", "--outline", "--frame", "0", "-o", "a.pdf")[0] == 0
    words = "--field velocity --slice y=3.4 --contours 5 --outline --csv cut.csv -o cut.pdf"
    status, _, said = plot("block.out", *words.split())
    assert status == 0, said
    assert [*table(tmp_path / "cut.csv")][4:6] == ["x", "z"]


def test_sections_of_blocks(runs):
    """The area of the section, also seen from behind, where x grows to the left."""
    from pgimp.utilities.plot.runs import open_runs, snapshots

    (snapshot,) = snapshots(open_runs([str(runs / "block.out")]), [0], [])
    for view in ("y-min", "y-max"):
        eye = camera(view, 3, 1)
        chosen = Selection((), {1: 3.4}, snapshot.shown.spacing)
        field = Quantity("velocity.x", "velocity", 0)
        (body,) = bodies_of(snapshot, chosen, field, eye, field=True)
        assert body.outline.area == pytest.approx(4.0 * 2.0, rel=0.01)
        x, z, _ = rows_within(body, eye)
        assert 2.0 <= x.min() < x.max() <= 6.0 and 2.0 <= z.min() < z.max() <= 4.0
    with pytest.raises(Exception, match="leave --camera out"):
        refuse(snapshot.shown, chosen, camera(None, 3, None), "velocity")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("block.out --contours --field velocity", "cut one with --slice"),
        ("block.out --outline", "cut one with --slice"),
        ("block.out --contours --slice y=3.4 --camera corner", "look along y"),
        ("plates.out --contours 1", "a number of colours from 2 to 100"),
        ("--contours plates.out", "the following arguments are required"),
        ("plates.out --contours --field body", "which nothing smooths"),
        ("plates.out --contours --along x", "--contours is for a picture"),
        ("plates.out --contours --columns time", "--columns is for curves"),
    ],
)
def test_messages_of_contours(plot, words, message):
    status, _, said = plot(*words.split())
    assert status == 2 and message in said
