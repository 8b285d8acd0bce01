"""Spack recipe of meshio 5.3: Spack's own repository ends at 5.0."""

from spack.package import *
from spack_repo.builtin.build_systems.python import PythonPackage


class PyMeshio(PythonPackage):
    """Reads and writes many formats of meshes."""

    homepage = "https://github.com/nschloe/meshio"
    pypi = "meshio/meshio-5.3.5.tar.gz"

    license("MIT")

    version("5.3.5", sha256="f21f01abd9f29ba06ea119304b3d39e610421cfe93b9dd23362834919f87586d")

    with default_args(type="build"):
        depends_on("py-setuptools@42:")

    with default_args(type=("build", "run")):
        depends_on("python@3.8:")
        depends_on("py-numpy@1.20:")
        depends_on("py-rich")
