"""Spack recipe of shtab."""

from spack.package import *
from spack_repo.builtin.build_systems.python import PythonPackage


class PyShtab(PythonPackage):
    """Makes completion scripts of shells from argparse parsers."""

    homepage = "https://github.com/tqdm/shtab"
    pypi = "shtab/shtab-1.13.0.tar.gz"

    license("Apache-2.0")

    version("1.13.0", sha256="0a5be9d7ab2b4549e9a38252abcd5ecf5ec6813ecd80c6b06fa851bff55a5085")

    with default_args(type="build"):
        depends_on("py-setuptools@77:")
        depends_on("py-setuptools-scm@3.4:")
