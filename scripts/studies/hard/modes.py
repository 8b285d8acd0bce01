"""What is left of a vibration after 10 and 50 periods, by shape, transfer, configuration and step.

Run as ``scripts/hard modes``: the cantilever of scripts/initial, 16 by 4 cells, in
its first mode; writes the table of docs/methods.md, scripts/pages/tables/modes.md.
"""

from studies.harness import Table, put
from studies.initial.keeping import ringing
from studies.pareto.candidates import SHAPES

from pgimp.errors import CaseError, RunError

COURANTS = (0.3, 0.1, 0.03)


def left(configuration, shape, affine, courant):
    """Parts of the mode's energy after 10 and 50 periods, as text."""
    try:
        found = ringing(configuration, affine, courant, shape=shape)["left"]
    except RunError:
        return "stopped"
    except CaseError:
        return ""
    return ", ".join(f"{found[n]:.3f}" for n in ("10", "50"))


def main():
    columns = [(one, courant) for one in ("current", "initial") for courant in COURANTS]
    table = Table("method", *(f"{one}, {courant:g}" for one, courant in columns))
    for shape in SHAPES:
        for affine in (False, True):
            found = [left(one, shape, affine, courant) for one, courant in columns]
            table.add(shape + ", affine" * affine, *found)
    put({"modes": table.text()})
