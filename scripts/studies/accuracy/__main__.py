"""Compares estimated errors of runs with their true ones; see scripts/accuracy."""

from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
from studies.accuracy.problems import problems
from studies.harness import Table, options_of, origin, out, put, write_csv

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
    """Quantity, exact and found value, true and estimated error, and order, of each quantity."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run"
        run = pgimp.run(case, Serial(), path, overrides=changes, error=True, quiet=True)
        known = Companions(run.path)
        for of, at, exact in quantities:
            entry = Accuracy(of=of, at=at, within=1.0)
            others = [(ratio, quantity.curve(entry, path)) for ratio, path in known.runs]
            one = quantity.found(entry, quantity.curve(entry, run.path), others)
            # The greatest size may come with either sign.
            true = abs(abs(one.value) - abs(exact)) if at == "max" else abs(one.value - exact)
            good = true <= max(TIMES * one.error, ROUNDING * abs(exact))
            yield {"quantity": entry.label, "exact": exact, "found": one.value, "true": true,
                   "estimated": one.error, "order": one.order, "good": bool(good)}  # fmt: skip


def percent(values):
    """The range of some parts, in per cent."""
    least, most = (f"{100.0 * value:.2g}" for value in (min(values), max(values)))
    return f"{least} %" if least == most else f"{least} to {most} %"


def main():
    """Print the table, and write it."""
    options = options_of(
        "accuracy", docs="also write the page",
        words={"nargs": "*", "help": "only problems with one of these words"},
    )  # fmt: skip
    records, rows = [], Table("problem", "quantities", "true errors", "estimated", "within")
    print("\n".join(rows.lines))
    for name, case, changes, quantities in problems():
        if options.words and not any(word in name for word in options.words):
            continue
        began = process_time()
        found = list(measured(case, changes, quantities))
        records += [{"problem": name, "seconds": process_time() - began} | one for one in found]
        size = [abs(one["exact"]) or 1.0 for one in found]
        true, guess = ([one[key] / scale for one, scale in zip(found, size, strict=True)]
                       for key in ("true", "estimated"))  # fmt: skip
        good = sum(one["good"] for one in found)
        rows.add(name, len(found), percent(true), percent(guess), f"{good} of {len(found)}")
    good = sum(one["good"] for one in records)
    ratio = np.median([one["estimated"] / one["true"] for one in records if one["true"]])
    note = (
        f"{good} of {len(records)} true errors ({100.0 * good / len(records):.0f} %) are within "
        f"twice the estimate, which is {ratio:.2g} times the true error in the median.\n\n"
        f"Measured on {origin()}."
    )
    print(f"\n{note}")
    write_csv(records, out("accuracy") / "errors.csv")
    put({"estimated-errors": rows.text(note)}, page=options.docs)


if __name__ == "__main__":
    main()
