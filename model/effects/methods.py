"""Whether the methods of an effect take and return what those of the contract do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from inspect import signature

import numpy as np

from model.effects.interface import BeamProblem, Effect

_KINDS = {
    "beam": "a BeamProblem",
    "course": "two arrays",
    "lagging": "pairs of arrays",
    "force": "an array",
    "curve": "two arrays",
    "in_image": "an array",
}


def faults_of_calls(effect: Effect, names: Iterable[str]) -> Iterator[str]:
    """Yield which of these methods does not take what the contract's does."""
    for name in names:
        arguments = list(signature(getattr(Effect, name)).parameters)[1:]
        try:
            signature(getattr(effect, name)).bind(*arguments)
        except TypeError as error:
            yield f"its {name} cannot be called as {name}({', '.join(arguments)}): {error}"


def faults_of_answer(name: str, made: object) -> Iterator[str]:
    """Yield that a method returned another kind of thing."""
    if not _is_of_kind(name, made):
        yield f"its {name} returned {type(made).__name__}, not {_KINDS[name]}"


def _is_of_kind(name: str, made: object) -> bool:
    if name == "beam":
        return isinstance(made, BeamProblem)
    if name == "lagging":
        return isinstance(made, Sequence) and all(map(_are_two_arrays, made))
    if made is None:
        return True
    return isinstance(made, np.ndarray) if name in ("force", "in_image") else _are_two_arrays(made)


def _are_two_arrays(made: object) -> bool:
    return (
        isinstance(made, Sequence)
        and len(made) == 2
        and all(isinstance(one, np.ndarray) for one in made)
    )
