"""The parameters of a moving sheet, as logarithms, with their weak priors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.line import ElectrodeLine
from model.measurements import FloatArray, ModelError

WEAK = 1.0  # standard deviation of a logarithm: of eta, shares and times
WIDE = 3.0  # of all others: nothing but that they exist


class _IdentifiedQuantity(NamedTuple):
    name: str
    value: float
    unit: str
    prior_sigma: float


@dataclass(frozen=True)
class LogParameters:
    """Logarithms theta (p,) of what is unknown of a beam, and the beam for each theta.

    What is 0 in `start` (loss, leak, a moment per volt) stays 0 and is no parameter.
    """

    start: DynamicBeam

    @cached_property
    def quantities(self) -> tuple[_IdentifiedQuantity, ...]:
        """Return the parameters in order."""
        beam = self.start
        if beam.electrodes is None:
            raise ModelError("to identify a sheet its electrodes must be described")
        line, (up, down), m = beam.electrodes, beam.moment_per_volt_Nm, beam.material
        prony = [
            q for i, (share, time) in enumerate(zip(m.shares, m.times_s, strict=True), 1)
            for q in (_IdentifiedQuantity(f"share_{i}", share, "1", WEAK),
                      _IdentifiedQuantity(f"time_{i}", time, "s", WEAK))
        ]  # fmt: skip
        every = (
            _IdentifiedQuantity("B", m.B_Nm2, "N m^2", WIDE),
            _IdentifiedQuantity("mass_per_length", beam.mass_per_length_kg_per_m, "kg/m", WIDE),
            _IdentifiedQuantity("viscous_time", m.viscous_time_s, "s", WEAK),
            *prony,
            _IdentifiedQuantity("electrode_resistance", line.electrode_ohm_per_m, "ohm/m", WIDE),
            _IdentifiedQuantity("capacitance", line.capacitance_F_per_m, "F/m", WIDE),
            _IdentifiedQuantity("bulk_resistance", line.bulk_ohm_m, "ohm m", WIDE),
            _IdentifiedQuantity("leak", line.leak_S_per_m, "S/m", WIDE),
            _IdentifiedQuantity("moment_per_positive_volt", up, "N m/V", WIDE),
            _IdentifiedQuantity("moment_per_negative_volt", down, "N m/V", WIDE),
        )
        return tuple(q for q in every if q.value != 0.0)

    @cached_property
    def theta(self) -> FloatArray:
        """Return the logarithms of `start`, the centre of the priors."""
        return np.log(np.abs([q.value for q in self.quantities]))

    @cached_property
    def precision(self) -> FloatArray:
        """Return 1/variance of each prior."""
        return np.array([q.prior_sigma**-2 for q in self.quantities])

    @cached_property
    def length_of_line(self) -> FloatArray:
        """Return the direction (p,) in which the electrodes are those of a longer line."""
        along = dict.fromkeys(("electrode_resistance", "capacitance", "leak"), 1.0)
        along["bulk_resistance"] = -1.0
        return np.array([along.get(q.name, 0.0) for q in self.quantities])

    @cached_property
    def directions(self) -> FloatArray:
        """Return the steps (p, p), in rows, along which derivatives are taken best.

        Stiffness, mass and moments together in place of the stiffness alone: a free sheet moves as
        before then, which the sum of four derivatives, each a little off, would not say.
        """
        names = [q.name for q in self.quantities]
        together = ("B", "mass_per_length", "moment_per_positive_volt", "moment_per_negative_volt")
        along = np.eye(len(names))
        along[names.index("B")] = [float(name in together) for name in names]
        return along

    @cached_property
    def _amounts(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Return which (p,) the motion grows with in proportion: losses, not times."""
        return np.array([
            q.name == "viscous_time" or q.name.startswith("share_") for q in self.quantities
        ])  # fmt: skip

    def grown(self, moved: FloatArray) -> FloatArray:
        """Return how many times larger derivatives (p,) are when the logarithms have moved."""
        return np.where(self._amounts, np.exp(np.where(self._amounts, moved, 0.0)), 1.0)

    def step(self, towards: FloatArray, longest: float) -> FloatArray:
        """Return a step of the logarithms from one (p,) that is right where it is short.

        `longest`: of a logarithm. An amount of loss changes by a share of itself, not as its
        logarithm would: others, known far better, make up for it along a straight line then.
        """
        least = np.where(self._amounts, -np.expm1(-longest), longest)
        most = np.where(self._amounts, np.expm1(longest), longest)
        over = np.max(np.where(towards < 0.0, -towards / least, towards / most), initial=1.0)
        part = towards / over
        amounts = np.log1p(np.where(self._amounts, part, 0.0))
        return np.asarray(np.where(self._amounts, amounts, part))

    def values(self, theta: FloatArray) -> dict[str, float]:
        """Return the values by name; a moment per volt keeps its sign."""
        found = np.exp(theta) * np.sign([q.value for q in self.quantities])
        return dict(zip([q.name for q in self.quantities], found.tolist(), strict=True))

    def beam(self, theta: FloatArray) -> DynamicBeam:
        """Return the beam with these logarithms."""
        at, beam, m = self.values(theta), self.start, self.start.material
        terms = range(1, len(m.shares) + 1)
        material = replace(
            m, B_Nm2=at["B"], viscous_time_s=at.get("viscous_time", 0.0),
            shares=tuple(at[f"share_{i}"] for i in terms),
            times_s=tuple(at[f"time_{i}"] for i in terms),
        )  # fmt: skip
        electrodes = ElectrodeLine(
            electrode_ohm_per_m=at["electrode_resistance"], capacitance_F_per_m=at["capacitance"],
            bulk_ohm_m=at["bulk_resistance"], leak_S_per_m=at.get("leak", 0.0),
            source_ohm=beam.electrodes.source_ohm if beam.electrodes else 1.0,
        )  # fmt: skip
        moments = tuple(at.get(f"moment_per_{sign}_volt", 0.0) for sign in ("positive", "negative"))
        return replace(
            beam, material=material, electrodes=electrodes,
            mass_per_length_kg_per_m=at["mass_per_length"],
            moment_per_volt_Nm=(moments[0], moments[1]),
        )  # fmt: skip
