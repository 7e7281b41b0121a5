"""What a curve's warnings say of colours: of a film, or a file of several pages, once."""

from __future__ import annotations

from dataclasses import replace

from labrig.vision.curve import NeutralCurve

GREY_USED = "the image is in colour; its grey values were used"
DIFFERENCES_USED = "the image is in colour; its grey values and differences of colours were used"
_OF_SEVERAL = {
    note: note.replace("the image is", "images of this file are").replace("its", "their")
    for note in (GREY_USED, DIFFERENCES_USED)
}


class ColourNotes:
    """Of the images of one file: each note stands at the first curve that has it."""

    def __init__(self) -> None:
        self._told: set[str] = set()

    def once(self, curve: NeutralCurve) -> NeutralCurve:
        """Return a curve without what was told before."""
        if not curve.ok:  # whose warnings nobody is shown
            return curve
        new = [text for text in curve.warnings if text not in self._told]
        self._told.update(text for text in new if text in _OF_SEVERAL)
        if DIFFERENCES_USED in new:  # which names the grey values, too
            self._told.add(GREY_USED)
        return replace(curve, warnings=tuple(_OF_SEVERAL.get(text, text) for text in new))
