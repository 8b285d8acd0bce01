"""A disk that turns."""

from scenes import field, scene

CENTRE, RATE = [2.03, 1.98], 0.2


def disk(cells, end, step):
    """A disk of radius 1, 4 length units of domain, that turns with RATE."""
    body = {
        "material": "soft",
        "region": {"ball": {"centre": CENTRE, "radius": 1.0}},
        "velocity": {"rotation": {"about": CENTRE, "rate": RATE}},
    }
    return scene(2, body, cells=[4 * cells] * 2, cell=1.0 / cells, end=end, step=step)


def spin(sim):
    """Angular momentum about the disk's centre."""
    r, v = field(sim, "x") - CENTRE, field(sim, "v")
    return (field(sim, "m") * (r[:, 0] * v[:, 1] - r[:, 1] * v[:, 0])).sum()
