"""Spack recipe of pgimp, built from a checkout: ``spack dev-build -d CHECKOUT pgimp@0.1.0``."""

from spack.package import *
from spack_repo.builtin.build_systems.python import PythonPackage


class Pgimp(PythonPackage):
    """Parallel Generalized Interpolation Material Point method for solids, on slabs over MPI."""

    license("MIT")

    version("0.1.0")

    with default_args(type="build"):
        depends_on("py-setuptools@77:")

    with default_args(type=("build", "run")):
        depends_on("python@3.11:")
        depends_on("mpi")
        # With MPI that of Spack, as mpi4py has: never a second one in a process.
        depends_on("py-h5py@3.12:3+mpi")
        depends_on("py-matplotlib@3.9:3")
        depends_on("py-meshio@5.3:5")
        depends_on("py-mpi4py@4.1:4")
        depends_on("py-numba@0.61:0.69")
        depends_on("py-numpy@2.0:2")
        depends_on("py-pydantic@2.11:2")
        depends_on("py-rich@13:15")
        depends_on("py-ruamel-yaml@0.18:0.19")
        depends_on("py-shtab@1.13:1")

    import_modules = ("pgimp",)

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def case_is_checked(self):
        """Write a packaged case and check it: this needs all libraries but MPI."""
        command = self.spec["python"].command
        with working_dir("spack-test", create=True):
            command("-m", "pgimp", "init", "bar-vibration")
            command("-m", "pgimp", "check", "bar-vibration.yaml")
