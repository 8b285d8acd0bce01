"""Runs the paper's examples and draws its figures; see scripts/paper."""

import argparse
import sys
from pathlib import Path
from time import perf_counter

from common import ROOT, plt
from figures import convergence, profiles, tables
from figures.runs import keep, perform_all, recall
from studies.harness import origin


def main():
    parser = argparse.ArgumentParser(prog="scripts/paper")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "paper.out", metavar="DIR")
    parser.add_argument("--quick", action="store_true", help="fewer and coarser cells")
    parser.add_argument("--redraw", action="store_true", help="draw from the runs that are there")
    parser.add_argument("--docs", action="store_true", help="also its picture in docs/")
    parser.add_argument("-j", "--jobs", type=int, default=2, help="runs at a time")
    arguments = parser.parse_args()
    if arguments.jobs < 1:
        parser.error("-j, --jobs: at least 1")
    if arguments.docs and arguments.quick:
        parser.error("--docs shows the whole reproduction: leave --quick out")
    folder = arguments.output
    store = folder / "runs.json"
    if arguments.redraw and not store.exists():
        parser.error(f"--redraw: there are no runs in {folder}")
    folder.mkdir(parents=True, exist_ok=True)
    began = perf_counter()
    if not arguments.redraw:
        runs = [*profiles.runs(arguments.quick), *convergence.runs(arguments.quick)]
        keep(perform_all(runs, arguments.jobs), f"one core of {origin()}", store)
    results, source = recall(store)
    # The figures are shown at their size, not in a page's column.
    plt.rcParams["savefig.dpi"] = 130
    profiles.draw(results, folder)
    convergence.draw(results, folder)
    tables.write(results, source, folder)
    if arguments.docs:
        plt.rcParams["savefig.dpi"] = 110
        convergence.for_docs(results, source)
    print(f"paper: figures and tables in {folder}, {perf_counter() - began:.0f} s")


if __name__ == "__main__":
    sys.exit(main())
