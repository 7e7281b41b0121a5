"""The sheet's motion in compiled code; `numpy_reference` solves the same equations in NumPy.

state       arrays of the body, its state and scratch
contact     the sheet where the rolls touch it
residual    positions, velocities, accelerations at the nodes, and the balance of moments
tangent     the matrix of Newton's method
march       generalized-alpha steps
Imported when a motion is first computed: importing numba takes the best part of a second.
"""

from model.dynamics.kernel.march import march

__all__ = ["march"]
