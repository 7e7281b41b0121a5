"""A T-series device behind its wire: which one it is, and how its inputs are set."""

from __future__ import annotations

from collections.abc import Callable

from drivers.boards.labjack.registers import (
    FIRMWARE_VERSION,
    MODELS,
    NONE,
    PAIRS,
    PRODUCT_ID,
    SERIAL_NUMBER,
    Model,
    model_of,
    negative_register,
    range_register,
)
from drivers.boards.labjack.wire import Transport, Wire, Write
from drivers.interfaces import Clock, DeviceError, DeviceNotFoundError

_GROUND = 199  # as negative input: measure against ground


class LabJackDevice:
    """One device. `open` finds out which model it is."""

    def __init__(
        self, address: str, clock: Clock, transport: Callable[[], Transport] | None = None
    ) -> None:
        self.wire = Wire(address, clock, transport)
        self.serial = 0
        self.firmware = 0.0
        self._model: Model | None = None

    @property
    def model(self) -> Model:
        """The model; known once it is open."""
        if self._model is None:
            raise DeviceError(f"the connection to {self.wire.where} is not open")
        return self._model

    def open(self) -> None:
        """Ask what it is. Raises DeviceNotFoundError, DeviceTimeoutError. May be called again."""
        doing = "asking which device it is"
        product, firmware, serial = self.wire.read(
            doing, PRODUCT_ID, FIRMWARE_VERSION, SERIAL_NUMBER
        )
        self._model = model_of(product)
        if self._model is None:
            raise DeviceNotFoundError(
                f"{self.wire.where} is of another type (product {product:g}) than "
                f"{', '.join(MODELS)}; correct [labjack] address"
            )
        self.serial, self.firmware = int(serial), firmware

    def close(self) -> None:
        """End the connection. May be called twice."""
        self._model = None
        self.wire.close()

    def input_settings(self, number: int, range_V: float) -> list[Write]:
        """Return what sets an input to a range, measured against its negative terminal."""
        model = self.model
        if number >= model.inputs or (model.differential == PAIRS and number % 2):
            raise DeviceNotFoundError(
                f"{self.wire.where} is a {model.name}, which has no input AIN{number} of this "
                f"kind; {_INPUTS[model.name]}"
            )
        writes = [Write(range_register(number), range_V if model.differential != NONE else 0.0)]
        if model.differential == PAIRS:
            writes.append(Write(negative_register(number), number + 1))
        elif model.differential == NONE:
            writes.append(Write(negative_register(number), _GROUND))
        return writes


_INPUTS = {
    "T4": "take AIN0 to AIN3, which measure ±10 V against ground",
    "T7": "take an even one, AIN0 to AIN12: the next one is its negative side",
    "T8": "take AIN0 to AIN7",
}
