"""How a hidden kind acts: each overrides where it does."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.session.layout import Samples

Array = npt.NDArray[np.float64]


@dataclass
class Sheet:
    """What the hooks may know of a configuration."""

    length_m: float
    elongation_m: float
    # EIBM of a voltage across the sheet, set-up included, at samples
    eibm_Nm: Callable[[Array], Array]


@dataclass
class Load:
    """What the load cell feels, (n,) each; 0 where it touches nothing."""

    force_N: Array  # along the arc's tangent
    outward_N: Array
    lean_rad: Array  # gamma
    position_m: Array  # stated; NaN where it touches nothing
    samples: Samples


@dataclass
class Image:
    """Curves, (images, points) each."""

    s_m: Array
    x_m: Array
    y_m: Array
    phi_rad: Array


@dataclass
class Taken:
    """One configuration's samples and what was true at them."""

    at: Samples
    load: Load
    held: npt.NDArray[np.bool_]  # reachable
    image: Image  # of the frames, in their order


@dataclass(frozen=True, kw_only=True)
class Acting:
    """A kind and where it acts; every function has the size last.

    `cases`, `setting` and `law` change what the generator's own solver is given.
    """

    kind: HiddenKind
    cases: Callable[[Any, Samples, Sheet, float], None] | None = None
    setting: Callable[[float], Mapping[str, Any]] | None = None
    law: Callable[[float], Any] | None = None
    slides: Callable[[Array, Samples, float], Array] | None = None  # s_hat -> friction
    force: Callable[[Load, float], Array] | None = None
    image: Callable[[Image, float], tuple[Array, Array]] | None = None
    delay_s: Callable[[float], float] | None = None
    parameters: Callable[[float], Mapping[str, float]] | None = None


def acting(
    words: str, known_as: str | None, locations: tuple[str, ...], sizes: tuple[float, float],
    unit: str, needs: tuple[str, ...] = (), **hooks: Any,
) -> Acting:  # fmt: skip
    """Make a kind; `sizes` are the typical and the largest."""
    kind = HiddenKind(
        words=words, known_as=known_as, locations=locations, typical=sizes[0], largest=sizes[1],
        unit=unit, needs=needs, own_form="parameters" in hooks,
    )  # fmt: skip
    return Acting(kind=kind, **hooks)
