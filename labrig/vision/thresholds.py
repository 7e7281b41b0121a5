"""The numbers that decide whether a curve is accepted, refused or warned of.

Each line: the quantity with its unit, and what it means. A section says where its numbers come from
and which benchmark moves with them: `accuracy`, `failures` and `faces` are those of
`python -m benchmarks.vision_extraction`, on the scenes of `benchmarks/vision_scenes.py`; after a
change `python -m benchmarks vision_peers` must still put labrig first. A share is a part of a
whole, 0 to 1; a ratio compares two quantities. Settings of the numerics stand beside their code.
"""

from __future__ import annotations

from typing import Final

# Image: whether one can hold a curve at all. Chosen, not tuned; no benchmark moves.
IMAGE_SIDE_MIN_PX: Final = 16  # rows and columns of the smallest image
SATURATED_SHARE_MAX: Final = 0.9  # of all pixels at full scale; above: why no sheet is found
SATURATED_SHARE_WARNED: Final = 0.005  # of all pixels at full scale, where the sheet is bright
# darkest to brightest over full scale; below, and within noise: uniform
LEVEL_RANGE_MIN_RATIO: Final = 0.01
UNIT_RANGE_MARGIN: Final = 0.05  # floats this far outside of 0 to 1 are still taken as such
LEVEL_RANGE_MAX_SIGMAS: Final = 12.0  # darkest to brightest of a million pixels of pure noise

# Search. By trial on drawn scenes: sheets that only a broad search finds have 0.6 and more;
# benchmark: `failures`, mixed, in clutter and without a sheet.
BROAD_SCORE_MIN: Final = 0.4  # mean ridge score of a broad search's path, to be worth a fit

# Downscaling of thick strips. The fit's cell sizes were chosen for sheets 2 to 4 pixels thick;
# no benchmark: tests/labrig/vision/test_thick_strips.py, photographs (docs/explanation/vision.md).
FULL_RESOLUTION_THICKNESS_MAX_PX: Final = 8.0  # thicker strips are downscaled
DOWNSCALED_THICKNESS_PX: Final = 3.5  # of a strip in the downscaled image
# a guessed thickness as near as this to the visible one is kept
THICKNESS_CHANGE_MIN_PX: Final = 1.0

# Acceptance of a fitted curve. Shares and lengths found by trial on drawn scenes with clutter, so
# that no wrong curve passed; the chi squares are 4 and 4.5 standard deviations. Benchmark:
# `failures` of all kinds (silent against refused).
IN_VIEW_SHARE_MIN: Final = 0.3  # of the curve that nothing known hides
COVERED_SHARE_MIN: Final = 0.6  # of what is in view that looks like the sheet
COVERED_SHARE_WARNED: Final = 0.85  # of the whole length; below: a warning
COVERED_SHARE_GOOD: Final = 0.95  # below: lost parts are searched again, further from the curve
START_COVERED_SHARE_MIN: Final = 0.4  # of the first eighth
HIDDEN_SIGMA_MAX_PX: Final = 2.0  # of the curve where it is hidden or unclear
FULLY_SEEN_SHARE: Final = 0.9  # of the cells used; above, the whole curve is known well
SNR_MIN: Final = 2.0  # contrast over one pixel's noise
RESIDUAL_MAX_PX: Final = 0.35  # RMS, thin sheet; in proportion for one of more than 3 pixels
# of the clamp against the start as the sheet alone has it, 2 degrees of freedom
START_CHI2_MAX: Final = 4.0**2
CLAMP_KINK_SIGMA_RAD: Final = 0.04  # that a sheet may have where it leaves the jaws
CURVATURE_MAX_PER_M: Final = 400.0  # of a usual strip of 40 to 60 mm, searched for
CURVATURE_REFUSED_RATIO: Final = 1.5  # of a fitted curvature to the largest one searched for
ELONGATION_TURN_MAX_RAD: Final = 0.8  # along one that is not straight, and at its joint
TURN_MAX_RAD: Final = 4.8  # from clamp to end: 240 degrees and a little

