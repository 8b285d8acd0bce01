"""Measures every method on small bodies and writes docs/methods.md; see scripts/methods."""

import argparse
import json
from itertools import product
from time import process_time

from method_bodies import SHAPES
from method_measures import COURANTS, bending, bounced, compressed, costs, turned, waves
from method_table import ROOT, origin, put_into_docs, text, write_csv

OUT = ROOT / "methods.out"


def measured(method):
    """Everything of a method but its cost; numbers of 2D and 3D end with the dimension."""
    record = dict(zip(("shape", "affine", "per_cell"), method, strict=True))
    for D in (2, 3):
        courants = COURANTS if (D, method[2]) == (2, 2) else COURANTS[:1]
        parts = bending(method, D, courants), bounced(method, D), turned(method, D, courants)
        record |= {f"{key} {D}": value for part in parts for key, value in part.items()}
    return record | waves(method) | compressed(method)


def main():
    """Measure, and write methods.json, methods.csv, methods.md and docs/methods.md."""
    parser = argparse.ArgumentParser(prog="scripts/methods")
    parser.add_argument("--redraw", action="store_true", help="tables from what is there")
    options = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    store = OUT / "methods.json"
    if not options.redraw:
        methods = [(s, a, n) for n, s, a in product((2, 1), SHAPES, (False, True))]
        methods = [m for m in methods if m[0] != "fuzzy-nearest" or m[2] > 1]  # as fuzzy-constant
        records = []
        for method in methods:
            began = process_time()
            records.append(measured(method))
            print(f"methods: {method}, {process_time() - began:.0f} s", flush=True)
        for D in (2, 3):
            for record, cost in zip(records, costs(methods, D).values(), strict=True):
                record[f"cost {D}"] = cost
        store.write_text(json.dumps({"origin": origin(), "records": records}, indent=1))
    kept = json.loads(store.read_text())
    write_csv(kept["records"], OUT / "methods.csv")
    found = text(kept["records"], kept["origin"])
    (OUT / "methods.md").write_text(found, encoding="utf-8")
    put_into_docs(found)
    print(found)


if __name__ == "__main__":
    main()
