"""Damaged and lying checkpoints: named and skipped for the one before, or refused in a line."""

import copy
import json
import os
import random
import shutil
import zlib
from collections import Counter
from statistics import median

import numpy as np
from proofs import forks
from proofs.jobs import SHORT, differences, options_of, scratch

import pgimp
from pgimp.io.checkpoints.checkpointfile import CheckpointFile
from pgimp.io.checkpoints.checkpointwriter import write
from pgimp.mpi.comm import Serial
from pgimp.running.checkpoints import present

#: Megabytes that one attempt may take; without damage it takes a tenth of it.
_MEGABYTES = 1500
_MOST_LINES = 12


def main(words):
    """Damage as many checkpoints as asked for; print what became of them."""
    options = options_of("checkpoints", words, 300)
    chance = random.Random(options.seed)
    outcomes, seconds, memory = Counter(), [], []
    with scratch("checkpoints") as (folder, failures):
        os.chdir(folder)
        (folder / "blocks.yaml").write_text(SHORT)
        reference = pgimp.run("blocks.yaml", output="whole", quiet=True)
        for number in range(options.runs):
            name = f"run-{number}"
            shutil.copytree("whole", name)
            info = folder / name / "run.json"
            info.write_text(info.read_text().replace('"done"', '"running"'))
            last, *before = present(folder / name / "checkpoints")
            last.unlink()
            every = number % 4 == 3
            kind = KINDS[number % len(KINDS)]
            for path in before if every else before[:1]:
                kind(path, chance)
            status, said, spent, peak = attempt(["blocks.yaml", "-o", name, "--resume"], folder)
            seconds.append(spent)
            memory.append(peak)
            note = f"{name}, {'all' if every else 'newest'} {kind.__name__}"
            lines = said.splitlines()
            newest = before[0].name
            wrong = []
            if "Traceback" in said or "unexpected" in said or status is None:
                wrong.append(f"status {status}: {said}")
            elif every:
                if status != 1 or "none of the" not in said or len(lines) > _MOST_LINES:
                    wrong.append(f"status {status}: {lines}")
            elif status != 0 or f"{newest} cannot be used: " not in said:
                wrong.append(f"status {status}: {lines}")
            else:
                wrong += differences(reference.path, folder / name)
            if peak > _MEGABYTES or max(map(len, lines), default=0) > 600:
                wrong.append(f"{peak:.0f} MB, lines of {max(map(len, lines))} letters")
            good = "all damaged: status 1" if every else "newest damaged: skipped, same bits"
            outcomes["wrong" if wrong else good] += 1
            failures += [f"{note}: {line}" for line in wrong]
            if not wrong:
                shutil.rmtree(name)
        kinds = ", ".join(kind.__name__ for kind in KINDS)
        print(f"{options.runs} attempts to resume from damaged checkpoints ({kinds}):")
        print("  " + ", ".join(f"{count} {what}" for what, count in outcomes.most_common()))
        print(
            f"  median {median(seconds):.1f} s, most {max(seconds):.1f} s; "
            f"at most {max(memory):.0f} MB, median {median(memory):.0f} MB"
        )
        os.chdir("/")
    return 1 if failures else 0


def attempt(words, folder):
    """Run pgimp in a child: its status (None if it hangs or crashes), words, seconds, megabytes."""
    done = forks.run(words, folder)
    said = (folder / "stdout").read_text(errors="replace") + done.said
    crashed = done.status is not None and done.status < 0
    return None if crashed else done.status, said, done.seconds, done.megabytes


def truncated(path, chance):
    """Cut off the end."""
    os.truncate(path, chance.randrange(path.stat().st_size))


def flipped(path, chance):
    """Flip up to twenty bits anywhere."""
    data = bytearray(path.read_bytes())
    for _ in range(chance.randint(1, 20)):
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    if bytes(data) == path.read_bytes():
        data[0] ^= 1
    path.write_bytes(data)


def overwritten(path, chance):
    """Replace a stretch by zeros or noise, as of a block that was never written."""
    data = bytearray(path.read_bytes())
    start = chance.randrange(len(data) - 4096)
    noise = chance.randbytes(4096)
    zeros = any(data[start : start + 4096]) and chance.random() < 0.5
    data[start : start + 4096] = bytes(4096) if zeros else noise
    path.write_bytes(data)


