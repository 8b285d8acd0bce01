"""Bits of frozen scenes on 1, 3 and 5 ranks, and whether another commit gives the same."""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from proofs.jobs import environment, options_of

ROOT = Path(__file__).resolve().parents[2]
RANKS = (1, 3, 5)
#: Shipped cases by name, and where they end: after some hundreds of steps.
CASES = {
    "bar-vibration": 0.05, "block3d": 0.02, "channel": 0.004, "dam-break": 0.05, "disks": 0.2,
    "footing": 0.01, "gate": 0.01, "rolling": 0.05, "sand-column": 0.02, "vortex": 0.05,
}  # fmt: skip
#: Runs cases given as words, each into a folder of its name; also in older checkouts.
RUNNER = """
import sys
from pathlib import Path
import pgimp
for case in sys.argv[2:]:
    output = Path(sys.argv[1]) / Path(case).stem
    pgimp.run(case, output=output, overrides=["checkpoint={every: {steps: 23}}"], quiet=True)
"""


def main(words):
    """Print what differs between ranks, and from another commit; 1 if anything does."""
    against = {"help": "another commit, set up and run beside this one"}
    only = {"default": "", "help": "names of scenes, by commas"}
    options = options_of("bits", words, against=against, only=only)
    only = {name for name in options.only.split(",") if name}
    with tempfile.TemporaryDirectory(prefix="pgimp-bits-") as folder:
        cases = [path for path in frozen(Path(folder)) if not only or path.stem in only]
        found, failed = bits(ROOT, Path(folder) / "here", cases)
        print(f"{len(found)} scenes on {', '.join(map(str, RANKS))} ranks: {failed or 'the same'}")
        if options.against:
            other = Path(folder) / "other"
            git = ("git", "-C", str(ROOT), "worktree")
            subprocess.run([*git, "add", "-q", "--detach", other, options.against], check=True)
            try:
                subprocess.run([other / "scripts/setup", "--quiet"], check=True, cwd=other)
                theirs, worse = bits(other, Path(folder) / "there", cases)
            finally:
                subprocess.run([*git, "remove", "--force", other], check=True)
            differ = [name for name in found if found[name] != theirs.get(name)]
            print(f"against {options.against}: {', '.join(differ) or 'the same bits'}")
            failed += worse + differ
    return 1 if failed else 0


def frozen(folder):
    """Write the scenes of the tests of ranks, and shipped cases that end early; return paths."""
    sys.path[:0] = [str(path) for path in (ROOT / "tests" / "support").iterdir()]
    from rank_scenes import SCENES

    scenes = folder / "cases"
    scenes.mkdir()
    for name, case in SCENES.items():
        (scenes / f"{name}.yaml").write_text(json.dumps(case))
    for name, end in CASES.items():
        text = (ROOT / "cases" / f"{name}.yaml").read_text()
        text, count = re.subn(r"(?m)^  end: \S+", f"  end: {end}", text)
        assert count == 1, name
        (scenes / f"{name}.yaml").write_text(text)
    return sorted(scenes.iterdir())


def bits(root, folder, cases):
    """Digests of a checkout's runs by scene, and names of those that ranks change."""
    from run_files import digests

    folder.mkdir()
    (folder / "runner.py").write_text(RUNNER)
    found, failed = {}, []
    for ranks in RANKS:
        words = ["mpirun", "-q", "--oversubscribe", "--bind-to", "none", "-n", str(ranks)]
        words = words if ranks > 1 else []
        words += [root / ".venv/bin/python", folder / "runner.py", folder / str(ranks), *cases]
        subprocess.run(words, env=environment() | {"PYTHONPATH": str(root)}, check=True)
        for case in cases:
            digest = digests(folder / str(ranks) / case.stem)
            if found.setdefault(case.stem, digest) != digest:
                failed.append(f"{case.stem} on {ranks}")
    return found, failed
