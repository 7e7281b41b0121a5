"""The mechanics of the rotary stage: where it is, where it goes, what stops it."""

from __future__ import annotations

import math

from drivers.interfaces import Clock
from sim_hardware.serial_devices.contract import ArcWorld
from sim_hardware.serial_devices.motion import Motion

MICROSTEP_RAD = math.radians(0.000234375)


class Axis:
    """A rotary axis that counts microsteps and carries the load cell along the arc.

    What it counts is off by `offset` from where it is until it has been homed. `warnings` holds the
    two-letter flags of the protocol. The world gets a new position in `settle`, once a movement
    has ended. `obstacle_rad`: an angle that cannot be passed; the axis stalls there.
    """

    def __init__(self, world: ArcWorld, clock: Clock, origin_m: float, offset: float) -> None:
        self._world = world
        self._clock = clock
        self._radius_m = world.settings.arc.radius_mm * 1e-3
        self._origin_m = origin_m
        self._offset = offset
        self._motion = Motion(clock.now(), 0.0)
        self._homing = False
        self._stalls = False
        self._came_from_m = self.position_m
        self.moving = False
        self.warnings: set[str] = set()
        self.obstacle_rad: float | None = None

    @property
    def counted(self) -> float:
        """Where it believes it is, in microsteps."""
        return self._motion.position_at(self._clock.now())

    @property
    def position_m(self) -> float:
        """Where on the arc it truly is."""
        return self._origin_m + (self.counted + self._offset) * MICROSTEP_RAD * self._radius_m

    def go(self, target: float, speed: float, acceleration: float) -> None:
        """Set out for a count, at most this fast (microsteps/s and /s^2)."""
        if self.moving:
            self.warnings.add("NI")
        else:
            self.warnings.discard("NI")
            self._came_from_m = self.position_m
        start = self.counted
        self._motion = self._motion_from_now().go(target, speed, acceleration)
        self.moving, self._homing = True, False
        self._stalls = self._meets_obstacle(start, target)

    def home(self, speed: float, acceleration: float) -> None:
        """Set out for the home sensor, which is where the true angle is 0."""
        self.go(-self._offset, speed, acceleration)
        self._homing = True

    def brake(self, acceleration: float) -> None:
        """Give up a movement, slowing down."""
        if self.moving:
            self.warnings.add("NI")
            self._homing = self._stalls = False
            self._motion = self._motion_from_now().brake(acceleration)

    def halt(self) -> None:
        """Give up a movement at once."""
        if self.moving:
            self.warnings.add("NI")
            self._homing = self._stalls = False
            self._motion = Motion(self._clock.now(), self.counted)

    def count_from(self, value: float) -> None:
        """Call the present place by this number, wherever it is."""
        self.halt()
        self._offset += self.counted - value
        self._motion = Motion(self._clock.now(), value)

    def settle(self) -> bool:
        """See whether a movement has ended since the last call; if so, put the load cell there."""
        if not self.moving or self._clock.now() < self._motion.end_s:
            return False
        self.moving = False
        if self._stalls:
            self.warnings.add("FS")
        elif self._homing:
            self.count_from(0.0)
            self.warnings.discard("WR")
        self._homing = self._stalls = False
        place = self.position_m
        self._world.place(place, approach="down" if place < self._came_from_m else "up")
        return True

    def _motion_from_now(self) -> Motion:
        now = self._clock.now()
        return Motion(now, self._motion.position_at(now), self._motion.speed_at(now))

    def _meets_obstacle(self, start: float, target: float) -> bool:
        """Cut the movement short in front of the obstacle, if there is one on the way."""
        if self.obstacle_rad is None:
            return False
        obstacle = self.obstacle_rad / MICROSTEP_RAD - self._offset
        if not min(start, target) <= obstacle <= max(start, target):
            return False
        gap = min(1.0, abs(obstacle - start))
        return self._motion.cut_at(obstacle - math.copysign(gap, target - start))