# The sheet's end against the stated length. By trial on drawn scenes, of which some hide the end;
# benchmark: `failures`, mixed and in clutter.
LENGTH_ERROR_MAX_PX: Final = 6.0  # or the share below, whichever is more
LENGTH_ERROR_MAX_RATIO: Final = 0.03  # of the stated length
UNSEEN_END_MAX_PX: Final = 5.0  # that a sheet without a visible end may continue
END_OFFSET_WARNED_PX: Final = 4.0  # from where length and scale put the end
# another thing ends that near to the sheet's end once in fifty times
END_IN_PLACE_MAX_PX: Final = 1.5
END_IN_PLACE_CHI2: Final = 8.0  # twice the logarithm of those fifty, which a doubtful gap gains
START_MISSING_MIN_SIGMAS: Final = 6.0  # plain background at the clamp over clamp_sigma_px
# of the stated length: how far beyond its end the sheet is followed
CONTINUATION_RANGE_RATIO: Final = 0.25
# from the sheet's contrast, and from the background's none
CONTRAST_DEVIATION_MAX_RATIO: Final = 0.4
BACKGROUND_RUN_PX: Final = 8  # so much plain background in a row is the sheet's end
CONTINUATION_SEEN_SHARE_MIN: Final = 0.7  # of what is seen up to the farthest sheet

# Gap continuity and occlusion: whether what is seen beyond a hidden stretch is the same sheet.
# Contrasts found by trial on sheets turned behind a disc (docs/explanation/vision.md);
# benchmark: `failures`, mixed and in clutter.
GAP_CHI2_MAX: Final = 4.5**2  # of place, direction and curvature beyond a gap, 3 degrees of freedom
GAP_CHI2_WARNED: Final = 3.0**2  # above: other paths are tried, and the credible band holds both
GAP_LENGTH_MIN_PX: Final = 8.0  # in a shorter gap no other line can take over
GAP_CELLS_BEFORE_MIN: Final = 20  # that are needed to predict the sheet beyond the gap
HOLE_CONTRAST_MAX_RATIO: Final = 0.35  # of the sheet's contrast; where less is seen there is a hole
HOLE_MIN_SIGMAS: Final = 4.5  # by which a hole's contrast is below the sheet's
OCCLUSION_GAP_MIN_CELLS: Final = 3  # unused cells between two stretches
GROUND_CHANGE_MIN_RATIO: Final = 0.5  # of background greys over the sheet's contrast
SEE_THROUGH_MIN_RATIO: Final = 0.3  # of the stretch's change over the background's
SHADE_DIFFERENCE_MIN_RATIO: Final = 0.25  # from what a shadow on both would change

# Neighbouring structure: edges, shadows and second sheets. By trial; benchmark: `failures` without
# a sheet, with and without clutter.
OPPOSITE_CONTRAST_MAX_RATIO: Final = 1.3  # of something of the opposite brightness beside the curve
EDGE_STEP_MAX_RATIO: Final = 0.8  # of the contrast, from one side of the curve to the other
SECOND_SHEET_SCORE_MIN: Final = 0.4  # of a path beside the first one, -0.3 to 1
# of the sheet's contrast; stronger: may be another sheet
REFLECTION_CONTRAST_MAX_RATIO: Final = 0.5

