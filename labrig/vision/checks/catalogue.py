"""Find the checks of a curve: the files of `kinds`, and those of other distributions.

A file adds one by its constant `CHECK`; another distribution by an entry point of the group
`labrig.curve_checks`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import cast

import numpy as np

from drivers.plugins import OWN, Part, PluginFolder
from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.seen_outline import SeenOutline
from labrig.vision.checks.unchanged import asked_unchanged


def _faults(part: object) -> list[str]:
    from labrig.vision.checks.conformance import faults

    return faults(part)


FOLDER: PluginFolder[CurveCheck] = PluginFolder(
    what="curve check",
    package="labrig.vision.checks.kinds",
    constant="CHECK",
    group="labrig.curve_checks",
    faults=_faults,
)
# parts that are asked besides those of the folder, where a test tries them
_TRIED: ContextVar[tuple[Part[CurveCheck], ...]] = ContextVar("tried", default=())


def curve_checks() -> dict[str, CurveCheck]:
    """Return all checks of a curve by name, in their order."""
    return {part.name: part.part for part in _in_order()}


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the curve checks of other distributions."""
    return FOLDER.origins()


@contextmanager
def asking_also(checks: Iterable[CurveCheck]) -> Iterator[None]:
    """Ask these checks, too, for as long as the context lasts, as of another distribution."""
    token = _TRIED.set(tuple(Part(check.name, check, "tried", "0") for check in checks))
    try:
        yield
    finally:
        _TRIED.reset(token)


def findings(seen: SeenCurve, stage: CheckStage) -> list[CurveFinding]:
    """Return what the checks of a stage say of a curve, in their order."""
    said = (_asked(part, seen) for part in _in_order() if part.part.stage == stage)
    return [finding for finding in said if finding is not None]


def outline_findings(seen: SeenOutline) -> list[CurveFinding]:
    """Return what the checks say of a curve between two edges.

    Those of its own stage, and other distributions' of any; labrig's own of other stages look at a
    fit of intensities, which `outline_report` replaces.
    """
    shared = cast("SeenCurve", seen)  # what both have is the contract; see `contract`
    said = (_asked(part, shared) for part in _in_order() if _looks_at_outlines(part))
    return [finding for finding in said if finding is not None]


def _looks_at_outlines(part: Part[CurveCheck]) -> bool:
    return part.distribution != OWN or part.part.stage == CheckStage.OUTLINE


def _in_order() -> list[Part[CurveCheck]]:
    every = [*FOLDER.parts().values(), *_TRIED.get()]
    return sorted(every, key=lambda part: part.part.order)


def _asked(part: Part[CurveCheck], seen: SeenCurve) -> CurveFinding | None:
    """Return its finding; what another distribution's check raises is a warning of the curve."""
    if part.distribution == OWN:
        return part.part.finding(seen)
    try:
        found = asked_unchanged(part.part.finding, seen)
        if found is not None:
            require_finding(found, len(seen.fit.shape.x))
    except (Exception, SystemExit) as error:  # noqa: BLE001 - other people's code may raise anything
        return CurveFinding(
            warning=f"the curve check '{part.name}' of {part.distribution} {part.version} failed "
            f"with {type(error).__name__}: {error}; the curve was not checked by it"
        )
    return found


def require_finding(found: object, nodes: int) -> None:
    """Raise TypeError or ValueError where another distribution's finding cannot be used."""
    if not isinstance(found, CurveFinding):
        raise TypeError(f"it returned {type(found).__name__}, not a CurveFinding")
    widens = found.widening_px is not None or bool(found.end_widening_px)
    if not (found.refusal or found.warning or widens):
        raise ValueError("its CurveFinding has neither a refusal nor a warning nor a widening")
    wide = found.widening_px
    if wide is not None and (np.shape(wide) != (nodes,) or not np.isfinite(wide).all()):
        raise ValueError(f"widening_px must be {nodes} finite numbers, one for each node")
    end = found.end_widening_px
    if np.shape(end) != () or not np.isfinite(end) or end < 0:
        raise ValueError("end_widening_px must be a number of pixels, 0 or more")
    at = found.refused_at_px
    if at is not None and (np.shape(at) != (2,) or not np.isfinite(at).all()):
        raise ValueError("refused_at_px must be a pixel's column and row")
