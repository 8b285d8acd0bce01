"""Machines made of stand-ins: every program that scripts call is logged.

The stand-ins do what the scripts rely on: a venv has a python, pip makes what it installs, apt-get
makes the programs of its packages. Nothing is downloaded and nothing outside a temporary folder
changes.
"""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SCRIPTS = ["scripts/setup", "scripts/run", "scripts/test", "scripts/slurm", ".ci/run"]


PYTHON = r"""#!/usr/bin/env bash
echo "python $*" >>"$LOG"
here=$(cd "$(dirname "$0")" && pwd)
case "$*" in
*sys.executable*) echo "$0" ;;
*CONFIG_ARGS*) [[ " ${UNOPTIMISED:-} " != *" $(basename "$0") "* ]] ;;
"-m venv "*)
    venv=${*: -1}
    rm -rf "$venv"; mkdir -p "$venv/bin"
    cp "$0" "$venv/bin/python"
    echo "VIRTUAL_ENV=$venv" >"$venv/bin/activate" ;;
*"-m pip"*" --version"*) [ ! -e "$here/no-pip" ] ;;
*"-m pip"*"install"*"--editable"*)
    printf '#!/usr/bin/env bash\necho "pgimp $*" >>"$LOG"; exit "${STATUS:-0}"' >"$here/pgimp"
    chmod +x "$here/pgimp" ;;
*"-m pip"*" wheel --no-"*)
    echo "settings $CC $CFLAGS" >>"$LOG"
    [ -z "${UNBUILT:-}" ] || exit 1
    folder=$(sed 's/.*--wheel-dir \([^ ]*\) .*/\1/' <<<"$*")
    touch "$folder/mpi4py-1.whl" ;;
*"-m pip"*"install"*"-1.whl"*) touch "$here/mpi4py" ;;
*"-m pip"*) exit "${PIP_STATUS:-0}" ;;
*compile_ahead*) exit "${COMPILED:-0}" ;;
*"import numpy.ma"*) echo "bytecode [${PYTHONDONTWRITEBYTECODE-unset}]" >>"$LOG" ;;
*) exec "$REAL_PYTHON" "$@" ;;
esac
"""


PROGRAM = r"""#!/usr/bin/env bash
echo "$(basename "$0") $*" >>"$LOG"
case "$(basename "$0") $*" in
"mpirun --version") echo "mpirun (Open MPI) 4.1.4" ;;
"mpirun "*"from mpi4py"* | "srun "*"from mpi4py"*)
    # The wheel fits, or what was built from source, as a venv's python is beside it.
    for word in "$@"; do [[ "$word" != */.venv/bin/python ]] || bin=${word%/*}; done
    size=2
    [ -z "${STRANGERS:-}" ] || [ -e "$bin/mpi4py" ] || size=1
    [[ "$*" = *COMM_WORLD.rank* ]] || mixed=of
    echo "${mixed:-}of $size" ;;
"mpirun "*) exit "${STATUS:-0}" ;;
esac
"""


TOOLS = (
    "bash cat chmod cp cut dirname env flock grep head id mkdir mktemp nproc rm sed sha256sum tail "
    "timeout touch tr true"
).split()


PROGRAMS = {
    "openmpi-bin": ["mpirun"],
    "libopenmpi-dev": ["mpicc"],
    "gcc": ["gcc"],
    "paraview": ["pvpython"],
    "xvfb": ["xvfb-run"],
    "xauth": ["xauth"],
    "munge": ["munged"],
    "slurmctld": ["slurmctld"],
    "slurmd": ["slurmd"],
    "slurm-client": ["sbatch"],
    "valgrind": ["valgrind"],
    "zsh": ["zsh"],
    "chromium": ["chromium"],
}


class Machine:
    """A temporary machine with a copy of the project's scripts."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "project"
        self.bin = folder / "bin"
        self.log = folder / "log"
        self.bin.mkdir()
        for script in SCRIPTS:
            (self.root / script).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / script, self.root / script)
        shutil.copy(ROOT / "pyproject.toml", self.root)
        for rigid_body in [*TOOLS, "basename"]:
            (self.bin / rigid_body).symlink_to(shutil.which(rigid_body))
        self.add("python3", PYTHON)
        self.add("template", PROGRAM)
        lines = (f"{package}: {' '.join(names)}" for package, names in PROGRAMS.items())
        (self.bin / "packages").write_text("\n".join(lines) + "\n")

    def add(self, name: str, text: str) -> None:
        path = self.bin / name
        path.unlink(missing_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def add_system_packages(self) -> None:
        for name in (name for names in PROGRAMS.values() for name in names):
            self.add(name, PROGRAM)

    def run(self, *words: str, **env: str) -> subprocess.CompletedProcess[str]:
        """Run a script of the project; `called` then has what it started."""
        self.log.write_text("")
        settings = {"PATH": str(self.bin), "LOG": str(self.log), "REAL_PYTHON": sys.executable}
        return subprocess.run(
            [str(self.root / words[0]), *words[1:]],
            env=settings | env,
            cwd="/",
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
        )

    @property
    def called(self) -> str:
        return self.log.read_text()
