"""Compliance of patches beside a plane of symmetry, along directions in which this holds them."""

from pgimp.jit.kernel import inner_kernel
from pgimp.kernels.contact.impulses.reference_grid import OF_INVERSE_MASS

#: Greatest component of a normal across which a patch counts as free, if any vertex is.
_ASKEW = 0.5


@inner_kernel
def release_across(coupling, r, numbers, normal):
    """Restore the inverse mass of row `r` in directions nearly across the normal.

    There `set_answer` takes a patch for held whose vertices are so for the most part. The other
    half of a body, beyond a plane of symmetry, would move its free vertices all the same.
    """
    for d in range(3):
        if coupling.answer[r, d] != 0.0 or abs(normal[d]) > _ASKEW:
            continue
        found = 0.0
        for k in range(coupling.start[r], coupling.start[r + 1]):
            found += coupling.entry[k, 0] ** 2 * numbers[coupling.column[k], OF_INVERSE_MASS + d]
        coupling.answer[r, d] = found
