"""Report on the bodies of a case: waves, transits, and strains by loads."""

from collections.abc import Mapping, Sequence

from pgimp.case.schema import Case
from pgimp.physics.boundaries.base import Boundary
from pgimp.scene.checks.facts import BodyFacts
from pgimp.scene.checks.sanity import strains
from pgimp.scene.checks.units import in_si
from pgimp.scene.checks.validity.tearing import stretches
from pgimp.scene.liquids import is_gas, reflecting
from pgimp.scene.scene import Scene

#: Most bodies with lines in a short report.
MOST_BODIES = 3
#: Least strain by loads that a short report mentions.
_NOTABLE = 1e-2


def report_body(body: BodyFacts, case: Case, stages: Sequence[Case], verbose: bool) -> None:
    """Print wave speed, travel time, and loads over stiffness: strains that show unit mistakes.

    Besides, how far grips stretch it over all `stages`.
    """
    c, duration = body.wave_speed, stages[-1].time.end
    transit = body.extent / c
    pulled = {f"by the way of {one.between[0]}": one.strain for one in stretches(stages, body)}
    found = pulled | strains(case, body)
    texts = [f"{what} {s:.2g}" for what, s in found.items() if verbose or abs(s) > _NOTABLE]
    strained = f"strain {', '.join(texts)}" if texts else ""
    print(
        f"body {body.name:<11} {body.particles:,} particles; wave speed {c:.4g}, travel time "
        f"{transit:.4g} over {body.extent:.4g}; the run lasts {duration / transit:.3g} travel times"
        f"{f'; {strained}' if strained and not verbose else ''}"
    )
    for fact in case.bodies[body.name].region.facts() if verbose else ():
        print(f"{'':<16} {fact}")
    for key, (least, mean, most) in body.varies.items():
        print(f"{'':<16} {key} varies from {least:.6g} to {most:.6g}, mean {mean:.6g}")
    if verbose:
        print(f"{'':<16} {strained}")


def report_materials(case: Case) -> None:
    """Print each material's parameters in SI units, a line each, if the case's units are known."""
    for name in list(dict.fromkeys(body.material for body in case.bodies.values()))[:MOST_BODIES]:
        if found := in_si(case, name):
            texts = (f"{key} {value:.4g} {unit}" for key, (value, unit) in found.items())
            print(f"material {name:<7} {', '.join(texts)}")


def report_walls(case: Case) -> None:
    """Print which faces reflect fluids, where the case leaves that to pgimp.

    Besides, which do not though it asks for it, as friction would miss what they press.
    """
    laws = {name: case.materials[body.material] for name, body in case.bodies.items()}
    solid = [name for name, law in laws.items() if not (law.LIQUID or is_gas(law))]
    faces = {name: face for name, face in case.boundaries.items() if not face.joins}
    wall = getattr(case.method, "wall", "")
    rough = [name for name, face in faces.items() if face.releases and not face.mirrors]
    if wall == "mirror" and rough:
        print(f"walls            no mirrors where there is friction: {', '.join(rough)}")
    if wall != "auto" or len(solid) == len(laws) or not faces:
        return
    chosen = reflecting(case)
    if solid:
        text = f"do not reflect: '{solid[0]}' is no liquid or gas"
    elif case.method.ends and not chosen:
        text = f"do not reflect: {case.method.shape} needs no mirrors"
    else:
        text = "; ".join(
            f"{name} {'reflects' if name in chosen else _why_not(face)}"
            for name, face in faces.items()
        )
    print(f"walls            {text} (wall: auto)")


def _why_not(face: Boundary) -> str:
    """Why a face of fluids does not reflect, in words after its name."""
    if face.absorbs:
        return "absorbs"
    return "lets go" if face.releases else "moves as prescribed"


def report_inflow(case: Case, entering: Mapping[str, int], end: float) -> None:
    """Print what enters until the end of the run."""
    for name, number in entering.items():
        entry = case.inflow[name]
        until = f" until t = {entry.until:g}" if entry.until is not None else ""
        print(
            f"inflow {name:<9} about {number:,} particles enter along {'xyz'[entry.axis]}{until}, "
            f"on a way of {entry.travel(end):.4g}"
        )


def report_rigid(scene: Scene, verbose: bool) -> None:
    """Print the motions of rigid bodies."""
    for name, field in zip(
        scene.interaction.rigid_bodies.names, scene.interaction.rigid_bodies.fields, strict=True
    ):
        entry = scene.case.rigid_bodies[name]
        moves = "moves freely" if entry.free else "moves" if entry.moves else "is fixed"
        more = f"; {len(field.values):,} distances on its lattice" if verbose else ""
        print(f"rigid {name:<10} {moves}{more}")
