"""A function of one's own in a case: ``{function: my-name, parameters: {...}}``."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import Field, model_validator

from pgimp.physics.functions.registry import FUNCTIONS, Function, Kind, Value, spelled
from pgimp.schema.base import Model, Name, Number, tuples
from pgimp.schema.dispatch import Either
from pgimp.schema.messages import unknown
from pgimp.schema.problems import Problem, raise_problems
from pgimp.schema.sizes import Problems

#: Hint for unknown functions.
_OUTSIDE = "; functions of one's own are registered by a file: --import FILE.py"

_Numbers = Annotated[tuple[Number, ...], Field(strict=True, min_length=1, max_length=1000)]

_Parameter = Annotated[
    float | tuple[float, ...],
    Either("a number or a list of them", {float: Number, tuple: _Numbers}),
]


class FunctionEntry(Model):
    """Base of the entries that name a function of one's own."""

    KIND: ClassVar[Kind]
    #: What the kind is given, but not here.
    NOT_GIVEN: ClassVar[tuple[str, ...]] = ()
    #: Where it may be what is not given.
    ELSEWHERE: ClassVar[str] = ""

    function: Name = Field(description="name of the function, from a file named by --import")
    arguments: dict[Name, _Parameter] = Field(
        default={},
        alias="parameters",
        description="values of the function's parameters, each a number or a list of numbers; by "
        "default those that the function gives",
    )

    @model_validator(mode="before")
    @classmethod
    def _take_lists_of_parameters(cls, data: object) -> object:
        given = data.get("parameters") if isinstance(data, dict) else None
        if isinstance(data, dict) and isinstance(given, dict):
            return data | {"parameters": {name: tuples(value) for name, value in given.items()}}
        return data

    @model_validator(mode="after")
    def _check_function(self) -> FunctionEntry:
        """Find the function, and write out the defaults of its parameters."""
        found = FUNCTIONS.get(self.function)
        known = [name for name, one in FUNCTIONS.items() if one.kind == self.KIND]
        if found is None or found.kind != self.KIND:
            text = unknown(str(self.KIND), self.function, known) + _OUTSIDE
            if found is not None:
                text = f"expected a {self.KIND}, but this is {found}"
            raise_problems("function", [Problem(("function",), text)])
        assert found is not None
        for name in self.NOT_GIVEN:
            if name in found.given:
                text = f"{found} takes {name}, which it is not given here: {self.ELSEWHERE}"
                raise_problems("function", [Problem(("function",), text)])
        values = {spelled(name): value for name, value in self.arguments.items()}
        problems = [
            Problem(("parameters", name), unknown("parameter", name, found.defaults))
            for name in self.arguments
            if spelled(name) not in found.defaults
        ]
        problems += [
            Problem(("parameters", name), f"is {spelled(name)}, which is given already")
            for name in self.arguments
            if name != spelled(name) and spelled(name) in self.arguments
        ]
        missing = [
            name
            for name, default in found.defaults.items()
            if name not in values and default is None
        ]
        if missing and not values:
            text = f"missing; {found} needs {', '.join(missing)}"
            problems.append(Problem(("parameters",), text, True))
            missing = []
        for name in missing:
            text = f"missing; {found} has no default of it"
            problems.append(Problem(("parameters", name), text, True))
        raise_problems("function", problems)
        full = {name: values.get(name, default) for name, default in found.defaults.items()}
        self.__dict__["arguments"], self.__dict__["found"] = full, found
        return self

    @property
    def registered(self) -> Function:
        """The function."""
        found: Function = self.__dict__["found"]
        return found

    def source(self, reference: float = 1.0) -> Any:
        """Return the function with its parameters, as kernels take it."""
        from pgimp.physics.functions.call import source_of

        values: dict[str, Value] = {
            name: tuple(map(float, value)) if isinstance(value, tuple) else float(value)
            for name, value in self.arguments.items()
        }
        return source_of(self.registered, values, reference)

    def misfits(self, dimensions: int) -> Problems:
        """Yield the problem of a function that does not fit; paths from the entry."""
        from pgimp.physics.functions.fit import unfit

        if text := unfit(self.registered, self.source(), dimensions):
            yield Problem(("function",), text)
