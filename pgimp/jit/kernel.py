"""Use of Numba: reproducible code generation, and a disk cache of its own.

Compiled kernels are kept on disk, see `pgimp.jit.compiled.folder` and `pgimp.jit.compiled.cache`.
"""

import os
import sys
from collections.abc import Callable
from functools import wraps

from pgimp.jit.compiled.folder import cache_folder

#: Where compiled kernels are kept.
FOLDER = cache_folder()
os.environ["NUMBA_CACHE_DIR"] = str(FOLDER.path)  # for a user's own cached helpers
if "numba" in sys.modules:  # imported by the user's program before: set its variables
    sys.modules["numba"].config.reload_config()

import numba  # noqa: E402
from numba.extending import overload  # noqa: E402

from pgimp.jit.compiled.cache import KernelCache  # noqa: E402
from pgimp.jit.compiled.compiler import Compiler  # noqa: E402
from pgimp.jit.outside import NumbaObject  # noqa: E402
from pgimp.jit.rehearsal import notable  # noqa: E402

#: Options of every kernel and of all functions inlined into it. Contraction only: full fastmath
#: would let LLVM reorder sums and delete the checks for NaN. The others save compile time: no entry
#: for programs in C, and no reference counts, of which tuples of arrays need very many.
_OPTIONS: dict[str, NumbaObject] = {
    "fastmath": {"contract"},
    "error_model": "numpy",
    "boundscheck": False,
    "no_cfunc_wrapper": True,
    "_nrt": False,
    "pipeline_class": Compiler,
}


#: Options of functions that are always inlined into a kernel.
INLINE_OPTIONS: NumbaObject = {**_OPTIONS, "forceinline": True}


def kernel(function: Callable) -> Callable:
    """Compile a function on first call, with pgimp's options, and cache it on disk.

    It cannot make arrays ("Only accept returning of array passed into the function as argument"),
    unlike an `allocating_kernel`.
    """
    return _kernel(function, _OPTIONS)


def allocating_kernel(function: Callable) -> Callable:
    """As `kernel`, for a function that makes arrays, or calls one that does.

    Called functions may take arrays but must not return them: `kernel` counts no references.
    """
    return _kernel(function, {**_OPTIONS, "_nrt": True})


def inner_kernel(function: Callable) -> Callable:
    """As `kernel`, for a function that only other kernels call: without an entry for Python."""
    compiled = _kernel(function, {**_OPTIONS, "no_cpython_wrapper": True})

    def refuse(*args: object, **options: object) -> None:
        raise TypeError(f"{function.__qualname__} is for other kernels to call")

    # Called from Python, the dispatcher looks up entries missing in its own table. The entries
    # of this function would be null.
    compiled.add_overload = lambda done: compiled.overloads.update({done.signature.args: done})
    compiled._compile_for_args = refuse
    return compiled


def separate_kernel(function: Callable) -> Callable:
    """As `inner_kernel`, for one that is called from many places, and kept as one function."""
    function.is_separate = True  # type: ignore[attr-defined]
    return inner_kernel(function)


def _kernel(function: Callable, options: dict[str, NumbaObject]) -> NumbaObject:
    compiled: NumbaObject = numba.njit(**options)(function)
    if not options.get("no_cpython_wrapper"):  # parts of kernels: the compiler keeps them itself
        compiled._cache = KernelCache(function, FOLDER.path)  # instead of Numba's, as by cache=True
        notable(compiled)
    return compiled


def inlined(function: Callable) -> Callable:
    """Inline a plain function into the kernels that call it.

    What types decide is decided while a kernel is traced: branches on the length of a tuple or by
    `of_types`, loops and ``tuple(.. for ..)`` over tuples, ``sum(.. for ..)`` from its first term.
    """
    overload(function, jit_options=INLINE_OPTIONS, strict=False)(lambda *_: function)
    return function


def of_types(predicate: Callable) -> Callable:
    """Have functions that are inlined ask a function of Numba types about their values.

    It gets the types of its arguments, of functions, classes and texts these themselves. Its result
    is a constant of the kernel: a truth, a number, a tuple, a function to call. Python, which runs
    functions of known texts while a kernel is traced, asks about numbers.
    """

    @wraps(predicate)
    def asked(*args: NumbaObject) -> object:
        known = (numba.typeof(each) if isinstance(each, int | float) else each for each in args)
        return predicate(*known)

    asked.of_types = True  # type: ignore[attr-defined]
    return asked


@of_types
def is_record(kind: NumbaObject) -> bool:
    """Whether a value is a NamedTuple, and not the () that may be in its place."""
    return hasattr(kind, "instance_class")


@of_types
def is_empty(kind: NumbaObject) -> bool:
    """Whether a value is the () that is in the place of a record or a number."""
    return isinstance(kind, numba.types.BaseTuple) and not is_record(kind) and len(kind) == 0


@of_types
def is_array(kind: NumbaObject) -> bool:
    """Whether a value is an array, and not the () that may be in its place."""
    return hasattr(kind, "ndim")


@of_types
def is_number(kind: NumbaObject) -> bool:
    """Whether a value is one number, and neither a vector nor a tuple."""
    return isinstance(kind, numba.types.Number | numba.types.Boolean)


@of_types
def class_of(kind: NumbaObject) -> type:
    """Class of a NamedTuple, of whose functions it is the owner; NoneType of other values."""
    return getattr(kind, "instance_class", type(None))


def exact(function: Callable) -> Callable:
    """As `inlined`, without contraction: the same bits wherever the function is inlined.

    Whether LLVM contracts a product and a sum depends on other uses of the product, so that one
    expression may round differently in two kernels.
    """
    options: NumbaObject = {**INLINE_OPTIONS, "fastmath": False}
    overload(function, jit_options=options, strict=False)(lambda *_: function)
    return function
