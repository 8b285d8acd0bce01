"""Empty space: the same body in a domain eight times larger in every direction."""

from statistics import median

from blocks import PAD, block
from report import ERRORS, number, origin, write
from workers.processes import Worker, launch

from pgimp.solver.simulation import RESORT

FACTOR = 8
#: What is allowed of time and memory.
LIMIT = 1.05


def pads(cells, factor):
    """Empty cells beyond the body's ends, in a domain `factor` times larger around the middle."""
    found = []
    for n in cells:
        more = factor * (n + 2 * PAD) - n
        found.append((more // 2, more - more // 2))
    return found


def main(folder, quick):
    sizes = [(16, 16)] if quick else [(32, 32, 32), (256, 256)]
    rounds, steps = (3, 4) if quick else (12, RESORT // 2)
    rows = []
    for cells in sizes:
        workers = {factor: Worker(launch(1, ["workers/pgimp_worker.py"])) for factor in (1, FACTOR)}
        try:
            memory = {}
            for factor, worker in workers.items():
                case = block(cells, pad=pads(cells, factor))
                words = {"case": case, "random": True, "steps": steps}
                memory[factor] = worker.ask(do="make", name="it", **words)["memory"]
            seconds = {factor: [] for factor in workers}
            for _ in range(rounds):
                for factor, worker in workers.items():
                    seconds[factor].append(worker.ask(do="round", name="it")["seconds"])
            for factor, worker in workers.items():
                found = worker.ask(do="result", name="it")
                shares = [a / b for a, b in zip(seconds[factor], seconds[1], strict=True)]
                domain = [factor * (n + 2 * PAD) for n in cells]
                rows.append({
                    "dimension": len(cells), "body": " x ".join(map(str, cells)),
                    "domain": " x ".join(map(str, domain)), "speed": found["speed"],
                    "time": median(shares), "times": shares, "memory": memory[factor],
                    "memory ratio": memory[factor] / memory[1], "velocity": found["velocity"],
                    "stress": found["stress"],
                })  # fmt: skip
        finally:
            for worker in workers.values():
                worker.close()
    columns = {
        "body [cells]": lambda row: row["body"],
        "domain [cells]": lambda row: row["domain"],
        "million particle-steps/s": lambda row: number(row["speed"]),
        "time": lambda row: number(row["time"], 3),
        "memory [MB]": lambda row: number(row["memory"] / 1e6),
        "memory": lambda row: number(row["memory ratio"], 3),
    } | ERRORS
    note = (
        f"Time and memory over those in the smaller domain; at most {LIMIT} is wanted. Medians of "
        f"{rounds} rounds of {steps} steps by turns, on one core; memory is the peak (VmHWM) of "
        f"set-up and steps beyond what the process has before. {origin()}"
    )
    write(folder, "domain", "Eight times the domain", columns, rows, note)
    return rows
