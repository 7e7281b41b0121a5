"""Sessions in which something is hidden that the base model does not know, with the truth apart."""

from benchmarks.hidden_effects.cases import Case, Extras, Hiding, case
from benchmarks.hidden_effects.files import write
from benchmarks.hidden_effects.forms import Form
from benchmarks.hidden_effects.registry import CATALOGUE, OUTSIDE, form_of, forms_of
from benchmarks.hidden_effects.sessions import Hidden, hidden_session
from benchmarks.hidden_effects.sizes import curve_gap_mm, force_gap_mN, size_for, size_for_gap
from benchmarks.hidden_effects.truth import Truth

__all__ = [
    "CATALOGUE",
    "OUTSIDE",
    "Case",
    "Extras",
    "Form",
    "Hidden",
    "Hiding",
    "Truth",
    "case",
    "curve_gap_mm",
    "force_gap_mN",
    "form_of",
    "forms_of",
    "hidden_session",
    "size_for",
    "size_for_gap",
    "write",
]
