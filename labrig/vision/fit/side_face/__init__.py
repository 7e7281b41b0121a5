"""Fit the side face: the stripe that a wide sheet shows beside its near edge.

A camera sees the sheet in perspective, so a stripe of its face shows on the side of the vanishing
point of the lines square to its plane. Two numbers give the width of the stripe along the whole
sheet. Taken for a part of the edge it would pull the curve to its side by up to half its width.
Lit from the front it is grey; in a silhouette it is as dark as the edge, and only its geometry
tells the two apart.
"""

from labrig.vision.fit.side_face.search import SideFaceSearch

__all__ = ["SideFaceSearch"]
