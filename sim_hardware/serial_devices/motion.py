"""The motion of a stage: constant acceleration, constant speed, constant deceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True, kw_only=True)
class _Phase:
    start_s: float
    duration_s: float
    position: float
    speed: float
    acceleration: float

    def position_at(self, when: float) -> float:
        t = min(max(when - self.start_s, 0.0), self.duration_s)
        return self.position + (self.speed + self.acceleration * t / 2) * t

    def speed_at(self, when: float) -> float:
        return self.speed + self.acceleration * min(when - self.start_s, self.duration_s)


class Motion:
    """A movement on the clock. Lengths are in any unit, times in s."""

    def __init__(self, start_s: float, position: float, speed: float = 0.0) -> None:
        self._phases: list[_Phase] = []
        self.end_s = start_s
        self._end = position
        self._end_speed = speed

    def position_at(self, when: float) -> float:
        """Position at a time; before and after the movement its ends."""
        if when >= self.end_s:
            return self._end
        for phase in self._phases:
            if when < phase.start_s + phase.duration_s:
                return phase.position_at(when)
        return self._end

    def speed_at(self, when: float) -> float:
        """Speed, with its sign, at a time."""
        for phase in self._phases:
            if phase.start_s <= when < phase.start_s + phase.duration_s:
                return phase.speed_at(when)
        return 0.0

    def go(self, target: float, top_speed: float, acceleration: float) -> Motion:
        """Go on to a target and come to rest there."""
        distance = target - self._end
        stopping = self._end_speed * abs(self._end_speed) / (2 * acceleration)
        if self._end_speed * distance < 0 or abs(stopping) > abs(distance):
            return self.brake(acceleration)._from_rest(target, top_speed, acceleration)
        if abs(self._end_speed) > top_speed:
            self._change_speed(math.copysign(top_speed, self._end_speed), acceleration)
        return self._from_rest(target, top_speed, acceleration)

    def brake(self, acceleration: float) -> Motion:
        """Come to rest."""
        self._change_speed(0.0, acceleration)
        return self

    def cut_at(self, position: float) -> bool:
        """End the movement abruptly where it first meets a position; False when it does not."""
        for k, phase in enumerate(self._phases):
            first, last = phase.position, phase.position_at(math.inf)
            if first != last and min(first, last) <= position <= max(first, last):
                early, late = 0.0, phase.duration_s
                while late - early > 1e-9:
                    middle = (early + late) / 2
                    beyond = abs(phase.position_at(phase.start_s + middle) - first)
                    early, late = (
                        (early, middle) if beyond >= abs(position - first) else (middle, late)
                    )
                self._phases[k] = replace(phase, duration_s=late)
                del self._phases[k + 1 :]
                self.end_s, self._end = phase.start_s + late, position
                return True
        return False

    def _from_rest(self, target: float, top_speed: float, acceleration: float) -> Motion:
        """Go to a target that lies ahead, from a speed at which one can still stop there."""
        distance = target - self._end
        speed = abs(self._end_speed)
        peak = min(top_speed, math.sqrt(acceleration * abs(distance) + speed * speed / 2))
        self._change_speed(math.copysign(peak, distance), acceleration)
        cruise = abs(target - self._end) - peak * peak / (2 * acceleration)
        if cruise > 0:
            self._add(cruise / peak, 0.0)
        self._change_speed(0.0, acceleration)
        self._end = target  # rounding aside, it is there
        return self

    def _change_speed(self, speed: float, acceleration: float) -> None:
        change = speed - self._end_speed
        if change:
            self._add(abs(change) / acceleration, math.copysign(acceleration, change))
        self._end_speed = speed

    def _add(self, duration_s: float, acceleration: float) -> None:
        phase = _Phase(
            start_s=self.end_s,
            duration_s=duration_s,
            position=self._end,
            speed=self._end_speed,
            acceleration=acceleration,
        )
        self._phases.append(phase)
        self.end_s += duration_s
        self._end = phase.position_at(self.end_s)
