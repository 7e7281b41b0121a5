"""What reads the force on the load cell: one kind a file (`contract` says what a kind is)."""

from drivers.force_sensors.contract import DEFAULT, FORCE_SENSORS, ForceSensorKind

__all__ = ["DEFAULT", "FORCE_SENSORS", "ForceSensorKind"]
