"""controller.toml: a controller of the force, what it was made from, and where it may be used."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
import tomlkit
from pydantic import Field, model_validator

from drivers.load_cell import LoadCellCalibration
from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.config.file_kinds import CONTROLLER, refuse_other_kind
from labrig.config.rig import RigConfig
from labrig.errors import BadInputError
from labrig.files import write_text
from model.measurements import ModelError, SheetGeometry
from protocols.execution.runs.control_loop import FeedbackLaw

if TYPE_CHECKING:
    from model.dynamics.linear.feedback import ForceController
    from model.dynamics.linear.state_space import LinearSystem

MOST_STATES = 100
SLOWEST_HZ, FASTEST_HZ = 4.0, 2000.0
LONGEST_DELAY_MS, HIGHEST_V = 1000.0, 30.0
_HEADER = (
    "A controller of the force, for labrig run --controller.",
    "Each period u = C x + D [r, y], x+ = A x + B [r, y] + anti_windup (written - u), with the",
    "reference r and the measured force y in N above that at 0 V, and the voltage u in V.",
)

Positive = Annotated[float, Field(gt=0)]
Row = Annotated[list[float], Field(max_length=MOST_STATES)]
Matrix = Annotated[list[Row], Field(max_length=MOST_STATES)]
Checksum = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class ControllerLimits(ClosedModel):
    """What ends or bounds a controlled run, together with [limits] of the rig."""

    voltage_V: float = Field(gt=0, le=HIGHEST_V, description="largest, either sign")
    saturated_s: float = Field(
        1.0, gt=0, le=60.0, description="the voltage may be at its limit for so long"
    )


class DesignedFor(ClosedModel):
    """The model file that the controller was designed with."""

    file: str
    sha256: Checksum


class ControlledSheet(ClosedModel):
    """The sheet that the model describes."""

    free_length_mm: Positive
    width_mm: Positive
    thickness_mm: Positive
    elongation_mm: float = Field(ge=0)
    arc_radius_mm: Positive

    @classmethod
    def of(cls, sheet: SheetGeometry) -> Self:
        """Return what is compared of a sheet."""
        return cls(
            free_length_mm=round(1e3 * sheet.free_length_m, 6),
            width_mm=round(1e3 * sheet.width_m, 6),
            thickness_mm=round(1e3 * sheet.thickness_m, 6),
            elongation_mm=round(1e3 * sheet.elongation_m, 6),
            arc_radius_mm=round(1e3 * sheet.arc_radius_m, 6),
        )


class ControlledRig(ClosedModel):
    """The rig that the controller was made for, where it was named."""

    sha256: Checksum


class LawMatrices(ClosedModel):
    """The controller, for one period."""

    A: Matrix
    B: Matrix
    C: Row
    D: Row
    anti_windup: Row

    @classmethod
    def of(cls, controller: ForceController) -> Self:
        """Return a controller's matrices as the file has them."""
        law = controller.law
        return cls(
            A=law.A.tolist(),
            B=law.B.tolist(),
            C=law.C[0].tolist(),
            D=law.D[0].tolist(),
            anti_windup=controller.anti_windup.tolist(),
        )


class PlantMatrices(ClosedModel):
    """The model of sheet and rig with which the loop was found stable, from period to period."""

    rate_hz: Positive
    A: Matrix
    B: Row
    C: Row

    @classmethod
    def of(cls, plant: LinearSystem, rate_hz: float) -> Self:
        """Return the matrices of a plant that is sampled at a rate, with one input and output."""
        return cls(
            rate_hz=rate_hz,
            A=plant.A.tolist(),
            B=plant.B[:, 0].tolist(),
            C=plant.C[0].tolist(),
        )


class StepPrediction(ClosedModel):
    """What the linear model says of the loop."""

    sensitivity_peak: Positive
    step_mN: float
    rise_s: float = Field(ge=0)
    settled_s: float = Field(ge=0)


class ControllerConfig(ClosedModel):
    """The whole of controller.toml."""

    labrig_controller: Literal[1]
    method: Literal["pi", "lqg", "other"]
    output: Literal["force"]
    configuration: str = Field(min_length=1)
    position_mm: float
    rate_hz: float = Field(ge=SLOWEST_HZ, le=FASTEST_HZ)
    delay_ms: float = Field(
        ge=0, le=LONGEST_DELAY_MS, description="from a force to the voltage it leads to"
    )
    limits: ControllerLimits
    model: DesignedFor
    sheet: ControlledSheet
    rig: ControlledRig | None = None
    prediction: StepPrediction | None = None
    law: LawMatrices
    plant: PlantMatrices

    @model_validator(mode="after")
    def _is_a_stable_loop(self) -> Self:
        if abs(self.plant.rate_hz / self.rate_hz - 1.0) > 1e-9:
            raise ValueError(
                f"the controller runs at rate_hz = {self.rate_hz:g}, but its [plant] is sampled "
                f"at {self.plant.rate_hz:g} Hz; make the controller anew"
            )
        try:
            stable = self.controller.closed_loop(self.plant_model).is_stable
        except ModelError as error:
            raise ValueError(f"[law] and [plant] do not fit together: {error}") from None
        if not stable:
            raise ValueError("the loop of [law] and [plant] is unstable; nothing is run with it")
        return self

    @property
    def controller(self) -> ForceController:
        """As `model` takes it. Raises ModelError for matrices that do not fit together."""
        from model.dynamics.linear.feedback import controller_of

        law = self.law
        n = len(law.A)
        return controller_of(
            A=_matrix(law.A, (n, n), "[law] A"),
            B=_matrix(law.B, (n, 2), "[law] B"),
            C=_matrix([law.C], (1, n), "[law] C"),
            D=_matrix([law.D], (1, 2), "[law] D"),
            anti_windup=_matrix([law.anti_windup], (1, n), "[law] anti_windup")[0],
            sample_time_s=1.0 / self.rate_hz,
        )

    @property
    def plant_model(self) -> LinearSystem:
        """The sampled model of sheet and rig. Raises ModelError."""
        from model.dynamics.linear.state_space import LinearSystem

        plant = self.plant
        n = len(plant.A)
        return LinearSystem(
            A=_matrix(plant.A, (n, n), "[plant] A"),
            B=_matrix([plant.B], (1, n), "[plant] B").T,
            C=_matrix([plant.C], (1, n), "[plant] C"),
            D=np.zeros((1, 1)),
            inputs=("voltage_V",),
            outputs=("force_N",),
            sample_time_s=1.0 / plant.rate_hz,
        )

    def feedback(self) -> FeedbackLaw:
        """As a run takes it."""
        law = self.controller.law
        return FeedbackLaw(
            A=law.A,
            B=law.B,
            C=law.C[0],
            D=law.D[0],
            anti_windup=self.controller.anti_windup,
            rate_hz=self.rate_hz,
            limit_V=self.limits.voltage_V,
            saturated_s=self.limits.saturated_s,
        )