# Apparent width. In pixels of a sheet about 2 thick; gains are twice a log-likelihood. Benchmark:
# `faces`.
WIDTH_TOLERANCE_PX: Final = 1.0  # noise and blur make a measured width uncertain by about this
BLUR_SUSPICIOUS_PX: Final = 1.5  # above: a wider and sharper sheet is tried
EXCESS_WIDTH_GAIN_MIN: Final = 50.0  # that it must explain
# or the thickness: wider in one place only is something else
EXCESS_WIDTH_LOCAL_MAX_PX: Final = 2.0
EXCESS_WIDTH_CORRUPTED_PX: Final = 1.0  # cells wider than this are left out of a bridged curve
# above, or above the ratio below: refused, for half of it is unknown
EXCESS_WIDTH_MAX_PX: Final = 6.0
EXCESS_WIDTH_MAX_RATIO: Final = 0.0135  # of the length, where there are many pixels
# half of it widens the credible band
EXCESS_WIDTH_WARNED_PX: Final = 0.5
UNHIDDEN_SHARE_MIN: Final = 0.97  # of the pixels beside the curve: nothing is hidden there
BRIDGED_SIGMA_MAX_PX: Final = 1.2  # of a curve where what lies along the sheet was left out

# Side face. Gains are twice a log-likelihood: chance exceeds 15 with two free numbers once in 1800
# times; the rest by trial on scenes with a face. Benchmark: `faces`.
SIDE_FACE_GUESS_GAIN_MIN: Final = 8.0  # of a rough guess, to be refined
SIDE_FACE_GAIN_MIN: Final = 15.0  # of the likeliest face, to be accepted
LOCAL_STRUCTURE_GAIN_MIN: Final = 60.0  # of what lies beside the sheet in one place, such as a wire
# of the pieces, those that gain least, must gain something together
SIDE_FACE_COMMON_PIECES_SHARE: Final = 0.75
SIDE_FACE_COMMON_GAIN_RATIO: Final = 0.02  # of the whole gain, at least, by those
SIDE_FACE_BIAS_MIN_PX: Final = 0.02  # a smaller possible bias is left out
CAMERA_TILT_CHI2_MAX: Final = 4.0**2  # no camera looks that much askew at the plane
# of the face's grey to the edge's, where the edge is stated to be lit
LIT_EDGE_FACE_MAX_RATIO: Final = 0.75
# below, an elongation's face is judged by the unused free part too
FREE_PART_USED_SHARE_MIN: Final = 0.3
THICKNESS_EXCESS_MAX_RATIO: Final = 0.15  # by which a sheet may be thicker than stated
FOCUS_BLUR_MAX_PX: Final = 1.2  # a larger blur may be a disc's, and look thicker by what is above

# Lateral bias, offsets and their warnings. 16 is four standard deviations of one number; the
# warned sizes are above the sigma of a curve at SNR 5. Benchmark: `accuracy` (credible band).
BIAS_RESIDUAL_MIN_RATIO: Final = 0.95  # of residuals to noise, of which Tukey's weights leave 0.9
BIAS_GAIN_MIN: Final = 16.0  # twice the log-likelihood that a second image explains
BIAS_USED_SHARE_MIN: Final = 0.5  # of a piece's cells
BIAS_WARNED_PX: Final = 0.05
OFFSET_CHI2_MAX: Final = 3.0  # of a piece against the curve, in the mean of its cells
OFFSET_SLOPE_MAX: Final = 0.3  # pixels a cell: a sheet is no steeper beside the curve
OFFSET_CELLS_MIN: Final = 15  # unclear cells of a piece that look like the sheet
OFFSET_PRESENT_SHARE_MIN: Final = 0.9  # of the pixels beside the curve, in unclear cells
# height and width over the usual ones, of what may be the sheet
SHEET_LIKE_RATIOS: Final = (0.5, 2.2)
OFFSET_WARNED_PX: Final = 0.3

# Which cells the fit uses. By trial; benchmark: `accuracy` (RMSE, credible band) and `failures`.
PRESENT_SHARE_MIN: Final = 0.6  # of the pixels beside a cell that nothing hides
NEIGHBOURS_USED_SHARE_MIN: Final = 0.55  # of 12 cells to each side, beside what hides the sheet
CELL_CONTRAST_RATIOS: Final = (0.35, 2.5)  # of a used cell's contrast to the usual one
CELL_CONTRAST_MIN_SIGMAS: Final = 1.5  # of a used cell, over one pixel's noise

