import gc

import pytest

from pgimp.jit.compiled.collector import spared


@pytest.fixture(autouse=True)
def nothing_is_spared():
    """As in a program that leaves the collector alone, unlike that of the tests."""
    gc.unfreeze()
    yield
    gc.freeze()


def test_objects_are_spared_meanwhile():
    """What exists is not searched for garbage; afterwards all is as before, also on errors."""
    gc.collect()
    tracked = len(gc.get_objects())
    with spared():
        assert gc.get_freeze_count() >= 0.9 * tracked
        assert len(gc.get_objects()) < 0.1 * tracked
    assert gc.get_freeze_count() == 0
    with pytest.raises(ValueError, match="wrong"), spared():
        raise ValueError("wrong")
    assert gc.get_freeze_count() == 0


def test_a_program_that_spares_its_objects_keeps_them():
    gc.freeze()
    try:
        new = [[] for _ in range(10_000)]  # not frozen: they would be if it froze again
        frozen = gc.get_freeze_count()  # a few of these may die meanwhile
        with spared():
            assert frozen - 1000 < gc.get_freeze_count() <= frozen
        assert frozen - 1000 < gc.get_freeze_count() <= frozen
        assert len(new) == 10_000
    finally:
        gc.unfreeze()
