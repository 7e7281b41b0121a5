"""The same session of a larger or smaller rig: physics is free of scale."""

from __future__ import annotations

from dataclasses import replace

from model.measurements import Condition, Curve, Measurements, Reading, SheetGeometry


def scaled(m: Measurements, length: float, force: float) -> Measurements:
    """With all lengths and forces times a factor; the modulus stays by another thickness."""

    def curve(one: Curve | None) -> Curve | None:
        if one is None:
            return None
        k, s, ks = one.curvature_per_m, one.sigma_m, one.curvature_sigma_per_m
        return replace(
            one, s_m=one.s_m * length, x_m=one.x_m * length, y_m=one.y_m * length,
            curvature_per_m=None if k is None else k / length,
            sigma_m=None if s is None else s * length,
            curvature_sigma_per_m=None if ks is None else ks / length,
        )  # fmt: skip

    def reading(one: Reading) -> Reading:
        sd_N = None if one.sd_N is None else one.sd_N * force
        return replace(one, force_N=one.force_N * force, sd_N=sd_N, curve=curve(one.curve))

    def condition(one: Condition) -> Condition:
        return replace(
            one, position_m=None if one.position_m is None else one.position_m * length,
            readings=tuple(map(reading, one.readings)), curve=curve(one.curve), contact=None,
        )  # fmt: skip

    def sheet(one: SheetGeometry) -> SheetGeometry:
        k0 = one.initial_curvature
        return replace(
            one, free_length_m=one.free_length_m * length, width_m=one.width_m * length,
            thickness_m=one.thickness_m * (force * length) ** (1.0 / 3.0),
            elongation_m=one.elongation_m * length, arc_radius_m=one.arc_radius_m * length,
            clamped_length_m=one.clamped_length_m * length,
            initial_curvature=None if k0 is None else (k0[0] * length, k0[1] / length),
        )  # fmt: skip

    return replace(
        m, sheets={name: sheet(one) for name, one in m.sheets.items()},
        conditions=tuple(map(condition, m.conditions)),
        series=tuple(
            replace(
                one, position_m=None if one.position_m is None else one.position_m * length,
                force_N=None if one.force_N is None else one.force_N * force,
            )
            for one in m.series
        ),
    )  # fmt: skip