def _matrix(rows: list[list[float]], shape: tuple[int, int], name: str) -> np.ndarray:
    """Return an array. Raises ModelError unless it has this shape."""
    lengths = {len(row) for row in rows}
    if len(rows) != shape[0] or (shape[0] and lengths != {shape[1]}):
        raise ModelError(f"{name} should have {shape[0]} rows of {shape[1]} numbers")
    return np.array(rows, dtype=float).reshape(shape)


def parse_controller(text: str, name: str) -> ControllerConfig:
    """Return controller.toml's text as an object; BadInputError has a sentence for each fault."""
    refuse_other_kind(text, name, CONTROLLER)
    return validate(ControllerConfig, parse_toml(text, name), name)


def load_controller(path: Path) -> ControllerConfig:
    """Read controller.toml. Raises BadInputError, also where its model file has changed since."""
    found = parse_controller(read_text(path, CONTROLLER), str(path))
    require_same_model(found, path)
    return found


def save_controller(controller: ControllerConfig, path: Path) -> None:
    """Write a controller beside its place and rename it."""
    document = tomlkit.document()
    for line in _HEADER:
        document.add(tomlkit.comment(line))
    for key, value in controller.model_dump(mode="json", exclude_none=True).items():
        document.add(key, value)
    write_text(path, tomlkit.dumps(document))


def checksum_of(text: str) -> str:
    """Return the sha256 of a file's text."""
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def rig_checksum(rig: RigConfig, calibration: LoadCellCalibration) -> str:
    """Return a sha256 of what of a rig a loop depends on: gain, load cell, sample rate, limit."""
    facts: dict[str, Any] = {
        "gain": rig.amplifier.gain,
        "sheet_voltage_V": rig.limits.sheet_voltage_V,
        "sensitivity_V_per_N": calibration.sensitivity_V_per_N,
        "sample_rate_hz": rig.boards.sample_rate_hz,
    }
    return checksum_of(json.dumps(facts, sort_keys=True))


def require_same_model(controller: ControllerConfig, path: Path) -> None:
    """Raise BadInputError when the model file beside a controller is not the one it came from."""
    file = path.parent / controller.model.file
    if not file.exists():
        return
    if checksum_of(read_text(file)) != controller.model.sha256:
        raise BadInputError(
            f"{path}: was made from another {controller.model.file} than the one that lies beside "
            "it; make the controller anew."
        )


def require_fit(
    controller: ControllerConfig,
    name: str,
    rig: RigConfig,
    sheets: dict[str, SheetGeometry],
    calibration: LoadCellCalibration,
) -> None:
    """Raise BadInputError unless a controller is for this sheet and this rig; `name` is its file's.

    The rig must read the force with its boards, as often as the controller runs at least.
    """
    sheet = sheets.get(controller.configuration)
    if sheet is None:
        raise BadInputError(
            f"{name}: configuration = {controller.configuration!r} is no table of sheet.toml, "
            f"which has {', '.join(sheets)}."
        )
    wanted, there = controller.sheet.model_dump(), ControlledSheet.of(sheet).model_dump()
    for key, value in wanted.items():
        if abs(value - there[key]) > 1e-6:
            raise BadInputError(
                f"{name}: was made for another sheet: {key} = {value:g} there, {there[key]:g} in "
                "sheet.toml."
            )
    if controller.rig is not None and controller.rig.sha256 != rig_checksum(rig, calibration):
        raise BadInputError(
            f"{name}: was made for another rig (its gain, limit, sample rate or load cell differ); "
            "make the controller anew."
        )
    if rig.raw_force_unit == "N":
        raise BadInputError(
            f"{name}: a controller needs the load cell on the boards; [force_sensor] kind = "
            f'"{rig.force_sensor.kind}" is too slow.'
        )
    if rig.boards.sample_rate_hz < controller.rate_hz:
        raise BadInputError(
            f"{name}: runs at {controller.rate_hz:g} Hz, but the rig samples at "
            f"{rig.boards.sample_rate_hz:g} Hz; use a controller for a lower rate."
        )
