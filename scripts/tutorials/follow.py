"""Following a tutorial as its reader would: its blocks in order, in an empty folder.

=========  =========================================================================================
block      what is done with it
=========  =========================================================================================
yaml       goes into the file that its first line names, ``# footing.yaml``: a part of the file
           whose key is there already is replaced, others go to the end
python     likewise, but always to the end; without a name it is a program, and run
sh         its lines are run, one after the other
text       must be what the last ones said: its lines in order, numbers within a tolerance
=========  =========================================================================================
"""

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
TUTORIALS = ROOT / "docs" / "tutorials"
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAME = re.compile(r"# ([\w.-]+\.(?:yaml|py))\n")
NUMBER = re.compile(r"(?<![\w.])-?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")
#: What may follow a command that does not end with status 0: `# status 75`.
STATUS = re.compile(r"# status (\d+)")


class Said(NamedTuple):
    """Status and output of a command."""

    status: int
    text: str


Run = Callable[[list[str], Path], Said]


class UnexpectedError(Exception):
    """A page promises what is not so."""


def environment(more: Mapping[str, str] | None = None) -> dict[str, str]:
    """In which pgimp is that of this Python, and root may use mpirun with any number of ranks."""
    found = dict(os.environ) | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
        "OMPI_MCA_mpi_yield_when_idle": "1", "COLUMNS": "100",
    }  # fmt: skip
    return found | dict(more or {})


def start(words: list[str], folder: Path) -> Said:
    """Run a command as a process of its own."""
    done = subprocess.run(
        words, cwd=folder, env=environment(), stdin=subprocess.DEVNULL, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
    )  # fmt: skip
    return Said(done.returncode, done.stdout)


def blocks(page: str) -> list[tuple[str, str]]:
    """Kinds and contents of the blocks of a page, in order."""
    text = (TUTORIALS / f"{page}.md").read_text(encoding="utf-8")
    return FENCE.findall(text)


def parts(text: str) -> dict[str, str]:
    """The parts of a case by their keys: each with the lines below its key."""
    found: dict[str, str] = {}
    for piece in re.split(r"^(?=[a-z])", text, flags=re.MULTILINE):
        if piece.strip():
            found[piece.partition(":")[0]] = piece.rstrip("\n") + "\n"
    return found


def grown(file: str, block: str) -> str:
    """A case after one more block: what it names is replaced, the rest goes to the end."""
    return "".join((parts(file) | parts(block)).values())


def write(folder: Path, block: str, kind: str) -> bool:
    """Write a block into the file that it names; whether it names one."""
    if not (named := NAME.match(block)):
        return False
    path, rest = folder / named[1], block[named.end() :]
    before = path.read_text(encoding="utf-8") if path.exists() else ""
    text = grown(before, rest) if kind == "yaml" else before + rest
    path.write_text(text, encoding="utf-8")
    return True


def numbers(line: str) -> tuple[str, list[str]]:
    """A line without its numbers and runs of spaces, and the numbers."""
    plain = " ".join(NUMBER.sub("#", line).split())
    return plain, NUMBER.findall(line)


def close(promised: str, found: str, tolerance: float) -> bool:
    """Whether a number is the one promised, but for its last digit and the tolerance."""
    one, other = (float(each.replace(",", "")) for each in (promised, found))
    digits = len(promised.partition("e")[0].partition(".")[2])
    last = 10.0 ** (-digits) * 10.0 ** float(promised.partition("e")[2] or 0)
    return abs(one - other) <= max(last, tolerance * abs(one)) * (1.0 + 1e-9)


def alike(promised: str, found: str, tolerance: float) -> bool:
    """Whether two lines say the same; `...` in the promised one stands for anything."""
    pieces = [piece.strip() for piece in promised.split("...")]
    if len(pieces) > 1:
        pattern = ".*".join(re.escape(piece) for piece in pieces)
        return re.fullmatch(rf"\s*{pattern}\s*", found) is not None
    (one, ones), (other, others) = numbers(promised), numbers(found)
    return one == other and all(close(*each, tolerance) for each in zip(ones, others, strict=True))


def expect(promised: str, said: str, tolerance: float) -> None:
    """Compare what a page shows with what was said: its lines in order, others between them.

    Raises
    ------
    UnexpectedError
        With the first line that is missing.
    """
    rest = iter(said.splitlines())
    for line in promised.splitlines():
        if line.strip() in ("", "..."):
            continue
        if not any(alike(line, each, tolerance) for each in rest):
            raise UnexpectedError(f"not said: {line}\nbut:\n{said}")


def follow(page: str, folder: Path, run: Run = start, tolerance: float = 0.02) -> dict[str, Said]:
    """Do what a tutorial says, in a folder; what each of its commands said.

    Raises
    ------
    UnexpectedError
        Where a command fails, or says something else.
    """
    said: dict[str, Said] = {}
    last = ""
    for kind, block in blocks(page):
        if kind == "text":
            expect(block, last, tolerance)
        elif kind in ("yaml", "python") and write(folder, block, kind):
            continue
        elif kind == "python":
            done = start([sys.executable, "-c", block], folder)
            if done.status:
                raise UnexpectedError(f"{block}\n{done.text}")
            last = done.text
        elif kind == "sh":
            last = ""
            for line in block.splitlines():
                if not (words := shlex.split(line, comments=True)):
                    continue
                done = said[shlex.join(words)] = run(words, folder)
                wanted = STATUS.search(line)
                if done.status != int(wanted[1] if wanted else 0):
                    raise UnexpectedError(f"{line}: status {done.status}\n{done.text}")
                last += done.text
        else:
            raise UnexpectedError(f"a block that is neither file nor command:\n{block}")
    return said
