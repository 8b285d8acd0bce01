"""Compiling and caching of kernels, vectors of four numbers, and tensor algebra on tuples.

Settings that Numba needs before its import are made here, as any module of this folder may import
it:

- ``NUMBA_LOOP_VECTORIZE=0``: in a loop that LLVM vectorises, contraction to fused multiply-adds
  differs between the vector body and the scalar remainder. A particle's bits would then depend on
  its offset in the array. Kernels use explicit vectors instead (`pgimp.jit.vectors.simd`).
- ``NUMBA_DISABLE_INTEL_SVML=1``: the vector maths library rounds differently from libm.
- ``NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING=1``: where colorama is installed, Numba would write
  control characters to stdout at the end.
"""

import os

from pgimp.jit.compiled.folder import SETTINGS

os.environ.update(SETTINGS)
os.environ["NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING"] = "1"
