"""The report's page: one HTML file with everything in it, that asks no other host for anything."""

from __future__ import annotations

import re
from pathlib import Path

from labrig.files import write_text
from labrig.report.data.findings import Findings
from labrig.report.diagnosis.sections import findings_in_short
from labrig.report.figures.all_figures import Drawn
from labrig.report.page.overview import overview
from labrig.report.page.summary import MOST_WARNINGS, cards, remarks
from labrig.report.parts.section import Folded, Section
from labrig.report.parts.table import Table
from labrig.report.tables.baselines import baseline_table
from labrig.report.tables.fit import one_by_one_table, residual_table, scatter_table, trust
from labrig.report.tables.observations import observations
from labrig.report.tables.paper import compared_conditions, table_3, table_4, table_5, table_6


def sections(found: Findings, drawn: dict[str, Drawn]) -> list[Section]:
    """All parts for which there is something to show."""
    parts = [
        _experiment(found, drawn),
        _parameters(found, drawn),
        _simulations(found, drawn),
        *([findings_in_short(found.diagnosis, drawn)] if found.diagnosis is not None else []),
        _quality(found),
        _configuration(found),
        _record(found),
    ]
    return [part for part in parts if part.items or part.sentences]


def _experiment(found: Findings, drawn: dict[str, Drawn]) -> Section:
    if found.measurements is None:
        return Section("Experiment", (), (f"Nothing could be measured: {found.why_not}",))
    items: list[Table | Drawn | Folded] = []
    if found.names:
        items.append(table_3(found.measurements, found.names, found.fit))
    items += _those(drawn, "figure-5", "figure-6", "figure-7", "frames")
    return Section("Experiment", tuple(items))


def _those(drawn: dict[str, Drawn], *names: str) -> list[Drawn]:
    return [drawn[name] for name in names if name in drawn]


def _parameters(found: Findings, drawn: dict[str, Drawn]) -> Section:
    fit = found.fit
    missing = tuple(
        f"{name}: could not be fitted: {why.rstrip('.')}."
        for name, why in found.fitted.missing.items()
    )
    if fit is None:
        return Section("Identified parameters", (), missing)
    items: list[Table | Drawn | Folded] = [table_4(fit), *_those(drawn, "figure-8")]
    items.append(scatter_table(fit))
    if any(one.paper is not None for one in fit.configurations.values()):
        items.append(one_by_one_table(fit))
    return Section("Identified parameters", tuple(items), (*missing, *trust(fit)))


def _simulations(found: Findings, drawn: dict[str, Drawn]) -> Section:
    items: list[Table | Drawn | Folded] = list(_those(drawn, "figure-9"))
    fit, measurements = found.fit, found.measurements
    if fit is not None and measurements is not None:
        compared = compared_conditions(measurements, fit)
        if compared:
            items.append(table_5(fit, compared))
        items += _those(drawn, "table-5")
        items.append(table_6(fit))
    if measurements is not None and found.names:
        items.append(observations(measurements, fit))
    if found.baselines:
        items.append(baseline_table(found.baselines))
    if fit is not None:
        table = residual_table(fit)
        items.append(Folded(table.title, table))
    return Section("Simulation and measurement", tuple(items))


def _quality(found: Findings) -> Section:
    runs = overview(found.session).tables()[1]
    folded = [Folded("All runs", runs)] if runs.rows else []
    warned = [] if found.measurements is None else found.measurements.warnings
    if len(warned) > MOST_WARNINGS:
        table = Table("", ("",), tuple((text,) for text in warned))
        folded.append(Folded(f"All {len(warned)} warnings of the analysis", table))
    return Section("Quality of the data", (*found.quality.tables, *folded))


def _configuration(found: Findings) -> Section:
    texts = sorted(found.session.texts.items())
    return Section("Configuration", tuple(Folded(name, text=text) for name, text in texts))


def _record(found: Findings) -> Section:
    session = found.session
    facts, _, log = overview(session).tables(log=True)
    sums = [("recorded data, sha256", session.checksum)]
    if found.measurements is not None and found.measurements.checksum:
        sums.append(("measurements were made from", found.measurements.checksum))
    versions = tuple(sorted(session.versions.items()))
    return Section(
        "Record",
        (
            Table("Session", facts.columns, (*facts.rows, *sums)),
            Table("Recorded with", ("", ""), versions),
            Folded(f"Event log, {len(log.rows)} lines", log),
        ),
    )


def render(found: Findings, drawn: dict[str, Drawn]) -> str:
    """The page's text."""
    return render_page(
        "session.html.j2",
        title=found.session.path.name,
        session=found.session,
        names=found.names,
        cards=cards(found),
        remarks=remarks(found),
        sections=sections(found, drawn),
    )


def render_page(template: str, **values: object) -> str:
    """A page of this look: title, cards, remarks, sections, and what its template asks for."""
    import importlib.metadata

    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("labrig.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["table"] = lambda item: isinstance(item, Table)
    environment.tests["drawn"] = lambda item: isinstance(item, Drawn)
    environment.filters["minus"] = lambda text: _with_true_minus(str(text))
    version = importlib.metadata.version("labrig")
    return environment.get_template(template).render(version=version, **values)


def _with_true_minus(text: str) -> str:
    return re.sub(r"(?<![\w.])-(?=\d)|(?<= )-(?= )", "\N{MINUS SIGN}", text)


def write_page(text: str, path: Path) -> None:
    """Write the page beside its place and rename it."""
    write_text(path, text)
