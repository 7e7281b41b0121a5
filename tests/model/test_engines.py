"""The compiled engine, its stand-in, and what is left when numba is missing."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from model import ModelError
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field

R = 0.04


def batch(count: int):
    random = np.random.default_rng(0)
    kappa = [Field.constant(k, 0.05) for k in random.uniform(0.0, 40.0, count)]
    return problems(kappa, random.uniform(0.0, 0.7, count), R)


def test_threads_share_a_batch_and_change_nothing():
    many = batch(900)
    one, two = solve(many), solve(many, workers=2)
    np.testing.assert_array_equal(one.nu, two.nu)
    np.testing.assert_array_equal(one.s_hat_m, two.s_hat_m)


def test_without_numba_the_numpy_engine_is_used(monkeypatch):
    few = batch(3)
    compiled = solve(few)
    monkeypatch.setitem(sys.modules, "model.mechanics.kernel", None)
    import model

    monkeypatch.delattr(model.mechanics, "kernel", raising=False)
    plain = solve(few)
    np.testing.assert_allclose(plain.nu, compiled.nu, atol=1e-9 / R**2)
    with pytest.raises(ModelError, match="numba"):
        solve(few, engine="compiled")


def test_unreachable_places_are_told_apart_by_both_engines():
    far = problems(Field.constant(20.0, 0.05), [0.3, 1.4], R)
    for engine in ("compiled", "numpy"):
        found = solve(far, engine=engine)
        assert found.status.tolist() == [0, 1]
        assert np.isnan(found.nu[1])


@pytest.mark.parametrize("engine", ["compiled", "numpy"])
def test_problems_with_radii_of_their_own_are_what_they_are_alone(engine):
    """Contacts beside their points on the arc are."""
    many, radii = batch(4), R * np.array([1.0, 1.01, 0.98, 1.03])
    found = solve(replace(many, radii_m=radii, radius_m=float(np.min(radii))), engine=engine)
    for k, radius in enumerate(radii):
        rows = np.array([k])
        alone = replace(many, kappa=many.kappa[rows], angle_rad=many.angle_rad[rows])
        one = solve(replace(alone, radius_m=float(radius)), engine=engine)
        assert found.nu[k] * R * R == pytest.approx(one.nu[0] * R * R, abs=1e-9)
        assert abs(found.nu[k] - solve(many).nu[k]) * R * R > 1e-3 or radius == R
        for of_one, of_many in ((found.of(rows), one), (found.of(rows[[0, 0]]), one)):
            shapes = [each.shapes(np.array([0.01, 0.05]), engine) for each in (of_one, of_many)]
            np.testing.assert_allclose(shapes[0].x_m[-1], shapes[1].x_m[0], atol=1e-12)
            np.testing.assert_allclose(shapes[0].y_m[-1], shapes[1].y_m[0], atol=1e-12)


def test_importing_the_model_compiles_nothing_and_imports_nothing_slow():
    code = (
        "import sys, model; slow = {'numba', 'scipy.optimize', 'matplotlib'} & set(sys.modules);"
        "sys.exit(f'imported: {slow}' if slow else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
