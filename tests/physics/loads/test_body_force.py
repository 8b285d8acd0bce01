"""Body forces: a frame that turns, in which free bodies fly as they do without it."""

import numpy as np
import pytest
from scenes import box, finish, scene, start, write_case
from tiers import wide

from pgimp.case.schema import Case
from pgimp.errors import CaseError


def flying(D, rate, velocity=(0.3, 0.2, -0.1), **parts):
    """A block in a large domain that turns about a point."""
    low, high = ([4.0, 3.0, 3.5][:D], [6.0, 5.0, 4.5][:D])
    about = [3.5, 4.0, 3.0][:D]
    body = box(low, high, list(velocity[:D]))
    force = {"rotating-frame": {"about": about, "rate": rate}}
    parts = {"end": 0.8, "step": 0.02} | parts
    return scene(D, body, cells=[9] * D, body_force=force, **parts)


def turned(omega, t, x):
    """A vector that is at rest, as it is seen from a frame that turns (Rodrigues)."""
    rate = np.linalg.norm(omega)
    n, angle = np.array(omega) / rate, -rate * t
    return x * np.cos(angle) + np.cross(n, x) * np.sin(angle) + n * (n @ x) * (1 - np.cos(angle))


@pytest.mark.parametrize(("D", "rate"), [(2, -0.7), wide(3, (0.5, -0.4, 0.3))])
def test_a_free_block_flies_straight_seen_from_outside(D, rate):
    """To first order in the step, which the error is; the frame turns by half a radian or so."""
    omega = np.array(rate if D == 3 else (0.0, 0.0, rate))
    x, about, v = np.zeros((3, 3))
    x[:D], about[:D], v[:D] = [5.0, 4.0, 4.0][:D], [3.5, 4.0, 3.0][:D], [0.3, 0.2, -0.1][:D]
    arm = x - about
    exact = about + turned(omega, 0.8, arm + 0.8 * (v + np.cross(omega, arm)))
    errors = []
    for step in (0.02, 0.01):
        sim = start(flying(D, rate, step=step))
        sim.diagnostics()
        line = finish(sim).diagnostics()
        centre = [line[f"body.body.centre-{axis}"] for axis in "xyz"[:D]]
        errors.append(np.abs(np.array(centre) - exact[:D]).max())
        assert line["external-work"] > 0.2 * line["kinetic-energy"]
        assert abs(line["dissipated-energy"]) < 3.0 * step * line["external-work"]
    assert np.abs(exact[:D] - x[:D]).max() > 0.2 and errors[0] < 0.02
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_same_bits_on_ranks_and_after_a_restart(tmp_path, python, mpirun):
    parts = {"history": {"every": 0.1}, "output": {"every": 0.4}}
    write_case(tmp_path / "case.yaml", flying(2, -0.7, **parts))
    for ranks in (1, 3):
        words = ["-m", "pgimp", "case.yaml", "-o", str(ranks), "--quiet"]
        words += ["--set", f"time.end={0.8 if ranks == 1 else 0.4}"]
        job = python(words, cwd=tmp_path) if ranks == 1 else mpirun(ranks, words, cwd=tmp_path)
        assert job.returncode == 0, job.stderr
    words = ["-m", "pgimp", "case.yaml", "-o", "3", "--quiet", "--resume"]
    job = mpirun(2, words, cwd=tmp_path)
    assert job.returncode == 0, job.stderr
    files = [tmp_path / "1/history.csv", *tmp_path.glob("1/frames/*")]
    assert len(files) == 4
    for path in files:
        assert path.read_bytes() == (tmp_path / "3" / path.relative_to(tmp_path / "1")).read_bytes()


@pytest.mark.parametrize(
    ("D", "force", "message"),
    [
        (1, {"rotating-frame": {"about": [0.0], "rate": 1.0}}, "exists in 2D and 3D only"),
        (2, {"rotating-frame": {"about": [0.0], "rate": 1.0}}, r"about\n *expected 2 entries"),
        (2, {"rotating-frame": {"about": [0.0, 0.0], "rate": [0.0, 0.0, 1.0]}}, "a number in 2D"),
        (3, {"rotating-frame": {"about": [0.0] * 3, "rate": 1.0}}, "a vector along the axis"),
        (2, {"rotating": {}}, "unknown body force 'rotating'"),
    ],
)
def test_what_does_not_fit_is_refused(D, force, message):
    case = flying(D, 1.0) | {"body-force": force}
    with pytest.raises(ValueError, match=message):
        Case.model_validate(case)


def test_an_exact_solution_has_none():
    from exact_cases import block

    case = block(2, 0.25)
    case["body-force"] = {"rotating-frame": {"about": [0.0, 0.0], "rate": 1.0}}
    with pytest.raises((ValueError, CaseError), match="the exact solution has none"):
        Case.model_validate(case)
