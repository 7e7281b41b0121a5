"""Runs that are killed at random moments, each judged by the world's own record.

`python -m benchmarks.soak --runs 200 --seed 1`; see docs/explanation/soak.md.
"""

from benchmarks.soak.faults import Fault
from benchmarks.soak.figures import Figures, figures, summary
from benchmarks.soak.judge import Verdict
from benchmarks.soak.series import soak

__all__ = ["Fault", "Figures", "Verdict", "figures", "soak", "summary"]
