"""Runs a study, or one part of it: ``python scripts/studies contact``, ``.. hard.hertz --docs``."""

import importlib
import sys
from pathlib import Path

if __name__ == "__main__":
    sys.path[0] = str(Path(__file__).resolve().parents[1])
    name = sys.argv.pop(1)
    part = name if "." in name else f"{name}.__main__"
    importlib.import_module(f"studies.{part}").main()