def replaced(path, chance):
    """Put something else there: nothing, text, another HDF5 file, a folder, a pipe, a dead link."""
    frame = next((path.parents[1] / "frames").glob("*.h5"))
    path.unlink()
    chance.choice([
        lambda: path.write_bytes(b""), lambda: path.write_text("format: 1\n" * 1000),
        lambda: shutil.copy(frame, path), path.mkdir, lambda: os.mkfifo(path),
        lambda: path.symlink_to("nowhere"), lambda: path.symlink_to("/dev/zero"),
    ])()  # fmt: skip


def header_lies(path, chance):
    """Change the header, with the right checksum: offsets, sizes, types, numbers, structure."""
    data = path.read_bytes()
    line, _, rest = data.partition(b"\n")
    tree = json.loads(rest.split(b"\0", 1)[0])
    begin = tree["pieces"][0][0]
    strange = (-1, 2**62, 1e308, "x" * 50, None, [], {}, [[0] * 9] * 9, True, "<f8", 0.5)
    way = [key for key in tree if key != "about"]
    where, key = tree, chance.choice(way)
    while isinstance(where[key], dict | list) and where[key] and chance.random() < 0.8:
        where = where[key]
        key = chance.choice(list(where if isinstance(where, dict) else range(len(where))))
    old = copy.deepcopy(where[key])
    while where[key] == old:
        where[key] = chance.choice(strange)
    text = json.dumps(tree, ensure_ascii=False, separators=(",", ":")).encode()[: begin - 200]
    words = line.split(b", ")
    words[2] = b"header of %d bytes" % len(text)
    words[3] = b"CRC-32 %08x" % zlib.crc32(text)
    path.write_bytes((b", ".join(words) + b"\n" + text).ljust(begin, b"\0") + data[begin:])


def state_lies(path, chance):
    """Rewrite a whole file with something in it that no run has."""
    file = CheckpointFile(path)
    about = copy.deepcopy(file.about)
    rows = {name: file.read(name, 0, file.count).copy() for name in file.rows}
    whole = {name: file.read_whole(name).copy() for name in file.whole}
    state, layers, row = about["state"], whole["layers"], chance.randrange(file.count)
    # Values of a particle, then entries of the file; those that are None go.
    lies = [(rows[name], {row: value}) for name, value in (
        ("x", np.nan), ("x", 1e300), ("x", rows["x"][row] + [3.0, 0.0]), ("v", np.inf),
        ("F", np.nan), ("m", -1.0), ("V0", 0.0), ("body", 7), ("body", -1), ("id", -5),
        ("id", 2**60), ("cell", -1), ("cell", 2**62), ("layer", rows["layer"][row] + 1),
    )]  # fmt: skip
    lies += [(rows, lie) for lie in (
        {name: values[::-1].copy() for name, values in rows.items()},
        {chance.choice(list(rows)): None}, {"x": np.zeros((file.count, 3))},
        {"sigma": rows["sigma"].astype(np.int64)},
        {name: values[:-1].copy() for name, values in rows.items()},
    )]  # fmt: skip
    lies += [(whole, {"layers": lie}) for lie in (
        None, layers[:-1], np.roll(layers, 1), -layers, layers * 2**55
    )]  # fmt: skip
    lies += [(whole, {"work": np.full_like(whole["work"], np.nan)})]
    lies += [(whole, {"impulse": whole["impulse"][:, :1]})]
    lies += [(state, lie) for lie in (
        {"step": -1}, {"step": "soon"}, {"time": 1e308}, {"count": 1}, {"rate": -1.0},
        {"dt": None}, {"more": 1},
    )]  # fmt: skip
    lies += [(about, lie) for lie in (
        {"state": []}, {"program": "another"}, {"frames": -3}, {"history": "all"}, {"case": 7},
        {"made_by": None},
    )]  # fmt: skip
    where, lie = chance.choice(lies)
    for key, value in lie.items():
        where.pop(key) if value is None else where.__setitem__(key, value)
    write(path, Serial(), about, rows, whole)


KINDS = (truncated, flipped, overwritten, replaced, header_lies, state_lies, state_lies)
