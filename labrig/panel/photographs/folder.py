"""All photographs of a folder: listed, measured by one thread, decided on."""

from __future__ import annotations

import datetime as dt
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Literal

from labrig.errors import BadInputError, LabrigError
from labrig.panel.errors import MissingError
from labrig.panel.live.event_stream import Message
from labrig.panel.photographs.known import (
    Clicked,
    along_px,
    changed_optics,
    clicked_facts,
    digest_of,
    known_optics,
    write_known,
)
from labrig.panel.photographs.measuring import FileState, Measured, file_state, measured_file
from labrig.panel.photographs.photograph import Photograph
from labrig.vision.facts.contract import FactOf, FactShape
from labrig.vision.facts.stated import Facts
from labrig.vision.image.beside import OPTICS_FILE, SHEET_FILE, beside, own_file
from labrig.vision.image.files import load_strip
from labrig.vision.image.names import files_in, is_video, whole_file
from labrig.vision.image.reading import Pixels, labels_in, pictures_in
from labrig.vision.image.review import PictureDecision, load_review, save_review
from labrig.vision.image.tables import refuse_other_tables, write_points, write_summary
from labrig.vision.image.unused import unused_corrections

Choice = Literal["accepted", "refused", "none"]
RESULTS = "curves"  # folder of the tables


