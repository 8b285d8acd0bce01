"""Close boxes, against a loop over all pairs."""

import numpy as np
import pytest

from pgimp.geometry.sweep import close_pairs


@pytest.mark.parametrize("D", [1, 2, 3])
@pytest.mark.parametrize("count", [0, 1, 40])
def test_all_close_boxes_are_found_once_in_order(D, count):
    rng = np.random.default_rng((D, count))
    low = rng.integers(0, 12, (count, D)).astype(float)
    high, wide = low + rng.integers(0, 3, (count, D)), np.arange(1.0, D + 1.0)
    low[3:5], high[3:5] = np.inf, -np.inf  # bodies without particles
    found = close_pairs(low, high, wide)
    listed = [tuple(pair) for pair in found.tolist()]
    assert listed == sorted(set(listed)) and found.shape == (len(listed), 2)
    for a in range(count):
        for b in range(a + 1, count):
            apart = np.maximum(low[a], low[b]) - np.minimum(high[a], high[b])
            assert (a, b) in listed or (apart > wide).any()
    if count > 1:
        assert 0 < len(listed) < count * (count - 1) // 4 and not {3, 4} & {*np.unique(found)}
