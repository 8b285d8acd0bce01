"""Measures every method on small bodies and writes docs/methods.md; see scripts/methods."""

from itertools import product
from time import process_time

from studies.harness import Kept, options_of, origin, out, put, write_csv
from studies.method.bodies import SHAPES, Method
from studies.method.measures import COURANTS, bending, bounced, compressed, costs, turned, waves
from studies.method.table import added, text

#: The method that costs are relative to.
PLAIN = Method("gimp")
#: What `--only` may name.
CHOICES = (*SHAPES, "initial")


def measured(method):
    """Everything of a method but its cost; numbers of 2D and 3D end with the dimension."""
    record = method._asdict()
    for D in (2, 3):
        courants = COURANTS if (D, method[2]) == (2, 2) else COURANTS[:1]
        parts = bending(method, D, courants), bounced(method, D), turned(method, D, courants)
        record |= {f"{key} {D}": value for part in parts for key, value in part.items()}
    return record | waves(method) | compressed(method)


def main():
    """Measure, and write methods.json, methods.csv, methods.md and docs/methods.md."""
    some = {"among": CHOICES, "metavar": "SHAPE,..", "help": "the others stay"}
    options = options_of("methods", redraw="tables from what is there", only=some)
    only = options.only
    store = out("methods") / ("some.json" if only else "methods.json")
    kept = Kept(store)
    if not options.redraw:
        # What costs are relative to is always there.
        shapes = [name for name in only or CHOICES if name in SHAPES]
        methods = [Method(s, a, n) for n, s, a in product((2, 1), shapes, (False, True))]
        # With one particle a cell these are others.
        twins = ("fuzzy-nearest", "bspline-quadratic")
        methods = [m for m in methods if m.shape not in twins or m.per_cell > 1]
        if not only or "initial" in only:
            methods.insert(0, Method("gimp", configuration="initial"))
        records = []
        for method in methods:
            began = process_time()
            records.append(measured(method))
            print(f"methods: {method}, {process_time() - began:.0f} s", flush=True)
        for D in (2, 3):
            found = costs([*dict.fromkeys([PLAIN, *methods])], D)
            for record, method in zip(records, methods, strict=True):
                record |= {f"cost {D}": found[method], f"plain {D}": found[PLAIN]}
        kept |= {"origin": origin(), "records": records}
        kept.save()
    write_csv(kept["records"], store.with_suffix(".csv"))
    write = added if only else text
    found = write(kept["records"], kept["origin"])
    put({"methods": found}, store.with_suffix(".md"))
    print(found)
