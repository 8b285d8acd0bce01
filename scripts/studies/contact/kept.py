"""Figures that are kept from run to run, as long as nothing that they follow from has changed."""

import json
from hashlib import sha256

from studies.contact import motion


def _digest():
    """Of the sources of pgimp and of what is measured."""
    found = sha256()
    sources = [*(motion.ROOT / "pgimp").rglob("*.py"), *(motion.ROOT / "cases").glob("*.yaml")]
    sources += (motion.ROOT / "scripts" / "studies" / "contact").glob("[!_]*.py")
    for path in sorted(sources):
        found.update(path.read_bytes())
    return found.hexdigest()


class Kept:
    """Figures by name, kept in a file.

    Parameters
    ----------
    path : Path
        The file.
    """

    def __init__(self, path):
        self._path, self._digest, self.found = path, _digest(), {}
        if path.exists():
            kept = json.loads(path.read_text(encoding="utf-8"))
            if kept["digest"] == self._digest:
                self.found = {tuple(name): value for name, value in kept["figures"]}

    def add(self, name, value):
        """Keep a figure, or several in one."""
        self.found[name] = value
        figures = [[name, value] for name, value in self.found.items()]
        text = json.dumps({"digest": self._digest, "figures": figures}, default=float)
        self._path.write_text(text, encoding="utf-8")
