"""The proof that the command line names; see scripts/faults."""

import importlib
import sys
from pathlib import Path

PROOFS = (
    "kill", "signals", "cases", "checkpoints", "long", "liquids", "scenes", "heaps", "surfaces",
    "kept", "bits",
)  # fmt: skip

if __name__ == "__main__":
    sys.path[0] = str(Path(__file__).resolve().parents[1])
    name = sys.argv[1]
    if name not in PROOFS:
        sys.exit(f"scripts/faults: there is no proof {name}; there are {', '.join(PROOFS)}")
    sys.exit(importlib.import_module(f"proofs.proof_{name}").main(sys.argv[2:]))
