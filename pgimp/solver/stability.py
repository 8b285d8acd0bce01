"""The stability limit of a step: Courant = dt max_p((c_p + |v_p|)/L)."""

from pgimp.errors import CaseError

#: Courant numbers above which a step is refused, or warned about.
REFUSED, DOUBTFUL = 1.0, 0.5


def require_stable(dt: float, rate: float) -> None:
    """Refuse a step beyond the limit.

    Parameters
    ----------
    dt : float
        The step.
    rate : float
        Largest (c_p + |v_p|)/L, 1/time.

    Raises
    ------
    CaseError
        If the Courant number is above `REFUSED`.
    """
    courant = dt * rate
    # A controlled step of Courant 1 must not be refused for rounding.
    if not courant <= REFUSED * (1.0 + 1e-9):
        raise CaseError(
            f"time.step: {dt:g} is a Courant number of {courant:.3g}, beyond the stability limit; "
            f"use at most {DOUBTFUL / rate:.3g} (Courant 0.5), or step: {{courant: 0.3}}"
        )


def doubt(dt: float, rate: float) -> str:
    """Warning about a Courant number above `DOUBTFUL`."""
    return (
        f"time.step: {dt:g} is a Courant number of {dt * rate:.3g}; above {DOUBTFUL:g} a free "
        f"surface may become unstable: {0.3 / rate:.3g} is safe (Courant 0.3)"
    )