# Edges of thick strips. By trial on drawn strips and photographs (docs/explanation/vision.md);
# no benchmark: tests/labrig/vision/test_thick_strips.py.
EDGE_DISTANCE_RATIOS: Final = (0.6, 1.6)  # between both edges over the stated thickness
# of the cells of a block, which is as long as the strip is thick
EDGE_BLOCK_USED_SHARE_MIN: Final = 0.5
EDGE_BLOCKS_SHARE_MIN: Final = 0.5  # of the blocks, that show both edges

# Background lines (wires): what counts as one, and as part of the curve. By trial on wires along
# and across the sheet; benchmark: `failures`, mixed and in clutter.
RIDGE_BEND_MIN_SIGMAS: Final = 3.0  # of a ridge where it crosses the ring, over the map's noise
LINE_SCORE_MIN: Final = 0.2  # mean ridge score of the first 60 pixels, and of any place used
LINE_BEGIN_SCORE_MIN: Final = 0.1  # of its first 10 pixels: a sheet ends further from the border
LINE_SEEN_SCORE_MIN: Final = 0.3  # of a piece of ten steps
LINE_TWO_SIDED_SHARE_MIN: Final = 0.4  # of its length with two flanks; less: an edge
LINE_GAP_MAX_PX: Final = 300.0  # that rolls, clamp and sheet may make in what reaches the border
BRANCH_GAP_MAX_PX: Final = 60.0  # and in what does not, which may end there
LINE_LENGTH_MIN_PX: Final = 60.0  # seen beside the curve
LINE_MATCH_MAX_PX: Final = 4.0  # from a place to the line through it
LINE_END_SIGMA_PX: Final = 16.0  # how well a line's end is found
# from a curve's direction at its end, which is found less well
LINE_DIRECTION_MAX_RAD: Final = 0.35
CROSSING_LENGTH_MAX_REACHES: Final = 8.0  # of a crossing under an angle of 25 degrees and more
LINE_COVER_WARNED_SHARE: Final = 0.02  # of the sheet hidden by lines

# Rolls and the contact. By trial on drawn and simulated rolls; no benchmark:
# tests/labrig/vision/test_contact.py.
ROLL_EDGE_MIN_SIGMAS: Final = 2.5  # of three quarters of the rim, over the smoothed image's noise
ROLL_EDGE_MIN_RATIO: Final = 0.06  # the same over the sheet's contrast
ROLL_RESIDUAL_MAX_PX: Final = 0.8  # RMS of the rim's points from their circle
ROLL_RADIUS_MAX_RATIO: Final = 1.25  # of the larger roll to the smaller
# from the rolls in the optics to where the curve meets the arc
NAMED_ROLLS_DISTANCE_MAX_M: Final = 5e-3

# Mean image against single frames. A pixel of movement blurs a mean image; four standard
# deviations of the frames' mean.
# No benchmark: tests/labrig/vision/test_frame_average.py.
# RMS scatter of the frames' curves that blurs their mean image
FRAME_SCATTER_WARNED_PX: Final = 1.0
FRAME_DISTANCE_WARNED_PX: Final = 0.15  # RMS between both that each leaves over
FRAME_DISTANCE_WARNED_SIGMAS: Final = 4.0  # and of the frames' noise

# Calibration. Chosen with drawn boards; no benchmark:
# tests/labrig/vision/test_calibration.py.
CALIBRATION_RESIDUAL_MAX_PX: Final = 1.0  # RMS; above: refused
CALIBRATION_RESIDUAL_WARNED_PX: Final = 0.3  # RMS
CLAMP_DIRECTION_MIN_PX: Final = 20.0  # between the two places that give the sheet's direction
DIRECTION_MIN_PX: Final = 2.0  # the same of a strip in a photograph, which may be short
SCALE_MAX_PX_PER_MM: Final = 1e4  # above, a length was given in another unit
RULER_SHORT_MM: Final = 0.1  # below, it may be one in metres
BOARD_CORNERS_MIN: Final = 12  # of one image of the board

