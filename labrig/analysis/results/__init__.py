"""What a session has shown so far, as plain data for a page: measured, fitted, and with what doubt.

The steps of a fit cost more than reading does, so that they are separate:

    fitted = fit(measurements)                        # model.fit; leave it out before there is one
    points = converging(measurements, known=points)   # one fit for each further position
    result = result_of(measurements, fitted=fitted, convergence=points)
"""

from labrig.analysis.results.convergence import Convergence, converging, converging_steps
from labrig.analysis.results.measured import reading_curve
from labrig.analysis.results.result import result_of

__all__ = ["Convergence", "converging", "converging_steps", "reading_curve", "result_of"]
