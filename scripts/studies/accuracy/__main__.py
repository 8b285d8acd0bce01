"""Compares estimated errors of runs with their true ones; see scripts/accuracy."""

from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
from studies.accuracy.problems import problems
from studies.harness import options_of, origin, table

import pgimp
from pgimp.case.accuracy.entry import Accuracy
from pgimp.mpi.comm import Serial
from pgimp.utilities.accuracy import quantity
from pgimp.utilities.accuracy.found import Companions

#: The true error may be so many times the estimated one.
TIMES = 2.0
#: True errors, over the exact value, that are rounding.
ROUNDING = 1e-9


def measured(case, changes, quantities):
    """Quantity, value, exact value and estimated error of each quantity, order; seconds."""
    began = process_time()
    with TemporaryDirectory() as folder:
        run = pgimp.run(
            case, Serial(), Path(folder) / "run", overrides=changes, error=True, quiet=True
        )
        known, found = Companions(run.path), []
        for of, at, exact in quantities:
            entry = Accuracy(of=of, at=at, within=1.0)
            others = [(ratio, quantity.curve(entry, path)) for ratio, path in known.runs]
            one = quantity.found(entry, quantity.curve(entry, run.path), others)
            found.append((entry.label, one.value, exact, one.error, one.order))
    return found, process_time() - began


def main():
    """Print the table."""
    options = options_of("accuracy", words={"nargs": "*", "help": "only problems with these words"})
    rows, ratios = [], []
    for name, case, changes, quantities in problems():
        if options.words and not any(word in name for word in options.words):
            continue
        found, seconds = measured(case, changes, quantities)
        for label, value, exact, error, order in found:
            true = abs(abs(value) - abs(exact)) if "@max" in label else abs(value - exact)
            size = abs(exact) or 1.0
            good = true <= TIMES * error or true <= ROUNDING * size
            ratio = true / error if error else 0.0 if true <= ROUNDING * size else np.inf
            ratios.append((good, ratio))
            rows.append(
                (name, f"`{label}`", f"{exact:.6g}", f"{100.0 * true / size:.2g} %",
                 f"{100.0 * error / size:.2g} %", f"{ratio:.2g}", "" if good else "more",
                 "" if order is None else f"{order:.2f}")
            )  # fmt: skip
            print(*rows[-1], f"{seconds:.1f} s", flush=True)
    print(
        table(
            ("problem", "quantity", "exact", "true error", "estimated", "ratio", "", "order"), rows
        )
    )
    good = sum(one for one, _ in ratios)
    print(
        f"{good} of {len(ratios)} within {TIMES:g} times the estimate ({good / len(ratios):.0%}); "
        f"median ratio {np.median([r for _, r in ratios]):.2g}. {origin()}"
    )


if __name__ == "__main__":
    main()
