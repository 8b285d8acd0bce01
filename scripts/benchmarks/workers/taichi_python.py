"""An environment of its own for Taichi."""

import subprocess
import sys
from pathlib import Path

VENV = Path(__file__).resolve().parents[3] / ".venv-taichi"
TAICHI = "taichi==1.7.4"


def taichi_python():
    """The interpreter of an environment that has Taichi, made at the first time; None without."""
    python = VENV / "bin/python"
    if not python.exists() or subprocess.run([python, "-c", "import taichi"],
                                             capture_output=True).returncode:  # fmt: skip
        print(f"benchmark: installing {TAICHI} into {VENV.name}", flush=True)
        made = subprocess.run([sys.executable, "-m", "venv", "--clear", str(VENV)])
        words = [python, "-m", "pip", "-q", "--disable-pip-version-check", "install", TAICHI]
        if made.returncode or subprocess.run([*words, "numpy"]).returncode:
            print("benchmark: there is no Taichi for this Python; going on without", flush=True)
            return None
    return str(python)
