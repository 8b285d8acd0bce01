"""scripts/setup on machines of stand-ins: what it installs, what it leaves, what it says."""

import os
import shutil
import subprocess

import pytest
from machines import PROGRAM, PYTHON, ROOT, SCRIPTS

pytestmark = pytest.mark.slow(30)

APT_GET = r"""#!/usr/bin/env bash
echo "apt-get $*" >>"$LOG"
[[ "$*" = *install* ]] || exit 0
here=$(dirname "$0")
for package in "$@"; do
    for program in $(sed -n "s/^$package: //p" "$here/packages"); do
        cp "$here/template" "$here/$program"
    done
done
"""


@pytest.mark.parametrize("script", SCRIPTS)
def test_script_is_bash_and_executable(script):
    assert os.access(ROOT / script, os.X_OK)
    done = subprocess.run(["bash", "-n", str(ROOT / script)], capture_output=True, text=True)
    assert done.stderr == ""


def test_an_interpreter_without_optimisations_is_the_last_choice(machine):
    machine.add_system_packages()
    machine.add("python3.12", PYTHON)
    done = machine.run("scripts/setup", UNOPTIMISED="python3")
    assert "making the environment .venv with " + str(machine.bin / "python3.12") in done.stdout
    shutil.rmtree(machine.root / ".venv")
    done = machine.run("scripts/setup", UNOPTIMISED="python3", PYTHON="python3")
    assert f"making the environment .venv with {machine.bin / 'python3'}\n" in done.stdout


@pytest.mark.parametrize("user", ["root", "sudo"])
def test_bare_machine_is_set_up_then_nothing_is_left_to_do(machine, user):
    machine.add("apt-get", APT_GET)
    machine.add("id", f"#!/usr/bin/env bash\necho {0 if user == 'root' else 1000}")
    if user == "sudo":
        machine.add("sudo", '#!/usr/bin/env bash\n[ "$1" != -n ] || shift\nexec "$@"')
    done = machine.run("scripts/setup")
    assert done.returncode == 0, done.stdout + done.stderr
    install = next(line for line in machine.called.splitlines() if "apt-get -q -y" in line)
    assert install.endswith(" openmpi-bin")  # nothing to compile with, nor HDF5
    assert "--no-binary" not in machine.called
    assert "\npgimp doctor\n" in machine.called

    again = machine.run("scripts/setup")
    assert again.returncode == 0
    (line,) = again.stdout.splitlines()
    assert "in place" in line
    assert "pip" not in machine.called
    assert "apt-get" not in machine.called
    assert machine.run("scripts/setup", "--quiet").stdout == ""


def test_what_a_run_imports_is_compiled_even_where_python_is_not_to_keep_it(machine):
    machine.add_system_packages()
    done = machine.run("scripts/setup", PYTHONDONTWRITEBYTECODE="1")
    assert done.returncode == 0, done.stderr
    assert "\nbytecode []\n" in machine.called


def test_the_kernels_of_all_cases_are_compiled_where_that_is_asked_for(ready):
    assert "compile_ahead" not in ready.run("scripts/setup").stdout + ready.called
    for name in ("one", "two"):
        (ready.root / "cases").mkdir(exist_ok=True)
        (ready.root / "cases" / f"{name}.yaml").touch()
    done = ready.run("scripts/setup", "--gallery", COMPILED="0")
    assert done.returncode == 0, done.stderr
    assert "compiling the kernels" in done.stdout and "in place" in done.stdout
    named = [str(ready.root / "cases" / f"{name}.yaml") for name in ("one", "two")]
    assert f"python -m pgimp.running.compile_ahead {' '.join(named)}\n" in ready.called
    failed = ready.run("scripts/setup", "--gallery", COMPILED="1")
    assert failed.returncode == 1 and "not all kernels could be compiled" in failed.stderr


def test_what_the_tests_need_comes_on_top(ready):
    ready.add("apt-get", APT_GET)
    (ready.bin / "pvpython").unlink()
    (ready.bin / "sbatch").unlink()
    ready.add("id", "#!/usr/bin/env bash\necho 0")
    assert "in place" in ready.run("scripts/setup").stdout
    done = ready.run("scripts/setup", "--test")
    assert done.returncode == 0, done.stderr
    assert "install --no-install-recommends paraview python3-paraview slurm-client" in ready.called
    assert "pytest" in ready.called
    assert "in place" in ready.run("scripts/setup", "--test").stdout


def test_an_mpicc_without_headers_is_completed(ready):
    """As Debian's openmpi-bin has it, without libopenmpi-dev."""
    ready.add("apt-get", APT_GET)
    ready.add("id", "#!/usr/bin/env bash\necho 0")
    ready.add("mpicc", '#!/usr/bin/env bash\n[[ "$*" != *-E* ]]')
    assert ready.run("scripts/setup", "--test").returncode == 0
    assert "install --no-install-recommends libopenmpi-dev\n" in ready.called


@pytest.fixture
def cluster(machine):
    """A machine of a user who is not root, with an MPI from a module, and a sudo that asks."""
    machine.add("id", "#!/usr/bin/env bash\necho 1000")
    for name in ("apt-get", "sudo"):
        machine.add(name, f'#!/usr/bin/env bash\necho "{name} $*" >>"$LOG"; exit 1')
    for name in ("mpirun", "mpicc"):
        machine.add(name, PROGRAM)
    return machine


