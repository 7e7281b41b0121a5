"""The result of a stage of checks: accepted, refused or warned of."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.catalogue import findings, outline_findings
from labrig.vision.checks.contract import CheckStage, CurveFinding, Pixel
from labrig.vision.checks.gap_continuity import GapJoin
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.seen_outline import SeenOutline
from labrig.vision.checks.sheet_end import SheetEnd
from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False, kw_only=True)
class StageVerdict:
    """What the checks of one stage say. `why` is empty when the curve passes."""

    why: str
    refused_at_px: Pixel | None  # where that shows; None: nowhere in particular
    warnings: tuple[str, ...]
    widening_px: FloatArray  # (nodes,): what they add to the uncertainty, in quadrature
    end_widening_px: float  # and to that of a measured end, along the curve


@dataclass(frozen=True, eq=False, kw_only=True)
class Verdict(StageVerdict):
    """The judgement on a candidate, and what it is worth beside others."""

    covered: float
    residual_px: float
    worth: float  # to choose between candidates: how much of the image the curve explains
    join: GapJoin  # the least likely one of what is seen before and beyond hidden stretches


def check_curve(
    fit: CurveFit,
    context: FitContext,
    sheet_end: SheetEnd,
    *,
    followed: bool = False,
    beside: bool = True,
) -> Verdict:
    """Return the verdict on a candidate.

    `followed`: from the image before, whose end and surroundings were checked. `beside`: check
    what lies beside the curve.
    """
    seen = SeenCurve(
        fit=fit, context=context, sheet_end=sheet_end, followed=followed, beside_checked=beside
    )
    found = judge(seen, CheckStage.CANDIDATE)
    return Verdict(
        why=found.why,
        refused_at_px=found.refused_at_px,
        warnings=found.warnings,
        widening_px=found.widening_px,
        end_widening_px=found.end_widening_px,
        covered=seen.covered,
        residual_px=seen.residual_px,
        worth=_worth(seen) * (0.3 if found.why else 1.0),
        join=seen.join,
    )


def judge(seen: SeenCurve, stage: CheckStage) -> StageVerdict:
    """Return what the checks of a stage say of a curve."""
    return _together(findings(seen, stage), len(seen.fit.shape.x))


def judge_outline(seen: SeenOutline) -> StageVerdict:
    """Return what the checks say of a curve between two edges."""
    return _together(outline_findings(seen), len(seen.fit.shape.x))


def _together(found: list[CurveFinding], nodes: int) -> StageVerdict:
    refusal = next((each for each in found if each.refusal), CurveFinding())
    return StageVerdict(
        why=refusal.refusal,
        refused_at_px=refusal.refused_at_px,
        warnings=tuple(each.warning for each in found if each.warning),
        widening_px=_widening_px(found, nodes),
        end_widening_px=math.hypot(*(each.end_widening_px for each in found)),
    )


def _worth(seen: SeenCurve) -> float:
    fit = seen.fit
    if not fit.used.any():
        return 0.0
    strength = np.abs(fit.contrast[fit.used]) / seen.context.image.noise
    return float(np.minimum(strength, 50).sum() / len(fit.used))


def _widening_px(found: list[CurveFinding], nodes: int) -> FloatArray:
    square = np.zeros(nodes)
    for each in found:
        if each.widening_px is not None:
            square += each.widening_px**2
    return np.asarray(np.sqrt(square))
