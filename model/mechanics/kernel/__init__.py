"""Solve the equilibrium in compiled code.

`model/mechanics/equilibrium.py` states the problem, `model/mechanics/numpy_reference.py` solves it
in NumPy.

Gauss-Legendre collocation in the contact frame: psi = phi - phi_hat, integrated backward from the
contact, panel by panel, with a = (p_hat - r).t_hat and nu = N/B:
    psi' = -(k* - nu c a),   k* = k0 + Me/B(s),   c = B/B(s),   a' = cos psi.
The unknowns are psi at all nodes, nu and s_hat. The nodes of a panel are eliminated by a dense
solve; what goes on to the next panel is how psi, a and b = (p_hat - r).n_hat answer to the columns
(nu, s_hat, and then the Newton residual or each parameter asked for), so that the closure
r(s_hat) = p_hat remains: two equations with two unknowns.
A panel runs backward from `top` to `bottom` = top - h, theta = 0 .. 1, nodes s_j = top - h c_j.

    panel       one panel: everything at its nodes, its matrix, what goes on
    newton      panel after panel, and Newton's steps
    start       where Newton begins
    branch      the branch followed step by step, where Newton alone fails
    lanes       Newton's steps for many problems at once
    batch       a batch: in lanes, then one by one
    shape       curves at any s
    answers     derivatives
Imported when an equilibrium is first asked for: importing numba takes the best part of a second.
"""

from model.mechanics.kernel.answers import describe_many
from model.mechanics.kernel.batch import solve_many
from model.mechanics.kernel.branch import rescue_many

__all__ = ["describe_many", "rescue_many", "solve_many"]
