"""``pgimp doctor``: checks that MPI, HDF5, h5py and Numba exist and fit together, with remedies.

The checks are in `pgimp.utilities.doctor`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from pgimp.utilities.doctor import hdf5, kernels, machine, mpi
from pgimp.utilities.doctor.finding import Finding


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add nothing: the command has no options."""


def execute(args: argparse.Namespace) -> int:
    """Print the report.

    Returns
    -------
    int
        0 if the installation works, 1 if something is broken.
    """
    findings: list[Finding] = []
    for finding in _examine():
        print(f"{finding.mark:<6} {finding.part:<12} {finding.found}", flush=True)
        findings.append(finding)
    wrong = [finding for finding in findings if finding.broken]
    for title, some in (
        ("What to do:", wrong),
        ("What could be better:", [f for f in findings if f.cure and not f.broken]),
    ):
        if some:
            print(f"\n{title}")
            for finding in some:
                print(f"  {finding.part}: {finding.cure}")
    if not wrong:
        print("\npgimp works here.")
    return 1 if wrong else 0


def _examine() -> Iterator[Finding]:
    yield from machine.examine()
    yield from kernels.examine()
    answer, findings = mpi.examine()
    yield from findings
    yield from hdf5.examine(answer)
    yield from mpi.launchers(answer)
