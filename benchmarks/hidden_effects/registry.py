"""All forms in which something can be hidden."""

from __future__ import annotations

from benchmarks.hidden_effects.forms import Form
from benchmarks.hidden_effects.outside import FORMS as OUTSIDE_FORMS
from benchmarks.hidden_effects.rig_effects import FORMS as RIG_FORMS
from benchmarks.hidden_effects.sheet_effects import FORMS as SHEET_FORMS

CATALOGUE = tuple(dict.fromkeys(f.effect for f in (*SHEET_FORMS, *RIG_FORMS)))
"""Names of the catalogue's effects, all of which can be hidden."""
OUTSIDE = tuple(dict.fromkeys(f.effect for f in OUTSIDE_FORMS))
"""Names, of our own, of effects that no catalogue has."""
_ALL = (*SHEET_FORMS, *RIG_FORMS, *OUTSIDE_FORMS)


def forms_of(effect: str) -> tuple[Form, ...]:
    """The forms of an effect, the usual one first."""
    found = tuple(f for f in _ALL if f.effect == effect)
    if not found:
        raise KeyError(f"nothing called {effect} can be hidden: {', '.join(CATALOGUE + OUTSIDE)}")
    return found


def form_of(effect: str, form: str = "") -> Form:
    """One form of an effect."""
    forms = forms_of(effect)
    for each in forms:
        if form in ("", each.form):
            return each
    names = ", ".join(f.form for f in forms)
    raise KeyError(f"{effect} cannot be hidden as {form}; its forms are {names}")
