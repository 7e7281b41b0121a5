"""What no catalogue has, and the locations in which an answer may put it."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._collocation_bvp import A
from benchmarks.worlds.generators._collocation_named import MILLI, Spoil
from benchmarks.worlds.generators._collocation_plant import Plant, lagged


def ripple(plant: Plant, c: float) -> None:
    """Bend the strip as a wave."""
    for strip in plant.strips.values():
        free = strip.free_m
        strip.k0.append(lambda s, free=free: c * np.sin(3.0 * np.pi * s / free))


def two_halves(plant: Plant, c: float) -> None:
    """Let the inner half be straighter and the outer one more curved."""
    for strip in plant.strips.values():
        free = strip.free_m
        strip.k0.append(lambda s, free=free: c * np.tanh((s / free - 0.5) / 0.08))


def middle_works(plant: Plant, c: float) -> None:
    """Let the middle give more EIBM than both ends."""
    for strip in plant.strips.values():
        free = strip.free_m
        strip.eibm.append(lambda s, _a, free=free: 1.0 - c * np.cos(2.0 * np.pi * s / free))


def one_way_patch(plant: Plant, c: float) -> None:
    """Take EIBM from the outer part at negative voltages alone."""
    for strip in plant.strips.values():
        free = strip.free_m

        def left(s: A, alpha: A, free: float = free) -> A:
            outer = 0.5 * (1.0 + np.tanh((s / free - 0.6) / 0.07))
            return np.where(alpha < 0.0, 1.0 - c * outer, 1.0)

        strip.eibm.append(left)


def lead_wire(plant: Plant, c: float) -> None:
    """Turn the strip at its middle by a couple."""
    for strip in plant.strips.values():
        free = strip.free_m
        strip.couple.append(
            lambda s, free=free: c * 1e-6 * 0.5 * (1.0 - np.tanh((s / free - 0.5) / 0.06))
        )


def earthed_plate(plant: Plant, c: float) -> None:
    """Draw the strip to one side under either voltage."""
    for strip in plant.strips.values():
        free = strip.free_m
        strip.drawn.append(lambda s, free=free: c * MILLI * np.maximum(free - s, 0.0))


def stiffer_when_positive(plant: Plant, c: float) -> None:
    """Stiffen the strip at positive and soften it at negative voltages."""
    plant.stiffness.append(lambda _stay, alpha: 1.0 + c * np.tanh(2.0 * alpha))


def marker(plant: Plant, c: float) -> None:
    """Glue something stiff on the strip."""
    for strip in plant.strips.values():
        free = strip.free_m

        def left(s: A, free: float = free) -> A:
            at = s / free
            return 1.0 - c * 0.5 * (np.tanh((at - 0.5) / 0.05) - np.tanh((at - 0.68) / 0.05))

        strip.compliance.append(left)


def wet_rolls(plant: Plant, c: float) -> None:
    """Let the stiffness depend on where the load cell stands."""
    plant.stiffness.append(
        lambda stay, alpha: np.full_like(alpha, 1.0 + c * ((stay.stated_m or 0.0) / 0.015 - 1.0))
    )


def wide_arc(plant: Plant, c: float) -> None:
    """Lead the rolls on a wider arc."""
    for strip in plant.strips.values():
        strip.arc_grows_m = c * MILLI


def rail_joint(plant: Plant, c: float) -> None:
    """Set the outer half of the rail off by a length."""
    plant.stage.append(lambda p: p + c * MILLI * 0.5 * (1.0 + np.tanh((p - 0.0175) / 5e-4)))


def cubic_cell(plant: Plant, c: float) -> None:
    """Show more and more of larger forces."""
    plant.cell.append(lambda _stay, load: load.shown_N * (1.0 + c * (load.shown_N / 3e-3) ** 2))


def pickup(plant: Plant, c: float) -> None:
    """Add a share of the sheet's voltage to the load cell's."""
    plant.cell.append(lambda stay, load: load.shown_N + c * MILLI * stay.volts / 2.0)


def slow_filter(plant: Plant, c: float) -> None:
    """Filter the load cell's signal."""
    plant.cell.append(lambda _stay, load: lagged(load.shown_N, c))


def turned_picture(plant: Plant, c: float) -> None:
    """Turn the picture about the clamp."""
    plant.lens.append(lambda x, y: (x * np.cos(c) - y * np.sin(c), x * np.sin(c) + y * np.cos(c)))


