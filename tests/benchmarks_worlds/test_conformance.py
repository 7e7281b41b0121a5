"""Each generator of worlds keeps the contract, and one that does not is found out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pytest

from benchmarks.worlds import conformance
from benchmarks.worlds.contract import Design, HiddenKind, World
from benchmarks.worlds.generators.chain import WORLD as CHAIN
from benchmarks.worlds.registry import names, world
from model.measurements import Condition, Measurements

pytestmark = pytest.mark.thorough


@pytest.mark.parametrize("check", conformance.CHECKS)
@pytest.mark.parametrize("name", names())
def test_a_generator_keeps_the_contract(name: str, check: str) -> None:
    assert list(conformance.CHECKS[check](world(name))) == []


@pytest.mark.parametrize("name", names())
def test_a_generator_shares_nothing_with_the_model(name: str) -> None:
    assert conformance.imports(name) == []


class _Spoilt:
    """The world `chain`, changed afterwards."""

    name, numerics, noise, kinds = "spoilt", CHAIN.numerics, CHAIN.noise, CHAIN.kinds

    def __init__(self, force: float = 1.0, curve: float = 1.0, seeds: int = 0) -> None:
        self._force, self._curve, self._seeds = force, curve, seeds

    def parameters(self, kind: str, size: float) -> Mapping[str, float]:
        return CHAIN.parameters(kind, size)

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        found = CHAIN.measure(design, hidden, seed + self._seeds * len(hidden), exact=exact)
        return replace(found, conditions=tuple(self._changed(c) for c in found.conditions))

    def _changed(self, c):  # type: ignore[no-untyped-def]
        factor = self._force if c.voltage_V == 0.0 else 1.0
        readings = tuple(replace(r, force_N=factor * r.force_N) for r in c.readings)
        curve = replace(c.curve, x_m=self._curve * c.curve.x_m, y_m=self._curve * c.curve.y_m)
        return replace(c, readings=readings, curve=curve)


@pytest.mark.parametrize(
    ("spoilt", "check"),
    [
        (_Spoilt(force=1.01), "one_stiffness"),
        (_Spoilt(force=-1.0), "cantilever"),
        (_Spoilt(curve=1.001), "arcs"),
        (_Spoilt(curve=1.001), "placed"),
    ],
)
def test_wrong_physics_is_found(spoilt: World, check: str) -> None:
    assert list(conformance.CHECKS[check](spoilt))


class _Pushing(_Spoilt):
    """Whatever is hidden acts the other way round on the force."""

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        bare, found = (CHAIN.measure(design, one, seed, exact=exact) for one in ({}, hidden))
        pairs = zip(bare.conditions, found.conditions, strict=True)
        return replace(bare, conditions=tuple(_turned(*pair) for pair in pairs))


def _turned(bare: Condition, found: Condition) -> Condition:
    readings = tuple(
        replace(b, force_N=2.0 * b.force_N - f.force_N)
        for b, f in zip(bare.readings, found.readings, strict=True)
    )
    return replace(bare, readings=readings)


def test_friction_that_pushes_is_found() -> None:
    assert list(conformance.resisting(CHAIN)) == []
    found = list(conformance.resisting(_Pushing()))
    assert found
    assert all("friction that pushes" in fault for fault in found)


def test_a_noise_that_depends_on_what_is_hidden_is_found() -> None:
    spoilt = _Spoilt(seeds=1)
    spoilt.kinds = {"zero": CHAIN.kinds["zero"]}
    assert any("noise" in fault for fault in conformance.same_noise(spoilt))


def test_a_kind_with_an_unknown_location_is_found() -> None:
    kind: HiddenKind = replace(CHAIN.kinds["zero"], locations=("nowhere",))
    spoilt = _Spoilt()
    spoilt.kinds = {"zero": kind}
    assert any("nowhere" in fault for fault in conformance.described(spoilt))