def test_the_mpi_of_a_module_is_used_without_root(cluster):
    env = {"LOADEDMODULES": "gcc/12.2:openmpi/4.1"}
    done = cluster.run("scripts/setup", **env)
    assert done.returncode == 0, done.stderr
    assert "apt-get" not in cluster.called
    assert "sudo" not in cluster.called
    assert "--no-binary" not in cluster.called
    line = "pgimp batch CASE.yaml --module gcc/12.2 --module openmpi/4.1\n"
    assert line in done.stdout
    assert "in place" in cluster.run("scripts/setup", **env).stdout
    (cluster.bin / "mpirun").unlink()
    done = cluster.run("scripts/run", "case.yaml")
    assert done.returncode == 1
    assert "  module load gcc/12.2 openmpi/4.1\n" in done.stderr


def test_mpi4py_is_built_where_its_wheel_does_not_fit(cluster):
    done = cluster.run("scripts/setup", STRANGERS="1")
    assert done.returncode == 0, done.stderr
    assert "mpi4py's wheel does not fit" in done.stdout
    words = next(line for line in cluster.called.splitlines() if "--no-binary=mpi4py" in line)
    assert {"--no-cache-dir", "--no-build-isolation", "--no-deps"} <= set(words.split())
    assert "settings mpicc -O1 -g0" in cluster.called
    assert "apt-get" not in cluster.called


@pytest.mark.parametrize("user", ["root", "other"])
def test_what_builds_mpi4py_is_installed_where_root_may(cluster, user):
    (cluster.bin / "mpicc").unlink()
    if user == "root":
        cluster.add("id", "#!/usr/bin/env bash\necho 0")
        cluster.add("apt-get", APT_GET)
    done = cluster.run("scripts/setup", STRANGERS="1")
    assert done.returncode == 0, done.stderr
    if user == "root":
        assert "install --no-install-recommends gcc libc6-dev libopenmpi-dev" in cluster.called
        assert "settings mpicc" in cluster.called
    else:
        assert "cannot be built here:\nsetup: no mpicc" in done.stdout
        assert "apt-get" not in cluster.called


def test_mpi4py_that_cannot_be_built(cluster):
    done = cluster.run("scripts/setup", STRANGERS="1", UNBUILT="1")
    assert done.returncode == 1
    assert "mpi4py could not be built with" in done.stderr


def test_another_mpi_is_looked_at_again(cluster, tmp_path):
    """Other modules are loaded than at the last set-up: mpi4py is tried with them."""
    assert cluster.run("scripts/setup").returncode == 0
    other = tmp_path / "other"
    other.mkdir()
    shutil.copy(cluster.bin / "mpirun", other / "mpirun")
    done = cluster.run("scripts/setup", PATH=f"{other}:{cluster.bin}", STRANGERS="1")
    assert done.returncode == 0, done.stderr
    assert f"does not fit {other}/mpirun: building it from source" in done.stdout


def test_srun_is_the_launcher_where_it_is_alone(cluster):
    shutil.move(cluster.bin / "mpirun", cluster.bin / "srun")
    done = cluster.run("scripts/setup")
    assert done.returncode == 0, done.stderr
    assert "'salloc -n 2 scripts/setup' would check" in done.stdout
    assert "\nsrun" not in cluster.called
    assert cluster.run("scripts/setup", SLURM_JOB_ID="1", MPICC="cc").returncode == 0
    assert "\nsrun -n 2 " in cluster.called
    assert cluster.run("scripts/run", "case.yaml").returncode == 0
    assert cluster.called.splitlines()[-1].startswith("srun -n 2 ")


@pytest.mark.parametrize("apt", [True, False])
def test_missing_packages_are_left_to_the_administrator(machine, apt):
    """No root and no sudo, or no apt-get at all."""
    machine.add("id", f"#!/usr/bin/env bash\necho {1000 if apt else 0}")
    if apt:
        machine.add("apt-get", APT_GET)
    done = machine.run("scripts/setup")
    assert done.returncode == 1
    assert "apt-get install --no-install-recommends openmpi-bin\n" in done.stderr
    assert "apt-get" not in machine.called
    assert not (machine.root / ".venv").exists()


def test_changed_requirements_are_installed(ready):
    with open(ready.root / "pyproject.toml", "a") as file:
        file.write("\n")
    done = ready.run("scripts/setup")
    assert "installing Python packages" in done.stdout
    assert "-m venv" not in ready.called


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda venv: (venv / "setup-unfinished").touch(), "interrupted"),
        (lambda venv: (venv / "bin/python").unlink(), "does not work"),
        (lambda venv: (venv / "bin/no-pip").touch(), "does not work"),
        (lambda venv: (venv / "bin/activate").write_text("VIRTUAL_ENV=/old/.venv"), "was moved"),
    ],
)
def test_damaged_environment_is_made_anew(ready, damage, said):
    (ready.root / ".venv/setup-run").unlink()
    damage(ready.root / ".venv")
    done = ready.run("scripts/setup")
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    assert "-m venv --clear" in ready.called
    assert "in place" in ready.run("scripts/setup").stdout


def test_failed_pip_is_explained_and_tried_again(machine):
    machine.add_system_packages()
    done = machine.run("scripts/setup", PIP_STATUS="1")
    assert done.returncode == 1
    assert "pip could not install these" in done.stderr
    assert machine.run("scripts/setup").returncode == 0
    assert "-m venv" not in machine.called


def test_setup_fails_when_the_doctor_finds_something_wrong(machine):
    machine.add_system_packages()
    assert machine.run("scripts/setup", STATUS="1").returncode == 1
    assert "in place" not in machine.run("scripts/setup").stdout
