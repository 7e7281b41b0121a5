"""The ranking of candidates, the similarity of their signatures, and the inferred form."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from labrig.report.diagnosis.tables import best_and_named
from labrig.report.parts.style import ALONG_COLOUR, CONSTANT_COLOUR, INK, figure, letter
from model.discrepancy.verdict.result import Diagnosis, FormCurve, Ranked, Unknown
from model.effects import title

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 14  # candidates that are drawn
VISIBLE = 4.0  # sigmas from which on an effect would be found
_REACH = 1.645  # standard uncertainties to either side: 90 %
_FEW = 30  # points of a profile that are drawn as such
_LINEAR = 10.0  # up to here the axis of ln Bayes factors is linear, beyond logarithmic
_BARS_IN, _LEAST_IN = 1.6, 2.8  # widths of panels, which their titles need
_SOFT = "#9aa4b0"


def ranking_figure(found: Diagnosis) -> Figure | None:
    """Bars of ln Bayes factors with the threshold."""
    shown = best_and_named(found, MOST)[::-1]
    if not shown:
        return None
    with figure(6.2, 0.24 * len(shown) + 1.3) as fig:
        draw_ranking(fig.subplots(), found)
        return fig


def draw_ranking(axes: Axes, found: Diagnosis) -> None:
    """Draw the evidence for the best candidates and the named effects."""
    shown = best_and_named(found, MOST)[::-1]
    named = {one.name for one in found.effects}
    colours = [_colour(one, named, found) for one in shown]
    axes.barh(range(len(shown)), [one.log_bayes for one in shown], color=colours, height=0.7)
    axes.set_yticks(range(len(shown)), [title(one.name) for one in shown])
    axes.set_xscale("symlog", linthresh=_LINEAR, linscale=1.0)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "−"))
    axes.axvline(0, color=INK, linewidth=0.7)
    if np.isfinite(found.threshold):
        axes.axvline(found.threshold, color=INK, linewidth=1.0, linestyle=(0, (4, 2.5)))
        axes.annotate(
            f"threshold {found.threshold:.1f}", (found.threshold, 1.0), xytext=(0, 3),
            xycoords=axes.get_xaxis_transform(), textcoords="offset points", fontsize=8,
            ha="center", va="bottom",  # above the bars, which may be of any length
        )  # fmt: skip
    axes.set_xlabel("ln Bayes factor over the base model")
    axes.grid(visible=False, axis="y")


def _colour(one: Ranked, named: set[str], found: Diagnosis) -> str:
    if one.name in named:
        return ALONG_COLOUR
    is_it = found.unknown is not None and one.name == f"unknown:{found.unknown.location}"
    return CONSTANT_COLOUR if is_it else _SOFT


def signatures_figure(found: Diagnosis) -> Figure | None:
    """How alike the effects look in these data, and how visible each is."""
    seen = found.signatures
    n = len(seen.names)
    if n < 2:
        return None
    order = np.argsort(-np.nan_to_num(seen.detectability))
    names = [title(seen.names[i]) for i in order]
    wide = max(0.2 * n, _LEAST_IN)
    with figure(wide + 3.4, 0.2 * n + 1.9) as fig:
        panels = fig.subplots(1, 2, width_ratios=[wide, _BARS_IN], sharey=True)
        alike = np.abs(seen.cosine)[np.ix_(order, order)]
        hidden = np.array([seen.names[i] in found.invisible for i in order])
        alike = np.where(hidden[:, None] | hidden[None], np.nan, alike)
        drawn = panels[0].imshow(alike, cmap="cividis", vmin=0, vmax=1)
        panels[0].set_aspect("auto")
        panels[0].set_yticks(range(n), names, fontsize=7)
        panels[0].set_xticks(range(n), names, fontsize=7, rotation=90)
        panels[0].grid(visible=False)
        letter(panels[0], "a", "similarity of signatures")
        bar = fig.colorbar(drawn, ax=panels[0], location="bottom", aspect=40, pad=0.02)
        bar.set_label("|cosine|, B and EIBM refitted; blank: invisible")
        _visible(panels[1], seen.detectability[order], hidden)
        letter(panels[1], "b", "detectability")
        return fig


def _visible(axes: Axes, sigmas: np.ndarray, hidden: np.ndarray) -> None:
    shown = np.maximum(np.nan_to_num(sigmas), 0.1)
    axes.barh(
        range(len(shown)), shown, color=[_SOFT if h else ALONG_COLOUR for h in hidden], height=0.7
    )
    axes.set_xscale("log")
    axes.set_xlim(left=0.1)
    axes.axvline(VISIBLE, color=INK, linewidth=1.0, linestyle=(0, (4, 2.5)))
    axes.set_xlabel("standard uncertainties\nat the prior scale")
    axes.grid(visible=False, axis="y")


def form_figure(found: Diagnosis) -> Figure | None:
    """Draw the inferred form with its 90 % band: of named effects, or of the unknown one."""
    forms = [(one.name, one.form) for one in found.effects if one.form is not None]
    count = len(forms) + (found.unknown is not None)
    if not count:
        return None
    with figure(3.9 * count if count > 1 else 5.4, 3.3) as fig:
        panels = fig.subplots(1, count, squeeze=False)[0]
        for axes, (name, form), mark in zip(panels, forms, "abcdefgh", strict=False):
            _form(axes, form)
            letter(axes, mark, title(name))
        if found.unknown is not None:
            _profile(panels[-1], found.unknown)
            location = title(found.unknown.location)
            letter(panels[-1], "abcdefgh"[count - 1], f"unknown: {location}")
        return fig


def _form(axes: Axes, form: FormCurve) -> None:
    at = form.at
    low, high = form.inferred - _REACH * form.band, form.inferred + _REACH * form.band
    axes.fill_between(at, low, high, color=ALONG_COLOUR, alpha=0.2, linewidth=0, label="90 %")
    axes.plot(at, form.inferred, color=ALONG_COLOUR, label="estimated")
    axes.plot(at, form.catalogue, color=INK, linestyle=(0, (4, 2.5)), label="catalogue")
    axes.set_xlabel(_coordinate(form.along, form.unit))
    axes.set_ylabel(form.what)
    axes.legend(fontsize=8)


def _profile(axes: Axes, one: Unknown) -> None:
    at, band = one.s_mm, _REACH * one.band
    axes.axhline(0, color=INK, linewidth=0.7, alpha=0.6)
    axes.fill_between(
        at, one.profile - band, one.profile + band, color=CONSTANT_COLOUR, alpha=0.25, linewidth=0,
        label="90 %",
    )  # fmt: skip
    # set-ups are each by itself: what lies between them is drawn to guide the eye
    marker = "o" if len(at) <= _FEW else None
    axes.plot(
        at, one.profile, marker=marker, color=CONSTANT_COLOUR, label=f"{one.configuration} sheet"
    )
    axes.set_xlabel(_coordinate(one.along, one.at_unit))
    axes.set_ylabel(f"added to the {one.location.replace('_', ' ')} ({one.unit})")
    axes.legend(fontsize=8)


def _coordinate(along: str, unit: str) -> str:
    names = {
        "s": "distance along the sheet s", "place": "distance along the sheet s",
        "position": "position p", "time": "time",
    }  # fmt: skip
    return f"{names.get(along, along)} ({unit})"
