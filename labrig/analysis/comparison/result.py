"""What a comparison found, as numbers and names alone, and how a session keeps it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from labrig.config.base import parse_json
from labrig.errors import BadInputError
from labrig.serialise import from_plain, to_json
from labrig.session import load_finding, store_finding

NAME = "dynamic_comparison"


@dataclass(frozen=True, kw_only=True)
class ComparedQuantity:
    """How a model does with force, current or shape."""

    rmse: float  # of what was held out: N, A or m; NaN: it predicts nothing of that
    share: float  # of the values held out that it predicts
    ln_evidence: float  # of the fitted values of this quantity, fitted to them alone
    misfit: float  # in the common fit: residuals over what the noise explains; 1: no larger


@dataclass(frozen=True, kw_only=True)
class ComparedModel:
    """One model of a comparison."""

    name: str
    title: str
    why_not: str = ""  # why it was not fitted; empty: it was
    ln_evidence: float = float("nan")
    quantities: dict[str, ComparedQuantity] = field(default_factory=dict)  # that it predicts
    parameters: dict[str, float] = field(default_factory=dict)  # SI
    undetermined: tuple[str, ...] = ()  # parameters that these data do not determine


@dataclass(frozen=True, kw_only=True)
class DynamicComparison:
    """The models of one configuration, the largest ln evidence first."""

    configuration: str
    models: tuple[ComparedModel, ...]
    held_out: str  # in words
    values: dict[str, int]  # that were fitted, by quantity
    rate_hz: float  # of the samples that were used
    missing: tuple[str, ...] = ()  # what was not recorded


@dataclass(frozen=True)
class _Kept:
    comparisons: tuple[DynamicComparison, ...]


def keep_comparisons(session: Path, found: Sequence[DynamicComparison]) -> None:
    """Store them in the session, in place of older ones; a new analysis removes them."""
    store_finding(session, NAME, to_json(_Kept(tuple(found))))


def kept_comparisons(session: Path) -> tuple[DynamicComparison, ...]:
    """Return the comparisons that a session holds."""
    text = load_finding(session, NAME)
    if text is None:
        return ()
    try:
        plain = parse_json(text, f"{session}: its comparison of models in time")
        return from_plain(_Kept, plain, lenient=True).comparisons
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BadInputError(
            f"{session}: its comparison of models in time cannot be read ({error!r}); run labrig"
            f" compare {session} again."
        ) from None
