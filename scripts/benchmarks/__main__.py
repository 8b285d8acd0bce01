"""The measurements that the command line names; see scripts/benchmark.

Each part is a module with ``main(folder, quick)``, which writes PART.md and what else it has into
the folder; or a program, whose output becomes PART.md.
"""

import argparse
import importlib
import os
import subprocess
import sys
from pathlib import Path
from time import perf_counter

import page
from report import ROOT, origin
from workers.clock import VARIABLE

PARTS = (
    "kernels", "peers", "domain", "features", "scaling", "instructions", "output",
    "balance", "bodies", "compile",
)  # fmt: skip
#: Parts that are programs: their words, and those if all is to be quick.
PROGRAMS = {"output": ([], ["--quick"]), "balance": ([], ["--quick"]), "bodies": ([], ["--quick"])}


def run(part, folder, quick):
    """Run a part that is a program; a status other than 0 says that something is not as wanted."""
    program = Path(__file__).resolve().with_name(f"{part}.py")
    command = [sys.executable, str(program), *PROGRAMS[part][quick]]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True)
    print(done.stdout)
    text = f"## {part.capitalize()}\n\n{done.stdout}\n{origin()}\n"
    (folder / f"{part}.md").write_text(text, encoding="utf-8")
    if done.returncode:
        print(f"benchmark: {part} ended with status {done.returncode}", file=sys.stderr)


def main():
    """Measure what is asked for, and write benchmark.md and page.md."""
    parser = argparse.ArgumentParser(prog="scripts/benchmark")
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, default=ROOT / "benchmark.out")
    parser.add_argument("--quick", action="store_true", help="small blocks: no figures to keep")
    parser.add_argument("--prototype", metavar="KERNELS.PY", help="a script to compare with")
    parser.add_argument("--beside", metavar="CHECKOUT", help="compile: another one, by turns")
    parser.add_argument("--cpu-time", action="store_true", help="on a machine that is busy")
    parser.add_argument("--docs", action="store_true", help="also write docs/performance.md")
    options = parser.parse_args()
    unknown = sorted(set(options.parts) - set(PARTS))
    if unknown:
        parser.error(f"there is no part {unknown[0]}; there are {', '.join(PARTS)}")
    if options.prototype and not Path(options.prototype).is_file():
        parser.error(f"there is no prototype {options.prototype}")
    if options.beside and not (Path(options.beside) / "pgimp").is_dir():
        parser.error(f"{options.beside} is no checkout of pgimp")
    if options.cpu_time:
        os.environ[VARIABLE] = "1"
    folder = options.output
    folder.mkdir(parents=True, exist_ok=True)
    for part in options.parts or PARTS:
        began = perf_counter()
        if part in PROGRAMS:
            run(part, folder, options.quick)
        else:
            more = {"peers": {"prototype": options.prototype},
                    "compile": {"beside": options.beside}}.get(part, {})  # fmt: skip
            importlib.import_module(part).main(folder, options.quick, **more)
        print(f"benchmark: {part} took {perf_counter() - began:.0f} s\n", flush=True)
    texts = [f"# Benchmarks\n\n{origin()}\n"]
    for part in PARTS:
        for path in sorted(folder.glob(f"{part}*.md")):
            texts.append(path.read_text(encoding="utf-8"))
    (folder / "benchmark.md").write_text("\n".join(texts), encoding="utf-8")
    page.write(folder, options.docs and not options.quick)


if __name__ == "__main__":
    main()