# Outline: the curve between two edges, of strips that are thick, short, shaded or of which little
# is stated. By trial on the photographs that benchmarks/photographs/traces.json names for tuning;
# benchmark: `python -m benchmarks.vision_photographs`.
OUTLINE_THICKNESS_MIN_PX: Final = 8.0  # a stated thickness above: edges are looked for first
OUTLINE_WIDTH_RATIOS: Final = (0.6, 1.5)  # of a block's width to the strip's
OUTLINE_STRENGTH_MIN_RATIO: Final = 0.3  # of a block's weaker edge to the usual one
OUTLINE_STRENGTH_MIN_SIGMAS: Final = 3.0  # of a block's weaker edge over noise and texture
# of a local change of width that may be in the middle: of a strip that is thinner with nothing
# beside it, and of any other
OUTLINE_TAPER_SHARES: Final = (0.1, 0.3)
OUTLINE_END_SIGMA_RATIO: Final = 0.3  # of sigma at both ends to the thickness; it fades within one
OUTLINE_END_SIGMA_MAX_PX: Final = 3.0  # and at most
# of another edge's strength to the strip's own: below, it is none; above, it is as likely
RIVAL_EDGE_RATIOS: Final = (0.45, 0.85)
OUTLINE_SIGMA_MIN_RATIO: Final = 0.03  # of the thickness: which part of an edge is the edge
OUTLINE_SIGMA_MIN_PX: Final = 0.1
# of the thickness, where the profile shows the strip and not both edges: it may be of one edge
OUTLINE_PROFILE_SIGMA_RATIO: Final = 0.1
OUTLINE_PROFILE_SIGMA_MIN_PX: Final = 1.0  # and at least, or the share below of a thin one
OUTLINE_PROFILE_SIGMA_THIN_RATIO: Final = 0.25
OUTLINE_SEEN_SHARE_MIN: Final = 0.6  # of the blocks
# of the seen blocks: of one edge alone it is not known which it is
OUTLINE_BOTH_SHARE_MIN: Final = 0.75
# of the length up to where the profile ends to that of the path that was searched
END_EARLY_RATIO: Final = 0.4
# of a stated length: how far from it a strip of unstated thickness may seem to end; a thick one
# may be seen to go on. On photographs of training, paths that leave the strip seem to end 12 % and
# more before it; on drawn scenes, thin ones that follow a wire 11 % and more after it.
STATED_LENGTH_MAX_RATIO: Final = 0.1
# beside a curve that seems to go on beyond its stated length: another one leads elsewhere
ELSEWHERE_MIN_PX: Final = 6.0
# from the stated direction at the clamp to that of the curve, in standard deviations of it
START_TURN_SIGMAS: Final = 3.5
START_TURN_MIN_RAD: Final = 0.1  # and of a smaller one, this
OUTLINE_START_SHARE_MIN: Final = 0.4  # of the blocks of the first eighth
# of all changes of the width, in sum, to it: a strip becomes thinner once or twice; a frayed one
# so much more for each width of its length
OUTLINE_TAPER_SUM_MAX_RATIOS: Final = (2.2, 0.027)
OUTLINE_WIDTH_SCATTER_MAX_RATIO: Final = 0.15  # of the width from block to block, to the width
OUTLINE_RESIDUAL_MAX_RATIO: Final = 0.15  # of the middles about the curve, to the width
OUTLINE_SIGMA_MAX_RATIO: Final = 0.25  # of sigma to the thickness, where that is more than 2 px
OUTLINE_SIGMA_MAX_PX: Final = 5.0  # and at most
# Where places are stated and edges do not show a strip so thin, the path through them is its curve,
# known to so much: of 49 such paths on photographs of training, 45 lie within 3.3 px of readings,
# the others within 4, 8, 10 and 15 px; those of other channels part from the last two.
PATH_THICKNESS_MAX_PX: Final = 8.0
PATH_SIGMA_MIN_PX: Final = 1.5
PATH_SIGMA_RATIO: Final = 0.3  # of the thickness
# What is tried on one image by its edges, however much in it looks like a strip. The most
# rounds that a photograph took are 133.
OUTLINE_ROUGH_MAX: Final = 40  # of few states in one channel: widths, polarities, places to begin
OUTLINE_BROAD_MAX: Final = 8  # of many states, of the likeliest of all channels
OUTLINE_ROUNDS_MAX: Final = 150  # of all fits together, each over the whole of a curve
STATED_PLACE_MAX_PX: Final = 6.0  # from a stated place to the curve, or half a thickness
END_PRESENT_RATIO: Final = 0.5  # of the weaker edge to the usual one: nearer than that is the end

