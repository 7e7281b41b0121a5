"""A diagnosis as one self-contained page, with its figures as files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from labrig.errors import BadInputError
from labrig.report.diagnosis.figures import FIGURES, draw_diagnosis
from labrig.report.diagnosis.parameters import percent
from labrig.report.diagnosis.tables import verdict_title
from labrig.report.page.diagnosis_sections import sections_of
from labrig.report.page.page import FILES, PAGE, check_page_is_free, render_page, write_page
from labrig.report.page.summary import Card
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.table import fixed
from model.discrepancy.thresholds import REPORTED_GAP_RATIO
from model.discrepancy.verdict.messages import answer_title, located
from model.discrepancy.verdict.result import Diagnosis
from model.effects import title

# title, name of the gap, decimals
MEANS = (
    ("Force error (RMS) before → after, mN", "force_rmse_mN", 3),
    ("Curve error (RMS) before → after, mm", "curve_rmse_mm", 3),
)
IN_TIME = (
    ("Force error along a run (RMS) before → after, mN", "drift_rmse_mN", 4),
    ("Curve error along a run (RMS) before → after, mm", "drift_rmse_mm", 4),
    ("Force error within a pulse (RMS) before → after, mN", "pulse_rmse_mN", 4),
)


def check_folder(folder: Path) -> None:
    """Raise BadInputError where it is a file, or holds a page that is no diagnosis."""
    if folder.exists() and not folder.is_dir():
        raise BadInputError(f"{folder}: this is a file, a folder is needed.")
    check_page_is_free(folder, of_session=False)


def write_diagnosis(found: Diagnosis, folder: Path) -> Path:
    """Write the page and its figures and return the page's path."""
    check_folder(folder)
    figures = FigureFolder(folder / "figures")
    drawn = draw_diagnosis(found, figures)
    figures.remove_others(FIGURES)
    text = render_page(
        "diagnosis.html.j2",
        title=_title(found),
        found=found,
        cards=_cards(found),
        remarks=[],
        sections=sections_of(found, drawn),
        files=FILES,
    )
    write_page(text, folder / PAGE)
    return folder / PAGE


def _title(found: Diagnosis) -> str:
    return f"{found.model.source or 'measurements'}: {verdict_title(found)}"


def _cards(found: Diagnosis) -> list[Card]:
    cards = []
    named = [
        (
            " or ".join(map(answer_title, (e.name, *e.confusable_with, *e.or_else))),
            percent(e.confidence),
            "",
        )
        for e in found.effects
    ]
    if named:
        cards.append(Card("Effects, posterior probability", tuple(named)))
    if found.unknown is not None:
        where = f"{found.unknown.peak_mm:.3g} {found.unknown.at_unit}"
        cards.append(
            Card(
                "Unknown effect",
                (
                    (located(found.unknown), f"most at {where}", ""),
                    *(
                        (f"or {title(name)}", percent(share), "")
                        for name, share in found.unknown.other_locations.items()
                    ),
                ),
            )
        )
    cards += [
        Card(title, tuple(_gap_line(found, part, key, decimals) for part in ("fitted", "held_out")))
        for title, key, decimals in (*MEANS, *IN_TIME)
        if _worth_a_card(found, key)
    ]
    if found.closed_gap is not None:
        one = found.closed_gap
        cards.append(
            Card("Gap closed, left-out positions", ((one.quantity, percent(one.share), ""),))
        )
    return cards


def _worth_a_card(found: Diagnosis, key: str) -> bool:
    """Of the gaps in time only what shrinks: most sessions have none."""
    before, after = (getattr(g, key) for g in (found.held_out.before, found.held_out.after))
    in_time = key in {own for _, own, _ in IN_TIME}
    measured = bool(np.isfinite(getattr(found.fitted.before, key)))
    return measured and (not in_time or before > REPORTED_GAP_RATIO * after)


def _gap_line(found: Diagnosis, part: str, key: str, decimals: int) -> tuple[str, str, str]:
    both = getattr(found, part)
    before, after = (fixed(getattr(g, key), decimals) for g in (both.before, both.after))
    return "fitted" if part == "fitted" else "left out", f"{before} → {after}", ""
