"""A parameter that is a random field."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from pgimp.physics.variation.base import Places, Reals, Variation
from pgimp.physics.variation.waves import lognormal, waves
from pgimp.schema.base import Model, NonNegative, Number, Positive
from pgimp.schema.dispatch import Either
from pgimp.schema.messages import describe
from pgimp.schema.problems import Problem, raise_problems


class RandomField(Model):
    """Statistics of a random field; the same on any number of ranks."""

    mean: Number = Field(description="mean of the values")
    cov: NonNegative | None = Field(
        default=None, description="coefficient of variation, the standard deviation over the mean"
    )
    deviation: NonNegative | None = Field(
        default=None, description="standard deviation, instead of `cov`"
    )
    distribution: Literal["lognormal", "normal"] = Field(
        default="lognormal",
        description="of the values at a point; lognormal ones have the sign of the mean",
    )
    correlation: Annotated[
        float | tuple[float, ...],
        Either(
            "a length, or one for each direction",
            {
                float: Positive,
                tuple: Annotated[tuple[Positive, ...], Field(min_length=1, max_length=3)],
            },
        ),
    ] = Field(
        description="correlation length l, or one for each direction; for exponential half of the "
        "scale of fluctuation [length]"
    )
    covariance: Literal["exponential", "gaussian"] = Field(
        default="exponential",
        description="correlation of the values (of their logarithms if lognormal) at two points: "
        "exp(-r) or exp(-r^2), r^2 the sum of (distance/l)^2 over the directions",
    )
    seed: Annotated[int, Field(strict=True, ge=0, le=2**53)] = Field(
        default=0,
        description="which of all such fields: parameters with the same seed, lengths, covariance "
        "and modes are fully correlated, with another seed they are independent",
    )
    modes: Annotated[int, Field(strict=True, ge=16, le=100_000)] = Field(
        default=1000,
        description="waves that a field is a sum of: correlations are off by up to 1/sqrt(2 modes)",
    )

    @model_validator(mode="after")
    def _check(self) -> RandomField:
        if (self.cov is None) == (self.deviation is None):
            text = "give one of cov and deviation"
            raise_problems("random", [Problem((), f"{text}, the scatter of the values")])
        if self.mean == 0.0 and (self.cov is not None or self.distribution == "lognormal"):
            text = "0 has no coefficient of variation; give a deviation, of distribution: normal"
            raise_problems("random", [Problem(("mean",), text)])
        return self

    @property
    def scatter(self) -> float:
        """Standard deviation over the size of the mean."""
        return self.cov if self.cov is not None else (self.deviation or 0.0) / abs(self.mean)

    def lengths(self, dimensions: int) -> tuple[float, ...]:
        """Correlation lengths along all directions."""
        found = self.correlation
        return found if isinstance(found, tuple) else (float(found),) * dimensions

    def values(self, x: Reals) -> Reals:
        """Values at positions, (n, D)."""
        lengths = self.lengths(x.shape[1])
        g = waves(self.covariance, lengths, self.seed, self.modes).at(x)
        if self.distribution == "lognormal":
            return lognormal(g, self.mean, self.scatter)
        deviation = self.deviation if self.cov is None else self.cov * abs(self.mean)
        assert deviation is not None
        return self.mean + deviation * g


class RandomVariation(Variation):
    """A random field."""

    random: RandomField = Field(description="its statistics, and which one it is")
    between: tuple[Number, Number] | None = Field(
        default=None, description="least and greatest value; what lies beyond gets these"
    )

    @model_validator(mode="after")
    def _check(self) -> RandomVariation:
        if self.between is not None and not self.between[0] < self.between[1]:
            text = "expected two numbers, the first below the second"
            raise_problems("between", [Problem(("between",), text)])
        return self

    def _typical(self) -> float | None:
        least, most = self.between or (-math.inf, math.inf)
        return min(max(self.random.mean, least), most)

    def own_values(self, places: Places) -> Reals:
        """See `Variation`."""
        found = self.random.values(places.x)
        if self.between is None:
            return found
        return np.minimum(np.maximum(found, self.between[0]), self.between[1])

    def _own_problems(self, dimensions: int) -> Iterator[Problem]:
        found = self.random.correlation
        if isinstance(found, tuple) and len(found) != dimensions:
            text = f"expected a length, or {dimensions}, one a direction, got {describe(found)}"
            yield Problem(("random", "correlation"), text)
