"""From the drive to the bending moment: electrodes in time, or a moment that is prescribed."""

from __future__ import annotations

import numpy as np

from model.dynamics.beam import DynamicBeam, HeldVoltage, PrescribedMoment
from model.dynamics.line import LineModes
from model.dynamics.space import Space, moments
from model.measurements import FloatArray, ModelError
from model.mechanics.field import Field

Drive = HeldVoltage | PrescribedMoment
NO_VOLTAGE_V = 1e-6  # of the double layer: less is what remains of a charge
Electrical = tuple[FloatArray, FloatArray, FloatArray]  # source, V(0) and current


class DrivenMoment:
    """int Me P_j ds, with the electrodes' state from piece to piece of a motion."""

    def __init__(self, beam: DynamicBeam, drive: Drive, line_terms: int) -> None:
        """Charge the electrodes by what was held before time 0. Raises ModelError."""
        self._beam = beam
        self.line: LineModes | None = None
        self._state = np.zeros(line_terms)
        if beam.electrodes is not None:
            self.line = LineModes(beam.electrodes, beam.length_m, line_terms)
            if isinstance(drive, HeldVoltage):
                self._state = self.line.charged(drive.time_s, drive.voltage_V)
        elif any(beam.moment_per_volt_Nm):
            raise ModelError("a moment per volt needs the sheet's electrodes")

    def bent_at_begin(self, drive: Drive) -> Field:
        """Return the curvature that a free sheet would begin with."""
        beam, zero = self._beam, np.zeros(1)
        kinks = beam.rest.breaks_m[1:-1]
        B = beam.material.B_Nm2
        if isinstance(drive, PrescribedMoment):
            return Field.smooth(
                lambda s: beam.rest(s) + drive.at(zero, s)[0] / B, beam.length_m, kinks
            )
        if self.line is None or not self._state.any():
            return beam.rest
        line, modes = self.line, self._state
        return Field.smooth(
            lambda s: beam.rest(s) + beam.moment_of(line.at(s) @ modes) / B, beam.length_m, kinks
        )

    def take(self, on: Space) -> None:
        """Prepare the integrals over a space."""
        self._on, self._moments = on, moments(on)
        if self.line is not None:
            self._line_at_nodes = self.line.at(np.minimum(on.s_m, self._beam.length_m))
            up = self._beam.moment_per_volt_Nm[0]
            self._per_mode = up * (self._moments @ self._line_at_nodes).T

    def at_begin(self, drive: Drive) -> FloatArray:
        """Return int Me P_j ds at time 0, (N,)."""
        if isinstance(drive, PrescribedMoment):
            return np.asarray(self._moments @ drive.at(np.zeros(1), self._on.s_m)[0])
        return np.asarray(self._of_modes(self._state[None])[0])

    def moment_per_volt_Nm(self) -> FloatArray:
        """Return dMe/dU at each node, by the sign of U there; where it is 0 V the mean of both."""
        up, down = self._beam.moment_per_volt_Nm
        mean = np.full(len(self._on.s_m), 0.5 * (up + down))
        if self.line is None:
            return mean
        U = self._line_at_nodes @ self._state
        return np.where(np.abs(U) < NO_VOLTAGE_V, mean, np.where(U > 0.0, up, down))

    def follow(
        self, drive: Drive, ends_s: FloatArray, step_s: FloatArray
    ) -> tuple[FloatArray, Electrical]:
        """Return int Me P_j ds (n + 1, N), and voltage, V(0) and current at the steps' ends."""
        nothing = np.zeros(len(ends_s))
        if isinstance(drive, PrescribedMoment):
            return drive.at(ends_s, self._on.s_m) @ self._moments.T, (nothing,) * 3
        held = drive.at(ends_s[:-1] + 0.5 * step_s)
        source = np.concatenate([held[:1], held]) if len(held) else drive.at(ends_s)
        if self.line is None:
            return np.zeros((len(ends_s), self._on.size)), (source, source, nothing)
        modes = self.line.respond(self._state, step_s, held)
        self._state = modes[-1]
        clamp = self.line.clamp_V(modes, source)
        return self._of_modes(modes), (source, clamp, (source - clamp) / self.line.line.source_ohm)

    def _of_modes(self, modes: FloatArray) -> FloatArray:
        """Return int Me P_j ds (n, N) of the line's modes (n, T)."""
        if self.line is None:
            return np.zeros((len(modes), self._on.size))
        up, down = self._beam.moment_per_volt_Nm
        if up == down:
            return np.asarray(modes @ self._per_mode)
        return np.asarray(self._beam.moment_of(modes @ self._line_at_nodes.T) @ self._moments.T)
