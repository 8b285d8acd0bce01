"""Kernels that only others call: as good as others there, refused elsewhere."""

import pytest

from pgimp.jit.kernel import inner_kernel, kernel


@inner_kernel
def twice(x):
    return 2.0 * x


@kernel
def plus_one(x):
    return twice(x) + 1.0


def test_it_is_called_by_kernels_alone():
    for _ in range(2):  # then it is compiled
        with pytest.raises(TypeError, match="twice is for other kernels"):
            twice(1.0)
        assert plus_one(1.0) == 3.0
