import numpy as np
import pytest

from labrig.vision.curve.shape import coefficients_for, make_basis, make_shape

START = np.zeros(2)


def shape_of(basis, curvature, offset=0.0, angle=0.0):
    c = np.full(basis.size - 2, curvature)
    return make_shape(basis, START, 0.1, np.concatenate([[offset, angle], c]))


def test_constant_curvature_is_a_circular_arc():
    basis = make_basis(445.0, 445.0, 21)
    k = 4.2 / 445  # 240 degrees
    arc = shape_of(basis, k)
    s = basis.s
    assert arc.x == pytest.approx((np.sin(0.1 + k * s) - np.sin(0.1)) / k, abs=1e-6)
    assert arc.y == pytest.approx((np.cos(0.1) - np.cos(0.1 + k * s)) / k, abs=1e-6)


def test_the_elongation_is_straight():
    basis = make_basis(40.0, 400.0, coefficients_for(40.0))
    shape = shape_of(basis, 0.01)
    beyond = basis.s > 41
    assert np.ptp(shape.phi[beyond]) == pytest.approx(0, abs=1e-12)
    assert shape.phi[-1] == pytest.approx(0.1 + 0.4)
    assert not shape.k[beyond].any()


def test_normal_modes_are_the_derivatives_of_the_curve():
    basis = make_basis(300.0, 420.0, 12)
    p = np.concatenate([[0.5, 0.02], 0.005 + 0.003 * np.sin(np.arange(12))])
    shape = make_shape(basis, START, 0.1, p)
    modes = shape.normal_modes()
    for i in range(len(p)):
        step = np.zeros(len(p))
        step[i] = 1e-6
        a, b = shape.moved(p + step), shape.moved(p - step)
        normal = -np.sin(shape.phi) * (a.x - b.x) + np.cos(shape.phi) * (a.y - b.y)
        size = np.abs(modes[:, i]).max()
        assert normal / 2e-6 == pytest.approx(modes[:, i], abs=2e-4 * size + 1e-6)


def test_the_penalty_is_the_integral_of_the_slope_squared():
    basis = make_basis(400.0, 400.0, 15)
    c = np.random.default_rng(1).normal(size=15)
    s = np.linspace(0, 400, 40001)
    k = np.interp(s, basis.s, basis.curvature @ c)
    slope = np.gradient(k, s)
    assert c @ basis.penalty @ c == pytest.approx((slope**2).sum() * (s[1] - s[0]), rel=0.01)


def test_sliding_keeps_the_line_in_the_plane():
    basis = make_basis(445.0, 445.0, 21)
    shape = shape_of(basis, 0.006)
    slid = shape.slid(2.0)
    radius = 1 / 0.006
    # the centre moves only by what a straight start of 2 pixels differs from an arc
    centre = np.array([-np.sin(0.1), np.cos(0.1)]) * radius
    assert np.hypot(slid.x - centre[0], slid.y - centre[1]) == pytest.approx(radius, abs=0.05)
