"""Bonded bodies and their velocity fields, against loops over all pairs."""

from itertools import combinations

import numpy as np
import pytest

from pgimp.physics.contact.base import TIED
from pgimp.physics.contact.pairs import ContactEntry, Pairs
from pgimp.solver.contact.impulses.bonds import bonded


def random_pairs(rng, count):
    """Laws of some bodies, often of a few only."""
    names = [f"body{n}" for n in range(count)]

    def entry(bodies):
        law = str(rng.choice(["friction", "tie", "ignore"]))
        return ContactEntry.model_validate({"bodies": bodies, "law": law})

    entries = [entry("all")] * int(rng.random() < 0.6)
    for _ in range(rng.integers(0, 3)):
        some = rng.permutation(count)[: rng.integers(2, count + 1)]
        entries.append(entry([names[n] for n in some]))
    return Pairs.of(entries, names)


def way_of(pairs, a, b):
    """How two bodies act on each other."""
    law = abs(int(pairs.entry[min(a, b), max(a, b)]))
    return None if law == 0 else pairs.kind[law - 1]


@pytest.mark.parametrize("seed", range(40))
def test_groups_and_fields(seed):
    rng = np.random.default_rng(seed)
    n, rigid = int(rng.integers(2, 9)), int(rng.integers(0, 3))
    D = int(rng.integers(1, 4))
    pairs, lagrangian = random_pairs(rng, n + rigid), rng.random(n) < rng.choice([1.0, 0.6])
    low = rng.uniform(0.0, 9.0, (n, D))
    high, reach = low + rng.uniform(0.0, 3.0, (n, D)), rng.uniform(0.5, 2.0, D)
    fields, groups = bonded(pairs, low, high, reach, lagrangian)

    def touch(a, b):
        return (np.maximum(low[a] - high[b], low[b] - high[a]) < reach).all()

    linked = np.eye(n, dtype=bool)
    for a, b in combinations(range(n), 2):
        alike = lagrangian[a] == lagrangian[b] and way_of(pairs, a, b) == TIED
        linked[a, b] = linked[b, a] = alike and (touch(a, b) or not lagrangian[a])
    for _ in range(n):
        linked = linked @ linked
    assert np.array_equal(linked, groups[:, None] == groups)
    for a, b in combinations(range(n), 2):
        if groups[a] == groups[b]:
            assert fields[a] == fields[b]
        elif not (lagrangian[a] and lagrangian[b]) or touch(a, b):
            assert fields[a] != fields[b]
