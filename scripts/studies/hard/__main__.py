"""Runs the hard cases with every method and maps the stable Courant numbers; see scripts/hard."""

import argparse
import json
import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from time import perf_counter

from studies.hard.jobs import jobs
from studies.hard.locking import locking_table
from studies.hard.rows import METHODS
from studies.hard.runs import ROOT
from studies.hard.table import (
    cases_table,
    courant_table,
    merged,
    moving_table,
    put_into_docs,
    write_csv,
)

OUT = ROOT / "hard.out"
#: Of these "mean" is the part of "courant" that depends on Poisson's ratio.
WORDS = ("cases", "courant", "mean", "moving", "locking", "pictures")


def main():
    """Run what is asked for, and write hard.csv, hard.md and docs/hard-cases.md."""
    parser = argparse.ArgumentParser(prog="scripts/hard")
    parser.add_argument("words", nargs="*", metavar="WHAT", help=", ".join(WORDS))
    parser.add_argument("--quick", action="store_true", help="minutes; writes no page")
    parser.add_argument("--redraw", action="store_true", help="tables from what is there")
    parser.add_argument("--only", default="", metavar="SHAPE,..", help="the others stay")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    options = parser.parse_args()
    words = options.words or [word for word in WORDS if word != "mean"]
    only = tuple(filter(None, options.only.split(",")))
    for word in words:
        if word not in WORDS:
            parser.error(f"there is no {word}; there are {', '.join(WORDS)}")
    for name in only:
        if name not in METHODS:
            parser.error(f"there is no {name}; there are {', '.join(METHODS)}")
    OUT.mkdir(exist_ok=True)
    store = OUT / ("quick.json" if options.quick else "hard.json")
    kept = json.loads(store.read_text()) if store.exists() else {}
    if not options.redraw:
        began = perf_counter()
        todo = jobs(options.quick, words, only)
        with ProcessPoolExecutor(min(options.jobs, os.cpu_count()), get_context("spawn")) as pool:
            waiting = {pool.submit(*job): key for key, job in todo.items()}
            for number, future in enumerate(as_completed(waiting), 1):
                key = waiting[future]
                kept["/".join(map(str, key))] = future.result()
                print(f"hard: {number} of {len(waiting)}: {key[1:]}, "
                      f"{perf_counter() - began:.0f} s", flush=True)  # fmt: skip
                store.write_text(json.dumps(kept, indent=1))
    keys = ["/".join(map(str, key)) for key in jobs(options.quick, words, only)]
    records = [kept[key] for key in keys if key.startswith("case") and key in kept]
    points = [kept[key] for key in keys if key.startswith("courant") and key in kept]
    moves = [kept[key] for key in keys if key.startswith("moving") and key in kept]
    beams = [kept[key] for key in keys if key.startswith("locking") and key in kept]
    texts = []
    if records:
        write_csv(records, OUT / "hard.csv")
        texts.append(("hard-cases", cases_table(records)))
    if points:
        write_csv(points, OUT / "courant.csv")
        texts.append(("courant", courant_table(points)))
    if moves:
        write_csv(moves, OUT / "moving.csv")
        texts.append(("moving", moving_table(moves)))
    if only or "mean" in words:
        texts = [(name, merged(name, text)) for name, text in texts]
    if beams:
        write_csv(beams, OUT / "locking.csv")
        texts.append(("locking", locking_table(beams)))
    (OUT / "hard.md").write_text("\n".join(text for _, text in texts), encoding="utf-8")
    for _, text in texts:
        print(text)
    if not options.quick:
        put_into_docs(texts)
    if "pictures" in words and not options.quick:
        from studies.hard.pictures import draw

        draw()
