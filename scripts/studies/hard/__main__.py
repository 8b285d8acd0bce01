"""Runs the hard cases with every method and maps the stable Courant numbers; see scripts/hard."""

from time import perf_counter

from studies.hard.jobs import jobs
from studies.hard.locking import locking_table
from studies.hard.rows import METHODS
from studies.hard.table import cases_table, courant_table, merged, moving_table, write_limits
from studies.harness import Kept, key, options_of, out, perform, put, write_csv

#: Of these "mean" is the part of "courant" that depends on Poisson's ratio.
WORDS = ("cases", "courant", "mean", "moving", "locking", "pictures")
#: By name: the jobs that it shows, what writes it, and the file of the records.
TABLES_OF = {
    "hard-cases": ("case", cases_table, "hard.csv"),
    "courant": ("courant", courant_table, "courant.csv"),
    "moving": ("moving", moving_table, "moving.csv"),
    "locking": ("locking", locking_table, "locking.csv"),
}


def main():
    """Run what is asked for, and write hard.csv, hard.md and docs/hard-cases.md."""
    options = options_of(
        "hard", words={"nargs": "*", "metavar": "WHAT", "among": WORDS},
        quick="minutes; writes no page", redraw="tables from what is there",
        only={"among": METHODS, "metavar": "SHAPE,..", "help": "the others stay"},
        jobs={"type": int, "default": 2, "help": "processes"},
    )  # fmt: skip
    words, only = options.words or [word for word in WORDS if word != "mean"], options.only
    folder = out("hard")
    kept = Kept(folder / ("quick.json" if options.quick else "hard.json"))
    todo = jobs(options.quick, words, only)
    began = perf_counter()
    for number, (name, found) in enumerate(
        perform({} if options.redraw else todo, options.jobs), 1
    ):
        kept.add(name, found)
        print(f"hard: {number} of {len(todo)}: {name[1:]}, {perf_counter() - began:.0f} s",
              flush=True)  # fmt: skip
    texts = {}
    for name, (kind, written, file) in TABLES_OF.items():
        if records := [kept[key(n)] for n in todo if n[0] == kind and key(n) in kept]:
            write_csv(records, folder / file)
            texts[name] = written(records)
            if (only or "mean" in words) and kind != "locking":
                texts[name] = merged(name, texts[name])
    print("\n".join(texts.values()))
    put(texts, folder / "hard.md", not options.quick)
    if "courant" in texts and not options.quick:
        write_limits(texts["courant"])
    if "pictures" in words and not options.quick:
        from studies.hard.pictures import draw

        draw()
