"""A manufactured solution of one's own, for ``--import``: rubber that swirls in a box.

In the unit square the displacement is u = A sin(w t) (sin(pi X) cos(pi Y), -cos(pi X) sin(pi Y)).
Along each side the normal component is zero, and the shear stress too: frictionless walls hold it.
With a = pi A sin(w t), c = cos(pi X) cos(pi Y) and s = sin(pi X) sin(pi Y) the gradient is

    F = (1 + a c, -a s; a s, 1 - a c),    J = det F = 1 + a^2 (s^2 - c^2).

A neo-Hookean solid has P = mu F + (lambda ln J - mu) F^-T. By Piola's identity, Div(J F^-T) = 0,

    Div P = -2 pi^2 mu u + (lambda (1 - ln J) + mu)/J^2 cof(F) Grad J,

and the body force is b = u_tt - Div P/rho0. The material is that of cases/own/swirl.yaml.
"""

from math import cos, log, pi, sin

import pgimp
from pgimp.jit.kernel import kernel


@kernel
def gradient(X, a):
    """Return F, row by row, and J."""
    c, s = cos(pi * X[0]) * cos(pi * X[1]), sin(pi * X[0]) * sin(pi * X[1])
    return 1.0 + a * c, -a * s, a * s, 1.0 - a * c, 1.0 + a * a * (s * s - c * c)


@pgimp.body_force("swirl-force")
def force(X, t, amplitude, frequency, mu, lam, density):
    """Force per mass on the material point."""
    g, w = amplitude * sin(2.0 * pi * frequency * t), 2.0 * pi * frequency
    a = pi * g
    f11, f12, f21, f22, J = gradient(X, a)
    shape = sin(pi * X[0]) * cos(pi * X[1]), -cos(pi * X[0]) * sin(pi * X[1])
    slope = pi * a * a * sin(2.0 * pi * X[0]), pi * a * a * sin(2.0 * pi * X[1])  # Grad J
    r = (lam * (1.0 - log(J)) + mu) / (J * J)
    div1 = -2.0 * pi * pi * mu * g * shape[0] + r * (f22 * slope[0] - f21 * slope[1])
    div2 = -2.0 * pi * pi * mu * g * shape[1] + r * (f11 * slope[1] - f12 * slope[0])
    return (-w * w * g * shape[0] - div1 / density, -w * w * g * shape[1] - div2 / density)


@pgimp.exact_solution("swirl")
def state(X, t, amplitude, frequency, mu, lam):
    """Displacement, velocity and Cauchy stress (xx, yy, zz, xy) of the material point."""
    w = 2.0 * pi * frequency
    g, rate = amplitude * sin(w * t), amplitude * w * cos(w * t)
    shape = sin(pi * X[0]) * cos(pi * X[1]), -cos(pi * X[0]) * sin(pi * X[1])
    f11, f12, f21, f22, J = gradient(X, pi * g)
    m, p = mu / J, lam * log(J) / J
    sigma = (
        m * (f11 * f11 + f12 * f12 - 1.0) + p,
        m * (f21 * f21 + f22 * f22 - 1.0) + p,
        p,
        m * (f11 * f21 + f12 * f22),
    )
    return (g * shape[0], g * shape[1]), (rate * shape[0], rate * shape[1]), sigma