class PhotographFolder:
    """The photographs of one folder. Methods may be called from any thread."""

    def __init__(self, folder: Path) -> None:
        """Raise BadInputError where a file of the folder is at fault."""
        self.folder = folder
        self._lock = threading.RLock()
        self._wake = threading.Condition(self._lock)
        self._photographs = {one.name: one for one in _listed(folder)}
        self._decided = load_review(folder)
        self._unused = unused_corrections(folder)
        self.videos = sum(is_video(path) for path in folder.iterdir())
        self._revision = 0
        self._queue: deque[Path] = deque(
            dict.fromkeys(one.path for one in self._photographs.values())
        )
        self._busy: Path | None = None  # what is measured now
        self._states: dict[Path, FileState] = {}  # of the files when they were measured
        self._looked_at = file_state(folder)
        self._files = {*files_in(folder, videos=False)}
        self._arriving: dict[Path, FileState] = {}  # files that came since, at the look before
        self._closed = False
        self.thread = threading.Thread(target=self._work, name="photographs", daemon=True)
        self.thread.start()

    def close(self) -> None:
        """End the measuring after the photograph that it is at."""
        with self._wake:
            self._closed = True
            self._queue.clear()
            self._wake.notify_all()

    # ------------------------------------------------------------------------------- what is shown

    def listing(self, since: int) -> Message:
        """Return what has changed since a revision, and the counts; new photographs are taken in.

        One that is still being copied is taken in once it does not change from look to look.
        """
        with self._lock:
            self._take_in_new()
            every = list(self._photographs.values())
            waiting = {*self._queue, self._busy}
            return {
                "revision": self._revision,
                "total": len(every),
                "waiting": sum(one.path in waiting for one in every),
                "videos": self.videos,
                "unused": self._unused,
                "photographs": [one.message() for one in every if one.revision >= since],
            }

    def details(self, name: str) -> Message:
        """Return a photograph with its curves and what is known of it."""
        one = self._named(name)
        size = list(self._size_of(one))
        with self._lock:
            message = one.message() | {"curves": one.curve_messages()}
        return message | {"size": size, "tools": tools()} | self._known(one)

    def _size_of(self, one: Photograph) -> tuple[int, int]:
        """Return columns and rows, also before it was measured: clicks are counted in these."""
        if one.size is not None:
            return one.size
        rows, columns = self.image(one.name).shape[:2]
        return columns, rows

    def thumbnail(self, name: str) -> bytes:
        """Return its small picture as JPEG. Raises MissingError before it was read."""
        thumbnail = self._named(name).thumbnail
        if not thumbnail:
            raise MissingError(f"{name}: was not read yet.")
        return thumbnail

    def image(self, name: str) -> Pixels:
        """Return its image. Raises BadInputError, MissingError."""
        one = self._named(name)
        for picture in pictures_in(one.path):
            if picture.label.frame == one.label.frame:
                if picture.image is None:
                    raise BadInputError(picture.why)
                return picture.image
        raise MissingError(f"{name}: is no longer there.")

    def _known(self, one: Photograph) -> Message:
        """Return what is known of a photograph, as the page shows and changes it."""
        try:
            optics = known_optics(one.path)
            places = {} if optics is None else optics.by_strip()
        except BadInputError as error:
            return {"known": None, "known_fault": str(error), "sheet": ""}
        strips = {
            name: {
                "clamp_px": of.clamp_px,
                "along_px": along_px(of),
                **_shown(of.facts, FactOf.STRIP),
            }
            for name, of in places.items()
        }
        sheet, file = (beside(one.path, kind, None) for kind in (SHEET_FILE, OPTICS_FILE))
        known = None
        if optics is not None:
            known = {
                "px_per_mm": optics.px_per_mm,
                "strips": strips,
                **_shown(optics.facts, FactOf.PICTURE),
                "method": optics.method or "",
                "file": "" if file is None else file.name,
            }
        return {"known": known, "known_fault": "", "sheet": _sheet_words(sheet)}

    # ------------------------------------------------------------------------------- what is done

    def set_known(self, name: str, clicked: Clicked, *, for_all: bool) -> Message:
        """Write what was clicked beside the photographs, and measure again what it concerns."""
        one = self._named(name)
        size = self._size_of(one)
        base = known_optics(one.path, common=for_all) or known_optics(one.path)
        optics = changed_optics(base, size, clicked)
        measured = not for_all and all(
            place.constraints.length_measured for place in clicked.strips.values()
        )
        if beside(one.path, SHEET_FILE, None) is None and not (clicked.lengths_mm or measured):
            raise BadInputError(
                "the strip's free length is missing: state it in mm, or click the tip of each."
            )
        written = write_known(one.path, optics, clicked, for_all=for_all)
        paths = {one.path}
        if for_all:
            paths |= {other.path for other in self._photographs.values()}
        self._measure_again(one.path, paths)
        return {"written": written, "measured_again": len(paths)}

    def decide(self, names: list[str], choice: Choice, who: str, note: str) -> None:
        """Accept or refuse photographs, or take that back."""
        again: set[Path] = set()
        with self._lock:
            for name in names:
                one = self._named(name)
                if choice == "accepted" and one.state != "found":
                    raise BadInputError(f"{name}: has no curve that could be accepted.")
            for name in names:
                one = self._named(name)
                was_refused = one.decision is not None and one.decision.decision == "refused"
                if was_refused and choice != "refused":
                    again.add(one.path)
                one.decision = _decision(one.path, choice, who, note)
                self._decided.pop(name, None)
                if one.decision is not None:
                    self._decided[name] = one.decision
                self._changed(one)
            save_review(self.folder, self._decided)
        if again:
            self._measure_again(next(iter(again)), again)

    def write_tables(self) -> list[str]:
        """Write curves.csv and summary.csv of all photographs; refused ones with their reason.

        Raises BadInputError where some are not measured yet, or were changed since they were.
        """
        with self._lock:
            waiting = len(self._queue) + (self._busy is not None)
            if waiting:
                raise BadInputError(f"{waiting} photographs are not measured yet; wait for them.")
            self._measure_changed()
            found = [row for one in self._photographs.values() for row in one.rows()]
        output = self.folder / RESULTS
        points, summary = output / "curves.csv", output / "summary.csv"
        refuse_other_tables(points, summary)
        output.mkdir(exist_ok=True)
        write_points(points, found)
        write_summary(summary, found)
        return [f"{RESULTS}/curves.csv", f"{RESULTS}/summary.csv"]

    def _take_in_new(self) -> None:
        changed = file_state(self.folder)
        if changed is None or (changed == self._looked_at and not self._arriving):
            return
        with suppress(BadInputError):  # curves_review.json is written by others now
            self._unused = unused_corrections(self.folder)
        before, now = self._arriving, files_in(self.folder, videos=False)
        new = [path for path in now if path not in self._files]
        self._looked_at, self._arriving = changed, {path: file_state(path) for path in new}
        for path in new:
            if before.get(path) == self._arriving[path]:
                del self._arriving[path]
                self._take_in(path)

    def _take_in(self, path: Path) -> None:
        self._files.add(path)
        for one in _labelled(path):
            if one.name not in self._photographs:
                self._photographs[one.name] = one
                self._changed(one)
        self._queue.append(path)
        self._wake.notify_all()

    def _paths(self) -> list[Path]:
        return list(dict.fromkeys(one.path for one in self._photographs.values()))

    def _named(self, name: str) -> Photograph:
        found = self._photographs.get(name)
        if found is None:
            raise MissingError(f"{name}: there is no such photograph in this folder.")
        return found

    # --------------------------------------------------------------------------------- measuring

    def _measure_again(self, first: Path, paths: set[Path]) -> None:
        """Measure these anew, the one that is looked at first."""
        with self._wake:
            rest = [path for path in self._queue if path not in paths]
            wanted = [path for path in self._paths() if path in paths and path != first]
            self._queue = deque([first, *rest, *wanted])
            for one in self._photographs.values():
                if one.path in paths:
                    one.state, one.why = "waiting", ""
                    self._changed(one)
            self._wake.notify_all()

    def _measure_changed(self) -> None:
        """Measure anew what was replaced or removed since it was measured, and raise."""
        changed = [path for path in self._paths() if self._states.get(path) != file_state(path)]
        if changed:
            self._measure_again(changed[0], set(changed))
            names = ", ".join(path.name for path in changed[:3])
            more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
            raise BadInputError(
                f"{names}{more}: changed since measured; measured again now: look, then write the "
                "tables."
            )

    def _work(self) -> None:
        while True:
            with self._wake:
                while not self._queue and not self._closed:
                    self._wake.wait()
                if self._closed:
                    return
                path = self._busy = self._queue.popleft()
                self._states[path] = file_state(path)
            measured = measured_file(path)
            with self._lock:
                self._busy = None
                if path not in self._queue:  # else it is measured again, from something else
                    self._take(path, measured)

    def _take(self, path: Path, measured: Measured) -> None:
        own = any(own_file(path, kind).exists() for kind in (OPTICS_FILE, SHEET_FILE))
        for one in self._photographs.values():
            if one.path != path:
                continue
            one.own = own
            image = measured.images.get(one.label.frame)
            if image is None:
                one.state, one.why = "unreadable", measured.why or f"{path}: cannot be read."
                one.curves = []
            elif one.label.frame in measured.curves:
                one.show(image, measured.curves[one.label.frame])
            else:
                one.size, one.curves = (image.shape[1], image.shape[0]), []
                one.state, one.why = "new", _what_is_missing(path) or measured.why
                one.draw(image)
            self._decide_again(one)
            self._changed(one)

    def _decide_again(self, one: Photograph) -> None:
        """Forget that a curve was accepted where it was made from something else."""
        decision = self._decided.get(one.name)
        if decision is not None and decision.decision == "accepted":
            same = one.state == "found" and decision.known == digest_of(one.path)
            if not same:
                del self._decided[one.name]
                decision = None
                with suppress(LabrigError):  # told when the next decision cannot be written
                    save_review(self.folder, self._decided)
        one.decision = decision

    def _changed(self, one: Photograph) -> None:
        self._revision += 1
        one.revision = self._revision


