"""The clock of the benchmarks: wall time, or on a machine that does other things the CPU's.

CPU time is that of a process alone, even on a shared core. It is of no use for
several ranks, which wait for each other without rest.
"""

import os
from time import perf_counter, process_time

#: Variable that chooses the CPU's time, also in workers.
VARIABLE = "PGIMP_BENCHMARK_CPU_TIME"


def clock():
    """Seconds since some moment."""
    return process_time() if os.environ.get(VARIABLE) else perf_counter()
