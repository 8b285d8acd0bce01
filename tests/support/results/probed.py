"""Runs with probes."""

from scenes import write_case

import pgimp


def run(folder, case, **options):
    """Run a case in this process and return its results."""
    write_case(folder / "case.yaml", case)
    return pgimp.run(folder / "case.yaml", output=folder / "out", quiet=True, **options)
