"""The identified parameters: table 4, the EIBM along the sheet (figure 8), how far they hold."""

from __future__ import annotations

import numpy as np

from labrig.report.data.findings import Findings
from labrig.report.figures.moment import moment_figure
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Drawn, Section
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.fit import one_by_one_table, scatter_table, trust
from labrig.report.tables.paper import table_4
from model import ConfiguredSheet

_SOURCE = (
    "The parameters are from a fit made for this report, as labrig fit makes it; no model file is "
    "read. The diagnosis refits B and EIBM together with its effects."
)


def applies(findings: Findings) -> bool:
    """Whether something was fitted, or could not be."""
    return findings.fit is not None or bool(findings.fitted.missing)


def make(findings: Findings, figures: FigureFolder) -> Section | str:
    """Return the parameters, or why there are none."""
    fit = findings.fit
    missing = tuple(
        f"{name}: could not be fitted: {why.rstrip('.')}."
        for name, why in findings.fitted.missing.items()
    )
    if fit is None:
        return Section(sentences=missing)
    each = any(one.paper is not None for one in fit.configurations.values())
    return Section(
        (
            table_4(fit),
            *_moments(findings, figures),
            scatter_table(fit),
            *([one_by_one_table(fit)] if each else []),
        ),
        (*missing, *trust(fit), _SOURCE),
    )


def _moments(findings: Findings, figures: FigureFolder) -> tuple[Drawn, ...]:
    models = findings.fitted.models
    if models is None:
        return ()
    fitted = [name for name in findings.names if models.along.sheets.get(name)]
    fitted = [name for name in fitted if _varies(models.along.sheets[name])]
    if not fitted:
        return ()
    return figures.draw(
        "figure-8",
        "Figure 8. Electrically induced bending moment along the sheet",
        "EIBM along the sheet (8) with its 90 % interval; dashed: constant EIBM (9).",
        lambda: moment_figure(models, fitted),
    )


def _varies(sheet: ConfiguredSheet) -> bool:
    """Whether its EIBM is known to vary along it: without curves it is not."""
    return any(np.ptp(along.values) > 0 for along in sheet.eibm.values())


SECTION = ReportSection(
    title="Identified parameters", order=20, applies=applies, make=make, figures=("figure-8",)
)
