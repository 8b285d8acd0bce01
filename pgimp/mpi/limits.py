"""Memory that the processes of a node may still take: of the machine, a cgroup, a process."""

import os
import resource
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

#: A v1 cgroup without a limit reports about 2^63.
_NO_LIMIT = 2**60


class Limit(NamedTuple):
    """Memory that some processes may still take together."""

    shared_by: str  #: Key common to all processes that share it, and to no others.
    name: str  #: Source of the limit, as text.
    free: int  #: Bytes.
    addresses: bool = False  #: Whether memory that is allocated but never touched counts.


def limits(root: str = "/") -> list[Limit]:
    """Find the limits of this process.

    Parameters
    ----------
    root : str
        Directory of the system's files.
    """
    top = Path(root)
    node = _text(top / "proc/sys/kernel/random/boot_id") or os.uname().nodename
    found = []
    memory = _table(top / "proc/meminfo")
    if "MemAvailable:" in memory:
        found.append(Limit(node, "this node", memory["MemAvailable:"] * 1024))
    found += _overcommit(top, memory, node)
    for line in _text(top / "proc/self/cgroup").splitlines():
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            found += _cgroup(top / "sys/fs/cgroup", path, node, "memory.max", "memory.current", "")
        elif "memory" in controllers.split(","):
            files = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_")
            found += _cgroup(top / "sys/fs/cgroup/memory", path, node, *files)
    used = _table(top / "proc/self/status")
    for kind, name, column in (
        (resource.RLIMIT_AS, "ulimit -v", "VmSize:"),
        (resource.RLIMIT_DATA, "ulimit -d", "VmData:"),
    ):
        most = resource.getrlimit(kind)[0]
        if most != resource.RLIM_INFINITY and column in used:
            process = f"{node} process {os.getpid()}"
            found.append(Limit(process, name, most - used[column] * 1024, True))
    return found


def _overcommit(top: Path, memory: dict[str, int], node: str) -> list[Limit]:
    """Memory that the kernel grants, counting untouched allocations."""
    mode = _text(top / "proc/sys/vm/overcommit_memory")
    if mode == "0" and "MemTotal:" in memory:  # requests above the total are refused
        most = (memory["MemTotal:"] + memory.get("SwapTotal:", 0)) * 1024
        process = f"{node} process {os.getpid()}"
        return [Limit(process, "the whole memory of this node", most, True)]
    if mode == "2" and "CommitLimit:" in memory and "Committed_AS:" in memory:
        free = (memory["CommitLimit:"] - memory["Committed_AS:"]) * 1024
        return [Limit(f"{node} commit", "vm.overcommit_memory=2", free, True)]
    return []


def _cgroup(base: Path, path: str, node: str, limit: str, usage: str, prefix: str) -> list[Limit]:
    """Limits of a cgroup and of its ancestors; in a container the path may not be there."""
    found = []
    place = base / path.strip("/")
    if ".." in place.parts or not place.is_dir():
        place = base
    while True:
        most, used = _text(place / limit), _text(place / usage)
        if most.isdecimal() and used.isdecimal() and int(most) < _NO_LIMIT:
            # Pages of files go when memory is short.
            kept = _table(place / "memory.stat")
            files = sum(kept.get(f"{prefix}{kind}_file", 0) for kind in ("active", "inactive"))
            free = int(most) - max(0, int(used) - files)
            found.append(Limit(f"{node} {place}", f"the cgroup {place}", free))
        if place == base:
            return found
        place = place.parent


def _text(path: Path) -> str:
    with suppress(OSError):
        return path.read_text(errors="replace").strip()
    return ""


def _table(path: Path) -> dict[str, int]:
    """First two words of each line, the second a number."""
    table = {}
    for line in _text(path).splitlines():
        words = line.split()
        if len(words) > 1 and words[1].isdecimal():
            table[words[0]] = int(words[1])
    return table
