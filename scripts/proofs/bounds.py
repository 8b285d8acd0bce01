"""Indices checked in every kernel, where the environment says so; imported before all kernels.

Numba does not check them: an index past the end reads or writes whatever is there. Loads and stores
of four particles at once stay unchecked.
"""

import os

VARIABLE = "FAULTS_BOUNDS"

if os.environ.get(VARIABLE):
    # Not where kernels without checks are kept.
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    os.environ["PGIMP_CACHE_DIR"] = os.path.join(cache, "pgimp-bounds")
    from pgimp.jit import kernel

    kernel._OPTIONS["boundscheck"] = kernel.INLINE_OPTIONS["boundscheck"] = True