def shifted_picture(plant: Plant, c: float) -> None:
    """Mark the clamp beside where it is."""
    plant.lens.append(lambda x, y: (x, y + c * MILLI))


def swollen_face(plant: Plant, c: float) -> None:
    """Bend the strip after each moistening, until the water has spread."""
    plant.swelling.append(lambda stay: c * np.exp(-(stay.moist_s + stay.t) / 15.0))


def weak_pairs(plant: Plant, c: float) -> None:
    """Weaken every other pair of pulses."""
    plant.response.append(
        lambda stay, a: a * (1.0 - c * (np.floor(np.maximum(stay.count, 0.0) / 2.0) % 2.0 - 0.5))
    )


def _kind(
    words: str, locations: tuple[str, ...], typical: float, largest: float, unit: str = "",
    needs: tuple[str, ...] = (),
) -> HiddenKind:  # fmt: skip
    return HiddenKind(
        words=words, known_as=None, locations=locations, typical=typical, largest=largest,
        unit=unit, needs=needs,
    )  # fmt: skip


NAMELESS: dict[str, tuple[HiddenKind, Spoil]] = {
    "ripple": (_kind(
        "The sheet is rippled: k0 + c sin(3 pi s/l).",
        ("rest_curvature",), 6.0, 40.0, "1/m"), ripple),
    "two_halves": (_kind(
        "Half of the sheet lay in a fold: k0 + c tanh((s/l - 1/2)/0.08).",
        ("rest_curvature",), 3.0, 20.0, "1/m"), two_halves),
    "middle_works": (_kind(
        "Both ends are worn: Me (1 - c cos(2 pi s/l)).",
        ("eibm",), 0.3, 1.0), middle_works),
    "one_way_patch": (_kind(
        "A blocked electrode: at negative voltages Me less by the share c beyond 0.6 l.",
        ("eibm",), 0.4, 1.0), one_way_patch),
    "lead_wire": (_kind(
        "A lead wire soldered at l/2 turns the sheet there by a couple c.",
        ("even_moment", "rest_curvature"), 4.0, 30.0, "uN m"), lead_wire),
    "earthed_plate": (_kind(
        "A plate at earth draws the free length with c (V/2 V)^2 along y.",
        ("even_moment",), 5.0, 40.0, "mN/m"), earthed_plate),
    "stiffer_when_positive": (_kind(
        "Stiffness goes with the voltage: B (1 + c tanh(V/1 V)).",
        ("compliance",), 0.07, 0.4), stiffer_when_positive),
    "marker": (_kind(
        "A marker is glued between 0.5 l and 0.68 l: 1/B less by the share c there.",
        ("compliance",), 0.6, 0.95), marker),
    "wet_rolls": (_kind(
        "The rolls moisten the sheet where they stand: B (1 + c (p/15 mm - 1)).",
        ("compliance", "position"), 0.06, 0.4), wet_rolls),
    "wide_arc": (_kind(
        "The rolls run on an arc that is wider by c, at the stated angles.",
        ("position",), 0.5, 4.0, "mm"), wide_arc),
    "rail_joint": (_kind(
        "The rail is of two parts: beyond 17.5 mm the rolls are farther by c.",
        ("position",), 0.5, 3.0, "mm"), rail_joint),
    "cubic_cell": (_kind(
        "The load cell is not linear: F (1 + c (F/3 mN)^2).",
        ("load_cell",), 0.06, 0.4), cubic_cell),
    "pickup": (_kind(
        "The sheet's wires lie beside the load cell's: F + c V/2 V.",
        ("load_cell",), 0.08, 1.0, "mN"), pickup),
    "slow_filter": (_kind(
        "The load cell's amplifier filters with a time constant c.",
        ("load_cell", "time"), 0.08, 0.5, "s", needs=("series",)), slow_filter),
    "turned_picture": (_kind(
        "The camera alone is turned by c about the clamp.",
        ("camera",), 0.015, 0.2, "rad"), turned_picture),
    "shifted_picture": (_kind(
        "The clamp was marked wrongly in the picture: y + c.",
        ("camera",), 0.2, 2.0, "mm"), shifted_picture),
    "swollen_face": (_kind(
        "Water enters by one face: k0 + c exp(-t/15 s), t since the moistening.",
        ("time", "rest_curvature"), 8.0, 60.0, "1/m"), swollen_face),
    "weak_pairs": (_kind(
        "The supply's capacitors take turns: every other pair of pulses has c less EIBM.",
        ("time", "eibm"), 0.06, 0.5), weak_pairs),
}  # fmt: skip
