"""A check of a curve is tried on curves of drawn strips, of every stage."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache

from drivers.plugins import first_faults
from labrig.extractors.examples import STRIP, examples
from labrig.vision import neutral_curve
from labrig.vision.checks.catalogue import asking_also, require_finding
from labrig.vision.checks.conformance import faults as faults_of_form
from labrig.vision.checks.contract import CheckStage, CurveCheck
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.unchanged import asked_unchanged


@dataclass(frozen=True, kw_only=True)
class _Recorder(CurveCheck):
    """Keeps what checks of its stage are asked about, and finds nothing wrong with it."""

    asked: list[SeenCurve] = field(default_factory=list)

    def finding(self, seen: SeenCurve) -> None:
        """Keep it."""
        self.asked.append(seen)


def curve_check_faults(check: object) -> list[str]:
    """Return what is wrong with a check, a sentence each without its full stop.

    It is asked about drawn strips at its stage, and about one that is seen between two edges.
    """
    found = first_faults([lambda: faults_of_form(check)])
    if found or not isinstance(check, CurveCheck):
        return found
    for what, seen in _asked_about(check.stage):
        said = first_faults([lambda seen=seen: _faults_on(check, seen)])  # type: ignore[misc]
        if said:
            return [f"asked about {what}, {text}" for text in said]
    return []


def _faults_on(check: CurveCheck, seen: SeenCurve) -> Iterator[str]:
    found = asked_unchanged(check.finding, seen)
    if found is None:
        return
    try:
        require_finding(found, len(seen.fit.shape.x))
    except (TypeError, ValueError) as error:
        yield str(error)


def _asked_about(stage: CheckStage) -> Iterator[tuple[str, SeenCurve]]:
    """Yield what such a check is asked about, with a name."""
    curves, outlines = _seen_strips()
    if stage != CheckStage.OUTLINE:
        yield from (("a drawn strip (SeenCurve)", seen) for seen in curves[stage])
    yield from (("the outline of a drawn strip (SeenOutline)", seen) for seen in outlines)


@cache
def _seen_strips() -> tuple[dict[CheckStage, list[SeenCurve]], list[SeenCurve]]:
    """Return what checks are asked about by stage, and outlines."""
    stages = [stage for stage in CheckStage if stage != CheckStage.OUTLINE]
    recorders = {
        stage: _Recorder(name=f"tried_{stage}", looks_at="it", stage=stage, order=10_000)
        for stage in stages
    }
    outlines = _Recorder(
        name="tried_outline", looks_at="it", stage=CheckStage.OUTLINE, order=10_000
    )
    strips = [example for example in examples() if example.curvature_per_m is not None][:2]
    with asking_also(recorders.values()):
        for example in strips:
            neutral_curve(example.image, example.optics, STRIP)
    with asking_also([outlines]):
        for example in strips:
            neutral_curve(example.image, example.optics, replace(STRIP, length_known=False))
    return {stage: recorder.asked for stage, recorder in recorders.items()}, outlines.asked
