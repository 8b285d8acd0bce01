"""The forces of contact at the vertices, for frames."""

from pgimp.jit.kernel import kernel
from pgimp.kernels.contact.data import fields_of, impulse_of
from pgimp.kernels.contact.vertex import contact_at_vertex
from pgimp.kernels.contact.vertex_list import vertex_number
from pgimp.kernels.grid.conditions import Holding
from pgimp.kernels.loads.loads import relaxed_part


@kernel
def contact_forces(contact, faces, frame, field, forcing, last, out):
    """Add to `out` the contact force at each vertex on the lower-numbered body of each pair.

    Parameters
    ----------
    contact, faces, frame, field, forcing
        As in `update_momentum`, before its beginning or after it.
    last : bool
        Whether to add the force of the last pass, after the beginning; else the part of the
        first pass that particles receive.
    out : (vertices, 3) float64
        Forces in the rank's own planes.
    """
    window = field.window
    holding = Holding(faces, frame, forcing, contact.scratch_impulse, forcing.loads.relaxation)
    part = 1.0 if last else relaxed_part(forcing.loads.relaxation, forcing.dt)
    listed, lower = contact.listed, window.lower
    for n in range(listed.start[field.owned]):
        number = vertex_number(contact, n)
        _, pairs, _ = contact_at_vertex(contact, holding, field, n, last)
        vertex = (number[0] - lower[0]) * window.extent[1] + number[1] - lower[1]
        vertex = vertex * window.extent[2] + number[2] - lower[2]
        for pair in range(pairs):
            a, b = fields_of(contact, pair)
            sign = -1.0 if contact.bodies[a] < contact.bodies[b] else 1.0
            row = contact.pair_states[pair]
            for d in range(3):
                out[vertex, d] += part * sign * impulse_of(row, d) / forcing.dt
