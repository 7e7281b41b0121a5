"""Record the identity of a rig's devices: what each reports, or its calibration."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import replace

from drivers.force_sensors.metered_input import MeteredInput
from drivers.identity import identities_of
from drivers.interfaces import AcquisitionSettings, Camera, DeviceIdentity
from labrig.experiment.plan import Plan
from labrig.experiment.rig.rig import Rig
from labrig.session.format.devices import (
    AMPLIFIER,
    BOARDS,
    CAMERA,
    FORCE_SENSOR,
    LOAD_CELL,
    STAGE,
    CalibrationRecord,
    RecordedDevice,
)


def recorded_devices(rig: Rig, plan: Plan) -> tuple[RecordedDevice, ...]:
    """Return every device of an open rig. Never raises: one that reports nothing is not known."""
    found = (*_that_report(rig), *_calibrated(rig, plan))
    if not rig.config.is_simulated:
        return found
    return tuple(
        replace(each, identity=replace(each.identity, is_simulated=True)) for each in found
    )


def _that_report(rig: Rig) -> Iterator[RecordedDevice]:
    config = rig.config
    yield from _devices(BOARDS, config.boards_kind, identities_of(rig.boards))
    if isinstance(rig.signals, MeteredInput):
        yield from _devices(FORCE_SENSOR, config.force_sensor.kind, rig.signals.sensor_identities)
    yield from _devices(STAGE, config.stage.kind, identities_of(rig.stage))


def _devices(part: str, kind: str, told: Iterable[DeviceIdentity]) -> list[RecordedDevice]:
    found = [RecordedDevice(part=part, kind=kind, identity=identity) for identity in told]
    return found or [RecordedDevice(part=part, kind=kind)]


def _calibrated(rig: Rig, plan: Plan) -> Iterator[RecordedDevice]:
    config, optics, cell = rig.config, plan.optics, plan.calibration
    if config.camera is not None:
        date = "" if optics is None or optics.date is None else str(optics.date)
        calibration = _calibration(plan, "optics.json", config.camera.optics.name, date)
        for device in _devices(CAMERA, config.camera.kind, identities_of(rig.camera)):
            found = None if rig.camera is None else acquisition_of(rig.camera)
            yield replace(device, calibration=calibration, acquisition=found)
    name = config.load_cell.calibration.name
    yield RecordedDevice(
        part=LOAD_CELL,
        identity=DeviceIdentity(serial=cell.serial),
        calibration=_calibration(plan, "load_cell.toml", name, str(cell.date)),
    )
    amplifier = config.amplifier
    date = "" if amplifier.calibrated is None else str(amplifier.calibrated)
    yield RecordedDevice(
        part=AMPLIFIER,
        identity=DeviceIdentity(product=amplifier.product, serial=amplifier.serial),
        calibration=_calibration(plan, "rig.toml", "rig.toml", date),
    )


def acquisition_of(camera: Camera) -> AcquisitionSettings | None:
    """Return what an open camera has set; None where it cannot say."""
    try:
        found = camera.settings
    except (Exception, SystemExit):  # noqa: BLE001 - what a camera says of itself keeps it from no run
        return None
    return found if isinstance(found, AcquisitionSettings) else None


def _calibration(plan: Plan, key: str, name: str, date: str) -> CalibrationRecord:
    """`key`: the name of its text in the plan."""
    sha256 = hashlib.sha256(plan.texts[key].encode("utf-8")).hexdigest()
    return CalibrationRecord(name=name, date=date, sha256=sha256)
