"""The proof that the command line names; see scripts/faults."""

import importlib
import sys

PROOFS = ("kill", "signals", "cases", "checkpoints", "long", "liquids", "scenes", "bits")

if __name__ == "__main__":
    name = sys.argv[1]
    if name not in PROOFS:
        sys.exit(f"scripts/faults: there is no proof {name}; there are {', '.join(PROOFS)}")
    sys.exit(importlib.import_module(f"proof_{name}").main(sys.argv[2:]))