# The strip's end: where the profile along its course ceases to be the strip's. By trial on the
# photographs of benchmarks/photographs/traces.json; benchmark: the same.
LED_ON_MIN_WIDTHS: Final = 1.5  # beyond a curve's end, that it is worth to be led on
LED_ON_SAID_MIN: Final = 12.0  # log odds of a way on beyond a curve's end, in all
LED_ON_OTHER_RATIO: Final = 1.5  # of them to those of any other way, or of the opposite profile
END_GAP_WIDTHS: Final = 3.0  # a gap longer than this
END_GAP_SHARE: Final = 0.12  # and than this share of the way: what lies beyond is another thing
COURSE_ALIKE_MIN: Final = 0.5  # of the correlation of a profile with those shortly before
COURSE_WIDE_RATIO: Final = 0.6  # of edges further apart to the strip's: may be another thing
COURSE_EDGE_RATIO: Final = 0.3  # of the weaker edge to what it was: less is none
COURSE_PROFILE_SIGMA_MIN: Final = 0.12  # of a profile's size, against the strip's
COURSE_STRIP_SPREAD: Final = 0.35  # of a profile's size, in that of the strip shortly before
# Of a tip that becomes thinner or fades: its middle's contrast to the strip's; over the ground's
# scatter; more is another thing; and the ground's change beside it, of the strip's contrast.
TIP_CONTRAST_MIN_RATIO: Final = 0.15
TIP_CONTRAST_MIN_SIGMAS: Final = 4.0
TIP_OTHER_MIN_RATIO: Final = 1.6
TIP_GROUND_MAX_RATIO: Final = 0.35
# Of a tip's middle, measured by its brightness: the strip's contrast over the ground's scatter, and
# the share of the last thickness that shows two sides.
TIP_CONTRAST_MIN_SCATTERS: Final = 3.0
TIP_MIDDLE_SEEN_SHARE_MIN: Final = 0.6
COURSE_SEEN_MIN: Final = 1.0  # log odds of a block whose edges are too faint, to be used
# Of the strip's profile, shown on a way beyond a measured end: more is a strip that may go on. The
# middle of the gap between right and wrong ends on half of the photographs, by their repositories.
STRIP_GOES_ON_MIN: Final = 0.23
STRIP_GOES_ON_GROUND_RATIO: Final = 1.8  # and at least so much of what the ground beside shows

# A curve in the picture and in the picture made smaller: further apart, one of both is wrong. Set
# before it was tried; of 64 right curves of photographs that were looked at none is further apart.
SIZES_APART_MIN_PX: Final = 2.0  # beside each other, or the share below of the length
SIZES_APART_RATIO: Final = 0.02
SIZES_ENDS_APART_MIN_PX: Final = 4.0  # from end to end, or the share below of the length
SIZES_ENDS_APART_RATIO: Final = 0.04
SIZES_THICKNESS_RATIO: Final = 1.7  # of their thicknesses; more: they are not of one strip
