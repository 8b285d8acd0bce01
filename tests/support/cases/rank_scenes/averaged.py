"""Bodies with averaged mass, some beside others with lumped mass."""

from rank_scenes.damped_bodies import damped
from rank_scenes.initial_bodies import exact_surfaces, initial_contact, initial_lattice
from rank_scenes.periods import endless


def averaged_lattice():
    """Whole cells, cut ones, and a rod with lumped mass; held, at constraints, with `auto`."""
    case = initial_lattice()
    case["method"]["mass"] = "averaged"
    case["bodies"]["rod"]["mass"] = "lumped"
    case["bodies"]["rotor"]["region"]["box"]["max"] = [14.7, 6.0]
    return case


def averaged_contact():
    """Bodies of several velocity fields meet each other, tools and a floor."""
    case = initial_contact()
    case["method"]["mass"] = "averaged"
    return case


def averaged_layers():
    """Layers that are periodic across both seams."""
    case = endless()
    case["method"]["mass"] = "averaged"
    return case


def averaged_grip():
    """A beam beside bodies in the current configuration, damped, at a grip that a force moves."""
    case = damped()
    case["bodies"]["beam"]["mass"] = "averaged"
    return case


def averaged_surfaces():
    """Bodies exact to their surface, both with slaves, and one with lumped mass beside them."""
    case = exact_surfaces()
    case["method"]["mass"] = "averaged"
    bodies = case["bodies"]
    bodies["bar"]["region"]["box"] = {"min": [0.0, 0.98], "max": [14.03, 3.02]}
    bodies["chip"] = bodies["disk"] | {
        "mass": "lumped", "region": {"box": {"min": [9.4, 5.2], "max": [11.02, 7.1]}}
    }  # fmt: skip
    return case
