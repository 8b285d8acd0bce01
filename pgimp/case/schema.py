"""Typed models of the case file; `pgimp.case.checks` has the conditions between its parts.

Descriptions end with the unit in square brackets, in terms of any consistent set of length, mass
and time; stress is mass/(length time^2). Tension is positive.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property, partial
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from pgimp.case.accuracy.entry import Accuracy
from pgimp.case.body import Body
from pgimp.case.checks.parts import check, sound_parts
from pgimp.case.choices.choose import left_out, without_choice
from pgimp.case.choices.forms import AUTO_METHOD, MethodEntry, or_bonded
from pgimp.case.choices.resolve import resolve
from pgimp.case.damping import Damping
from pgimp.case.defaults import with_defaults
from pgimp.case.gauges import GaugeEntry
from pgimp.case.grid import Grid
from pgimp.case.outflow import OutflowEntry
from pgimp.case.output import Checkpoint, History, Output, ProbeEntry
from pgimp.case.stages import Staged
from pgimp.case.staging.arrange import arrange
from pgimp.case.staging.inflow import told_once
from pgimp.case.start import StartEntry
from pgimp.case.stepping.courant import largest_courant
from pgimp.case.stepping.steps import AUTO, CourantStep
from pgimp.case.time import Time
from pgimp.physics.contact.pairs import ContactEntry
from pgimp.physics.functions.over_time import until
from pgimp.physics.loads.constraints import ConstraintEntry
from pgimp.physics.loads.inflow import InflowEntry
from pgimp.physics.loads.tractions import TractionEntry
from pgimp.physics.loads.water import Water
from pgimp.physics.rigid import RigidBody
from pgimp.schema.base import Count, Label, Model, Name
from pgimp.schema.dispatch import WithKey
from pgimp.schema.messages import explain
from pgimp.schema.problems import problem, raise_problems
from pgimp.schema.registries import ByField, ByName, ByWord
from pgimp.schema.sizes import faces
from pgimp.schema.tables import VaryingVector
from pgimp.schema.words.renew import renewed


def _format(value: int) -> int:
    if value not in (1, 2):
        raise problem(f"this pgimp reads formats 1 and 2, got {value}")
    return value


def _dimensions(value: int) -> int:
    if value > 3:
        raise problem(f"expected 1, 2 (plane strain) or 3, got {value}")
    return value


def _shapes() -> Mapping[str, type[BaseModel]]:
    from pgimp.physics.shapes import SHAPES

    return SHAPES


def _materials() -> Mapping[str, type[BaseModel]]:
    from pgimp.physics.materials import MATERIALS

    return MATERIALS


#: Hint for unknown material models.
_OUTSIDE = "; one from outside the package must be registered: --import FILE.py"


def _boundaries() -> Mapping[str, type[BaseModel]]:
    from pgimp.physics.boundaries import BOUNDARIES

    return BOUNDARIES


def _solutions() -> Mapping[str, type[BaseModel]]:
    from pgimp.physics.exact import EXACT

    return EXACT


def _body_forces() -> Mapping[str, type[BaseModel]]:
    from pgimp.physics.loads import BODY_FORCES

    return BODY_FORCES


class Case(Model):
    """A case: everything that defines a run."""

    format: Annotated[Count, AfterValidator(_format)] = Field(
        description="version of the case file's format. 2 chooses what is left out of the method, "
        "whatever else of it is given; 1 only where shape, particles-per-cell or time.step is left "
        "out, too",
        json_schema_extra={"enum": [1, 2]},
    )
    title: Label = Field(default="", description="one line about the case")
    units: Label = Field(
        default="none", description="a label only; any consistent set of length, mass and time"
    )
    dimensions: Annotated[Count, AfterValidator(_dimensions)] = Field(
        description="1, 2 (per unit thickness, see `geometry`) or 3",
        json_schema_extra={"enum": [1, 2, 3]},
    )
    geometry: Literal["plane-strain", "plane-stress", "axisymmetric"] = Field(
        default="plane-strain",
        description="in 2 dimensions: plane-strain; plane-stress, where no stress acts across, and "
        "all is per unit of the initial thickness; or axisymmetric, where x is the radius, y the "
        "axis at x = 0, and particles are rings: masses, volumes, forces and energies are of the "
        "whole body, all round the axis",
    )
    grid: Grid = Field(description="the regular grid, which is the domain")
    method: Annotated[Any, MethodEntry(_shapes, "shape", "shape")] = Field(
        default=AUTO_METHOD,
        description="the shape of the particles, which decides the method. What is left out of it "
        "is chosen, and so are `formulation` and `mass` of bodies, `time.step` and `contact`, by "
        "rules that the page 'Which method' has; `pgimp check` and the run say what and why. In "
        "format 1 nothing is chosen where shape, particles-per-cell and time.step are given, but "
        "for keys that say auto",
    )
    time: Time = Field(description="end and step")
    start: StartEntry = Field(default=StartEntry(), description="the state at time 0")
    materials: dict[Name, Annotated[Any, ByField(_materials, "model", "model", _OUTSIDE)]] = Field(
        min_length=1,
        max_length=100,
        description="the materials by name",
        json_schema_extra={"additionalProperties": False},
    )
    every_body: dict[Name, Annotated[Any, WithKey("rigid", RigidBody, Body)]] = Field(
        alias="bodies",
        min_length=1,
        max_length=10_000,
        description="the bodies by name: of a material, or with the key `rigid`",
        json_schema_extra={"additionalProperties": False},
    )
    gravity: VaryingVector = Field(
        default=None,
        description="body force per mass: a vector, or a table over time, linear in between and "
        "held at both ends; null: none [length/time^2]",
    )
    body_force: Annotated[Any, ByName(_body_forces, "body force")] = Field(
        default=None,
        alias="body-force",
        description="body force that depends on place, velocity or time, besides gravity; null: "
        "none",
    )
    water: Water | None = Field(
        default=None,
        description="water at rest in the pores of the ground: below its level stresses are "
        "effective ones, and the weight is that in water; null: none",
    )
    damping: Damping | None = Field(
        default=None,
        description="damping of all bodies at the vertices of the grid, for static solutions and "
        "vibrations that die away; null: none",
    )
    boundaries: dict[str, Annotated[Any, ByWord(_boundaries, "boundary condition")]] = Field(
        default={},
        description="conditions on faces of the domain, x-min to z-max. A face with a condition "
        "holds in what is inside: a particle whose centre passes it is set back onto it, and its "
        "velocity into the wall becomes that of the wall, as a force of the wall (reaction); the "
        "log counts such particle-steps. One that moves the material out of the domain, or leaves "
        "it free along its normal, holds nothing in. A face that is not named is open: it acts "
        "only on a particle whose centre crosses it, as `outflow` says",
        json_schema_extra={"propertyNames": {"enum": [*faces(3)]}},
    )
    outflow: dict[Name, OutflowEntry] = Field(
        default={},
        description="what becomes of a particle whose centre has crossed an open face: stop, which "
        "is the default, ends the run; remove takes it out, and what it had of mass, momentum and "
        "energy goes into the columns `outflow` of the history. A sink, by a name of its own, "
        "takes out what comes into its region. For example {x-max: remove, bin: {region: ..}}",
        json_schema_extra={"additionalProperties": False},
    )
    tractions: dict[Name, TractionEntry] = Field(
        default={},
        max_length=60,
        description="forces on faces of bodies, by a name of their own",
        json_schema_extra={"additionalProperties": False},
    )
    constraints: dict[Name, ConstraintEntry] = Field(
        default={},
        max_length=60,
        description="prescribed motion of parts of bodies, by a name of their own",
        json_schema_extra={"additionalProperties": False},
    )
    inflow: dict[Name, InflowEntry] = Field(
        default={},
        max_length=60,
        description="material that enters, by the name of its body, whose region it fills",
        json_schema_extra={"additionalProperties": False},
    )
    contact: tuple[ContactEntry, ...] = Field(
        default=(),
        max_length=60,
        description="what happens where bodies meet. Bodies of a pair that an entry is for have "
        "velocity fields of their own; all others share one, so that they interact up to "
        "two cells before they touch, and are bonded. Left out where the method is "
        "chosen, or auto: bodies that may meet do so without friction; bonded: all are",
        json_schema_extra=or_bonded,
    )
    exact: Annotated[Any, ByName(_solutions, "solution")] = Field(
        default=None,
        description="the exact solution of the case, from which history.csv gives the errors; "
        "null: none known",
    )
    output: Output = Field(default=Output(), description="frames")
    history: History = Field(default=History(), description="history.csv")
    probes: dict[Name, ProbeEntry] = Field(
        default={},
        max_length=200,
        description="what is followed in a file of its own, `probes/NAME.csv`: a material point, "
        "{body: bar, at: [50.0]}, or a place fixed in space, {place: [50.0]}",
        json_schema_extra={"additionalProperties": False},
    )
    gauges: dict[Name, GaugeEntry] = Field(
        default={},
        max_length=60,
        description="forces through cuts, fluxes, forces on parts of walls and levels, in columns "
        "`gauge.NAME` of history.csv",
        json_schema_extra={"additionalProperties": False},
    )
    checkpoint: Checkpoint = Field(default=Checkpoint(), description="checkpoints")
    accuracy: Accuracy | None = Field(
        default=None,
        description="the error that a quantity may have: pgimp runs the case on larger cells "
        "first, and chooses the cells by them; null: the cells are those of the case",
    )

    @property
    def stages(self) -> tuple[Case, ...]:
        """The case of each stage; the case itself if it has none."""
        found: tuple[Case, ...] = self.__dict__.get("arranged") or (self,)
        return found

    @property
    def staged(self) -> Staged:
        """Data from previous stages, if the case is a stage."""
        found: Staged = self.__dict__.get("staged_as", Staged())
        return found

    @property
    def rests(self) -> bool:
        """Whether the case is a stage after the first that comes to rest, and no more."""
        return self.staged.number > 0 and self.start.equilibrate is not None

    @property
    def axisymmetric(self) -> bool:
        """Whether x is the radius about the axis y."""
        return self.geometry == "axisymmetric"

    @property
    def courant(self) -> float | None:
        """Courant number of steps that follow the fastest wave; None for fixed steps."""
        step = self.time.step
        if not isinstance(step, CourantStep):
            return None
        if step.courant == "auto":
            return AUTO * largest_courant(self)
        return float(step.courant)

    @property
    def watched(self) -> bool:
        """Whether pgimp chooses the Courant number, and watches the energy."""
        return isinstance(self.time.step, CourantStep) and self.time.step.courant == "auto"

    @cached_property
    def bodies(self) -> dict[str, Body]:
        """Bodies of a material, which have particles."""
        return {name: body for name, body in self.every_body.items() if isinstance(body, Body)}

    @cached_property
    def body_names(self) -> list[str]:
        """Names of the bodies that have particles, by number."""
        return list(self.bodies)

    @cached_property
    def rigid_bodies(self) -> dict[str, RigidBody]:
        """The rigid bodies."""
        every = self.every_body.items()
        return {name: body for name, body in every if isinstance(body, RigidBody)}

    @model_validator(mode="wrap")
    @classmethod
    def _check_parts(
        cls, data: Any, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo
    ) -> Self:
        """Check the conditions between the parts, even if some parts are wrong."""
        if not isinstance(data, dict):
            return handler(data)
        context = info.context or {}
        if not context:  # a stage's data are those of the case
            data = renewed(data)
        written, data = data, with_defaults(data)
        known = context.get("counted", 0.0), context.get("began", 0.0), context.get("gone", ())
        span = data.get("time")
        with until(span.get("end") if isinstance(span, Mapping) else None):
            sound = partial(cls._check_sound, handler=handler, known=known, written=written)
            open_keys = left_out(data)
            if open_keys is None:
                return sound(without_choice(data))
            case: Self = resolve(data, open_keys, handler, sound)
            return case

    @classmethod
    def _check_sound(
        cls,
        data: dict[str, Any],
        handler: ModelWrapValidatorHandler[Self],
        known: tuple[Any, Any, Any],
        written: dict[str, Any],
    ) -> Self:
        try:
            case = handler(data)
        except ValidationError as error:
            problems = explain(cls, error, data)
            problems.extend(check(sound_parts(cls, data, problems), *known))
        else:
            problems = check({name: getattr(case, name) for name in cls.model_fields}, *known)
            if case.exact is not None and not problems:
                problems = list(case.exact.problems(case))
            if case.time.stages and not problems:
                case.__dict__["arranged"], problems = arrange(case)
        raise_problems(cls.__name__, told_once(problems, written), data)
        return case