def tools() -> list[Message]:
    """Return the tools with which facts are clicked: those of a strip, then those of the pictures.

    What is clicked with each is sent and shown under its `key`.
    """
    return [
        {
            "key": fact.name,
            "of": fact.of,
            "shape": fact.shape,
            "label": fact.tool.label,
            "hint": fact.tool.hint,
        }
        for of in FactOf
        for fact in clicked_facts(of)
        if fact.tool is not None
    ]


def _shown(facts: Facts, of: FactOf) -> Facts:
    """Return the value of each fact that is clicked; an empty one where it is not known."""
    empty = {FactShape.POINT: None}
    return {
        fact.name: facts.get(fact.name, empty.get(fact.shape, ())) for fact in clicked_facts(of)
    }


def _listed(folder: Path) -> Iterator[Photograph]:
    """Yield the photographs of a folder."""
    for path in files_in(folder, videos=False):
        yield from _labelled(path)


def _labelled(path: Path) -> Iterator[Photograph]:
    try:
        labels = labels_in(path)
    except BadInputError:
        labels = [whole_file(path)]
    for label in labels:
        yield Photograph(label=label, path=path)


def _what_is_missing(path: Path) -> str:
    """Return what is to be clicked or typed before a photograph can be measured."""
    if beside(path, OPTICS_FILE, None) is None:
        return (
            "Click the clamp, a place further along the clamped strip, and both ends of a ruler; "
            "state the ruler's length and the strip's; then measure."
        )
    if beside(path, SHEET_FILE, None) is None:
        return "State the strip's free length; then measure."
    return ""


def _sheet_words(sheet: Path | None) -> str:
    """Return the strip's lengths as a text; empty: none is stated."""
    if sheet is None:
        return ""
    try:
        strip = load_strip(sheet)
    except BadInputError as error:
        return str(error)
    thick = f", {1e3 * strip.thickness_m:g} mm thick" if strip.thickness_known else ""
    more = f" and {1e3 * strip.elongation_m:g} mm elongation" if strip.elongation_m else ""
    return f"{sheet.name}: {1e3 * strip.free_length_m:g} mm{more}{thick}"


def _decision(path: Path, choice: Choice, who: str, note: str) -> PictureDecision | None:
    if choice == "none":
        return None
    date = dt.datetime.now(dt.UTC).isoformat(timespec="seconds")
    known = digest_of(path) if choice == "accepted" else ""
    return PictureDecision(decision=choice, who=who, date=date, note=note, known=known)
