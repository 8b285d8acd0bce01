"""A kernel's entry for Python: it takes of the arguments what the kernel uses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, reduce
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.callwrapper import PyCallWrapper
from numba.np.numpy_support import as_dtype

from pgimp.jit.outside import NumbaObject
from pgimp.jit.results import is_tuple

#: Types of numbers and arrays that it takes.
_SIMPLE = (types.Array, types.Integer, types.Float, types.Boolean)


def is_simple(kinds: Sequence[NumbaObject]) -> bool:
    """Whether arguments of some types are tuples of numbers and arrays, at any depth."""
    return all(
        is_simple([*each]) if is_tuple(each) else isinstance(each, _SIMPLE) for each in kinds
    )


class Entry(PyCallWrapper):
    """Entry of a kernel that counts no references; it looks only at the arguments that are used.

    Numba's takes all arrays of all arguments, which are most of the instructions of a short kernel,
    and most of the time of its call. As there, the types of arguments are known to be right.

    Parameters
    ----------
    used : sequence of bool
        Whether the kernel uses each number and array of its arguments.
    """

    def __init__(
        self, context: NumbaObject, module: Any, used: Sequence[bool], **rest: Any
    ) -> None:
        super().__init__(context, module, call_helper=None, release_gil=False, **rest)
        self.used = used

    def build_wrapper(
        self, api: NumbaObject, builder: NumbaObject, closure: Any, args: Any, kws: Any
    ) -> None:
        """Emit its instructions."""
        wanted = len(self.fndesc.argtypes)
        other = builder.icmp_signed("!=", api.tuple_size(args), ir.Constant(api.py_ssize_t, wanted))
        with cgutils.if_unlikely(builder, builder.or_(cgutils.is_not_null(builder, kws), other)):
            api.err_set_string("PyExc_TypeError", f"{wanted} arguments by position are wanted")
            builder.ret(api.get_null_object())
        parts, failed = [], []
        used = iter(self.used)
        environment = self.get_env(api, builder)
        for taken in self._taken(api, builder, self.fndesc.argtypes, used, lambda: args):
            parts += taken[0]
            failed += taken[1]
        failed.append(cgutils.is_not_null(builder, api.err_occurred()))
        with cgutils.if_unlikely(builder, reduce(builder.or_, failed)):
            with cgutils.if_unlikely(builder, cgutils.is_null(builder, api.err_occurred())):
                api.err_set_string("PyExc_TypeError", "an argument has another type than before")
            builder.ret(api.get_null_object())
        convention, context = self.context.call_conv, self.context
        place = cgutils.alloca_once(builder, self.func.args[0].type.pointee, zfill=True)
        error = cgutils.alloca_once(builder, self.func.args[1].type.pointee)
        code = builder.call(self.func, [place, error, *parts], attrs=("noinline",))
        status = convention._get_return_status(builder, code, builder.load(error))
        with builder.if_then(status.is_ok, likely=True):
            with builder.if_then(status.is_none):
                api.return_none()
            found = context.get_returned_value(builder, self.fndesc.restype, builder.load(place))
            builder.ret(api.from_native_return(self.fndesc.restype, found, environment))
        convention.raise_error(builder, api, status)
        builder.ret(api.get_null_object())

    def _taken(
        self, api: NumbaObject, builder: NumbaObject, kinds: Sequence[NumbaObject],
        used: Iterator[bool], owner: Callable[[], Any],
    ) -> Iterator[tuple[list, list]]:  # fmt: skip
        """Parts of each number and array that is used of a tuple, and what is true if it fails."""
        for i, kind in enumerate(kinds):
            item = cache(lambda i=i: api.tuple_getitem(owner(), i))
            if is_tuple(kind):
                yield from self._taken(api, builder, [*kind], used, item)
            elif next(used):
                yield self._leaf(api, builder, kind, item())

    def _leaf(
        self, api: NumbaObject, builder: NumbaObject, kind: NumbaObject, item: Any
    ) -> tuple[list, list]:
        model = self.context.data_model_manager[kind]
        if isinstance(kind, types.Array):
            address = cgutils.alloca_once(builder, self.context.get_value_type(kind))
            code = api.numba_array_adaptor(item, builder.bitcast(address, api.voidptr))
            array = builder.load(address)
            size = builder.extract_value(array, model.get_field_position("itemsize"))
            other = ir.Constant(size.type, as_dtype(kind.dtype).itemsize)
            failed = [cgutils.is_not_null(builder, code), builder.icmp_unsigned("!=", size, other)]
            return [*flat(model.as_argument(builder, array))], failed
        if isinstance(kind, types.Boolean):
            truth = api.object_istrue(item)
            return [builder.trunc(truth, model.get_argument_type())], []
        if isinstance(kind, types.Float):
            number = api.float_as_double(item)
            single = kind == types.float32
            return [builder.fptrunc(number, ir.FloatType()) if single else number], []
        if kind.signed:
            number = api.long_as_longlong(item)
        else:  # Python's function takes no numbers of NumPy
            whole = api.number_long(item)
            number = api.long_as_ulonglong(whole)
            api.decref(whole)
        form = model.get_argument_type()
        return [builder.trunc(number, form) if form.width < number.type.width else number], []


def flat(parts: Any) -> Iterator:
    """Parts of nested tuples, one by one."""
    if isinstance(parts, tuple | list):
        for each in parts:
            yield from flat(each)
    else:
        yield parts
