"""What a generator of sessions offers, and what a method is asked.

A generator is one file, NAME.py in `generators`, with one object, `WORLD`; files `_NAME_*.py` there
are parts of it. It solves the sheet with numerics of its own, words every effect in its own way,
and has a noise and set-ups of its own. It imports neither `model` (but for the table
`model.measurements`) nor another generator, and of `sim_hardware` only `sim_hardware.world.motion`,
a chain in time: it shares nothing with `model` either, and no procedure was tuned on it.
`conformance.faults(NAME)` says where it breaks this contract.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from model.measurements import Measurements

LOCATIONS = (
    "rest_curvature", "eibm", "even_moment", "compliance", "position", "load_cell", "camera",
    "time",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Design:
    """What is measured: by default the paper's protocol, with ten readings of each voltage."""

    positions_m: Mapping[str, tuple[float, ...]] = field(
        default_factory=lambda: {
            "long": (0.0, 0.005, 0.010, 0.015, 0.020, 0.025, 0.030),
            "short": (0.0, 0.005, 0.010, 0.015, 0.020, 0.025, 0.030),
        }
    )
    voltages_V: tuple[float, float] = (2.0, -2.0)
    readings: int = 10  # of each voltage
    discarded: int = 2  # pulses at the beginning of a run
    pulse_s: float = 0.6
    sample_s: float = 0.5  # after the edge
    free_shapes: int = 0  # runs without the load cell, of each configuration
    remounts: int = 0  # positions of each configuration that are set anew and measured again
    random_order: bool = False
    series: bool = True  # force over time within the pulses; and curves of single readings
    curve_points: int = 25


@dataclass(frozen=True, kw_only=True)
class HiddenKind:
    """Something that a generator can hide, in its own words."""

    words: str  # one sentence: what happens, with its formula
    known_as: str | None  # the catalogue's name for it; None: no catalogue has it
    locations: tuple[str, ...]  # where an answer 'unknown' may put it
    typical: float  # a size that a laboratory meets
    largest: float  # beyond this it makes no sense
    unit: str
    needs: tuple[str, ...] = ()  # "series", "free_shapes": it leaves nothing without
    own_form: bool = False  # the form is the catalogue's: see `World.parameters`


class World(Protocol):
    """A rig and a sheet that nobody who fits a model has written."""

    name: str
    numerics: str  # how the sheet is solved, in a phrase
    noise: str  # what the noise and the set-ups are like, in a sentence
    kinds: Mapping[str, HiddenKind]

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        """Return a session in which kinds of these sizes are hidden (none: the base model).

        Base model: B of each configuration, one EIBM for each voltage and configuration, settled
        at the sampling point, the stated rest curvature; the true values differ from seed to seed.
        The same seed gives the same sheet, set-ups and noise whatever is hidden, so that the
        difference of two sessions is the signature of what is hidden. A method is given the sheets
        as they are stated where nothing is hidden. `exact`: no noise, nominal set-ups, amid the
        session; for conditions that no session holds. Raises ValueError for a
        kind or size that it does not have.
        """

    def parameters(self, kind: str, size: float) -> Mapping[str, float]:
        """Return the catalogue's parameters at this size; empty where the form is another one."""
