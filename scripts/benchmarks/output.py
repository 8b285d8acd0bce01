"""How fast frames and checkpoints are written, beside what the disk takes, on one and two ranks.

Prints Markdown. Beside each frame and checkpoint a file of the same size is written as
``dd bs=4M conv=fsync`` does, by turns, so that all of them meet the same disk; medians count. A
frame counts twice: what the run waits for, and until the file has its name, on the disk.
"""

import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

from report import table
from workers.processes import environment, launch

import pgimp
from pgimp.mpi.comm import world
from pgimp.running.checkpoints import Checkpoints
from pgimp.running.frames import Frames
from pgimp.solver.simulation import Simulation

CASE = Path(__file__).resolve().parents[2] / "cases" / "block3d.yaml"
#: The block begins on the floor, so that there are waves in it soon.
BLOCK = (
    "bodies.block.region={box: {min: [0.4, 0.2, 0.0], max: [1.6, 1.0, 0.8]}}",
    "bodies.block.velocity=[1.0, 0.5, -1.0]",
    "bodies.block.formulation=updated-lagrangian",
)
#: Cells, steps before the measurement, repeats, and whether other forms of frames are measured.
SIZES = {
    "small": (0.08, 3, 31, False), "waves": (0.04, 150, 9, True), "large": (0.016, 3, 7, False),
}  # fmt: skip
FORMS = {
    "as usual": (), "float32": ("output.precision=float32",), "gzip": ("output.compression=gzip",),
    "float32, gzip": ("output.precision=float32", "output.compression=gzip"),
}  # fmt: skip
_MB = 1e6


def raw(path, size, block=os.urandom(4 << 20)):
    """Seconds to write a new file of a size, and have it on the disk."""
    began = perf_counter()
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    left = size
    while left > 0:
        left -= os.write(descriptor, block[:left])
    os.fsync(descriptor)
    os.close(descriptor)
    seconds = perf_counter() - began
    path.unlink()
    return seconds


def work(name, folder):
    """Measure on the ranks that this runs on; rank 0 prints the result as JSON."""
    cell, steps, repeats, every = SIZES[name]
    comm = world()
    words = [*BLOCK, f"grid.cell=[{cell}, {cell}, {cell}]"]
    cases = {
        form: pgimp.load(CASE, overrides=[*words, *more])
        for form, more in FORMS.items()
        if every or not more
    }
    sim = Simulation(cases["as usual"], comm)
    for _ in range(steps):
        sim.advance()
    outputs = {}
    for number, (form, case) in enumerate(cases.items()):
        place = folder / str(number)
        if comm.rank == 0:
            for part in ("frames", "checkpoints"):
                (place / part).mkdir(parents=True)
        comm.Barrier()
        outputs[form] = Frames(place, case, sim), Checkpoints(place, case, sim), place

    def timed(action):
        comm.Barrier()
        began = perf_counter()
        action()
        comm.Barrier()
        return perf_counter() - began

    def beside(path):
        """Size of a file that has been measured, and seconds of a plain one; the file goes."""
        if comm.rank > 0:
            return 0, 0.0
        size = path.stat().st_size
        path.unlink()
        return size, raw(folder / "raw", size)

    found = {form: {} for form in outputs}
    for repeat in range(repeats + 1):
        for form, (frames, checkpoints, place) in outputs.items():
            wait = timed(lambda frames=frames: frames.write(sim))
            rest = timed(frames.finish)
            size, plain = beside(place / "frames" / f"particles-{repeat:06d}.h5")
            row = {"wait": wait, "frame": wait + rest, "size": size, "raw": plain}
            if form == "as usual":
                checkpoints.latest = -1  # else there is one of this step already
                row["checkpoint"] = timed(lambda: checkpoints.write(sim, repeat, repeat))
                path = place / "checkpoints" / f"step-{sim.step:09d}.h5"
                row["checkpoint size"], row["checkpoint raw"] = beside(path)
            if repeat:  # the first one only warms up
                for key, value in row.items():
                    found[form].setdefault(key, []).append(value)
    if comm.rank == 0:
        result = {form: {k: median(v) for k, v in row.items()} for form, row in found.items()}
        print(json.dumps({"count": sim.count, "forms": result}))


def measure(folder, quick=False, ranks=(1, 2)):
    """Measure frames and checkpoints in a folder on the disk in question, which is left as it was.

    By ``(name, ranks)`` the number of particles, and by form of the frames medians: sizes in bytes,
    seconds of the frame, of its part that the run waits for, of the checkpoint and of plain files.
    """
    found = {}
    for name in list(SIZES)[: 2 if quick else None]:
        for n in ranks:
            with tempfile.TemporaryDirectory(dir=folder) as place:
                command = launch(n, [Path(__file__).name, "--worker", name, "--folder", place])
                done = subprocess.run(
                    command, env=environment(), capture_output=True, text=True, timeout=1800
                )
            if done.returncode:
                raise SystemExit(f"benchmark: {name} on {n} ranks failed:\n{done.stderr}")
            found[name, n] = json.loads(done.stdout.splitlines()[-1])
    return found


def report(found):
    """Lay out what `measure` returns as Markdown."""
    speeds, forms = [], []
    for (name, ranks), result in found.items():
        usual = result["forms"]["as usual"]
        for what, size, seconds, plain in (
            ("frame, the run waits", "size", "wait", "raw"),
            ("frame, on the disk", "size", "frame", "raw"),
            ("checkpoint", "checkpoint size", "checkpoint", "checkpoint raw"),
        ):
            taken, disk, amount = usual[seconds], usual[plain], usual[size] / _MB
            speeds.append([
                f"{result['count']:,}", ranks, what, f"{amount:.1f}", f"{1e3 * taken:.1f}",
                f"{amount / taken:.0f}", f"{amount / disk:.0f}", f"{disk / taken:.2f}",
            ])  # fmt: skip
        if len(result["forms"]) > 1:
            forms += [
                [
                    f"{result['count']:,}", ranks, form, f"{row['size'] / _MB:.1f}",
                    f"{usual['size'] / row['size']:.2f}", f"{1e3 * row['wait']:.1f}",
                    f"{usual['size'] / _MB / row['frame']:.0f}",
                ]
                for form, row in result["forms"].items()
            ]  # fmt: skip
    head = ("particles", "ranks", "what", "MB", "ms", "MB/s", "dd conv=fsync, MB/s", "of dd")
    other = ("particles", "ranks", "frames", "MB", "smaller by", "the run waits, ms", "MB/s*")
    return (
        f"{table(head, speeds)}\n\n{table(other, forms)}\n\n"
        "\\* of uncompressed float64, until the file is on the disk"
    )


def main():
    """Measure in a folder and print Markdown."""
    parser = argparse.ArgumentParser(description="How fast frames and checkpoints are written.")
    parser.add_argument("--folder", type=Path, default=Path.cwd(), help="on the disk in question")
    parser.add_argument("--quick", action="store_true", help="no large frames")
    parser.add_argument("--worker", choices=SIZES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        work(options.worker, options.folder)
    else:
        print(report(measure(options.folder, options.quick)))


if __name__ == "__main__":
    main()
