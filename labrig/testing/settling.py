"""Whether an effect of the sheet comes to a solution, on a sheet such as the paper's."""

from __future__ import annotations

from collections.abc import Iterator

from labrig.api.sheet import sheet
from model import ModelError
from model.effects import Effect
from model.effects.conformance import faults, plausible
from model.sheet.applied_effects import with_acting
from model.sheet.effect_hooks import Acting

POSITIONS_M, VOLTAGES_V = (0.004, 0.014), (2.0, 0.0, -2.0)
SIZES = (1.0, 2.0)  # of the plausible one


def effect_faults(effect: object) -> list[str]:
    """Return what is wrong with an effect, and whether it settles; empty: nothing.

    The loader asks for the first alone: solving takes a second.
    """
    found = faults(effect)
    return found if found or not isinstance(effect, Effect) else [*_unsettled(effect)]


def _unsettled(effect: Effect) -> Iterator[str]:
    model = sheet(
        free_length_mm=50, width_mm=11, thickness_mm=0.21, B_Nm2=1.27e-6,
        EIBM_Nm={2.0: 36e-6, -2.0: -28e-6},
    )  # fmt: skip
    places = [(at, volts) for at in POSITIONS_M for volts in VOLTAGES_V]
    plain = model.setups("sheet", places)
    amplitude = effect.amplitude
    for times in SIZES:
        size = min(max(times * amplitude.prior_scale, amplitude.low), amplitude.high)
        values = {**plausible(effect), amplitude.name: size}
        try:
            with_acting(plain, [at for at, _ in places], [Acting(effect, values)])
        except ModelError as error:
            yield (
                f"at {amplitude.name} = {size:g} a sheet such as the paper's has no solution with "
                f"it: {error}; see 'An effect that depends on the solution' in the documentation"
            )
            return
