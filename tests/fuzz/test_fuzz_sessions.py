"""Session files from anywhere: damaged, made to mislead, or far too large to be true."""

from __future__ import annotations

import json
import random
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from labrig.session import Note, add_note, store_measurements
from labrig.session.format import layout
from labrig.session.recording.hdf5 import put_text
from labrig.session.recording.journal import journal_path
from tests.cases import few
from tests.fuzz.mangle import DEEP, NUMBERS, bytes_of
from tests.fuzz.told import told
from tests.labrig.session.measured import measurements
from tests.labrig.session.session_recording import TEXTS, record, small_schedule
from tests.labrig.test_about import FULL
from tests.labrig.test_note_command import photograph

CASES = 6
JOURNALS = 15


def thorough(case: Any) -> Any:
    """A further case of the same kind."""
    return pytest.param(case, marks=pytest.mark.thorough)


def at_places(kinds: Sequence[Any], places: Sequence[str]) -> list[Any]:
    """Each kind at one of the places in turn; at the others it is thorough."""
    found = []
    for k, kind in enumerate(kinds):
        for place in places:
            chosen = place == places[k % len(places)]
            found.append(pytest.param(kind, place, marks=() if chosen else pytest.mark.thorough))
    return found


MORE = tuple(map(thorough, range(1, 11)))
PARTS = tuple(map(thorough, range(1, 24)))
RUN = layout.run_path(0)


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole session with people, measurements, and a note with a photograph."""
    path = tmp_path_factory.mktemp("sound") / "s.h5"
    schedule = small_schedule(readings=1, positions_m=(0.0,))
    record(path, schedule, texts={**TEXTS, "about.toml": FULL})
    store_measurements(path, measurements())
    content = photograph(path.with_name("clamp.png")).read_bytes()
    add_note(path, Note(who="Ada", text="the clamp", media_type="image/png", photograph=content))
    return path


def look_at(path: Path, only: tuple[str, ...] = ()) -> set[int]:
    """All commands that only read a session (or some of them); their exit codes."""
    folder = path.parent / "out"
    shutil.rmtree(folder, ignore_errors=True)
    whole = path.with_name("whole.h5")
    whole.unlink(missing_ok=True)
    commands: list[tuple[object, ...]] = [
        ("show", path, "--log"),
        ("show", path, "--json"),
        ("verify", path),
        ("export", path, "-o", folder),
        ("recover", path, "-o", whole),
        ("replay", path, "-o", path.with_name("again.h5")),
    ]
    path.with_name("again.h5").unlink(missing_ok=True)
    codes = set()
    for command in commands:
        if only and command[0] not in only:
            continue
        if command[0] == "replay" and codes == {0}:
            continue  # nothing is wrong with it: to play it all would only take long
        codes.add(told(*command, codes={0, 2, 3, 4, 5, 6})[0])
    return codes


@pytest.mark.slow
def test_the_sound_session_passes(sound: Path) -> None:
    assert look_at(sound) == {0}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *MORE])
def test_flipped_bits_and_missing_pieces_are_told_in_words(
    sound: Path, tmp_path: Path, seed: int
) -> None:
    raw, path = sound.read_bytes(), tmp_path / "s.h5"
    dice = random.Random(seed)
    refused = 0
    for _ in range(CASES):
        path.write_bytes(bytes_of(raw, dice))
        refused += 2 in look_at(path)
    assert refused > CASES / 2


@pytest.mark.thorough
@pytest.mark.slow
def test_a_session_cut_off_anywhere_is_refused(sound: Path, tmp_path: Path) -> None:
    raw, path = sound.read_bytes(), tmp_path / "s.h5"
    dice = random.Random(2)
    for length in (0, 1, 7, 8, 48, 100, *(dice.randrange(len(raw)) for _ in range(10))):
        path.write_bytes(raw[:length])
        assert 2 in look_at(path), length


# ----------------------------------------------------------------------------- made to mislead


def _links(file: Any) -> dict[str, Any]:
    return {
        "soft": h5py.SoftLink("/session/run_000"),
        "soft into nothing": h5py.SoftLink("/nowhere"),
        "soft to itself": h5py.SoftLink("/session/extra"),
        "external": h5py.ExternalLink("/etc/passwd", "/"),
        "external session": h5py.ExternalLink("other.h5", "/session"),
        "to the root": file["/"],
        "to a run": file[RUN],
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "where"),
    few(at_places(
        ["soft", "soft into nothing", "soft to itself", "external", "external session",
         "to the root", "to a run"],
        ["/session/extra", f"{RUN}/signals/force", "/session/setup/texts/x"],
    ), first=2),
)  # fmt: skip
def test_links_are_refused(sound: Path, tmp_path: Path, kind: str, where: str) -> None:
    path = Path(shutil.copy(sound, tmp_path / "s.h5"))
    with h5py.File(path, "r+") as file:
        if where in file:
            del file[where]
        file[where] = _links(file)[kind]
    told("show", path, codes={2})
    told("verify", path, codes={2})


@pytest.mark.slow
def test_groups_that_hold_each_other_twice_are_not_followed_for_ever(
    sound: Path, tmp_path: Path
) -> None:
    path = Path(shutil.copy(sound, tmp_path / "s.h5"))
    with h5py.File(path, "r+") as file:
        group = file["/session"]
        for _ in range(60):  # 2 ** 60 ways down
            below = group.create_group("a")
            group["b"] = below
            group = below
    told("show", path, codes={2})
    told("verify", path, codes={2})


def test_groups_in_groups_without_end_are_refused(sound: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(sound, tmp_path / "s.h5"))
    with h5py.File(path, "r+") as file:
        file.create_group("/session/" + "a/" * 5000)
    told("show", path, codes={2})
    told("verify", path, codes={2})


def _vlen(file: Any, name: str) -> None:
    file.create_dataset(name, data=["x"], dtype=h5py.string_dtype())


def _outside(file: Any, name: str) -> None:
    file.create_dataset(name, (10,), "u1", external=[("/etc/passwd", 0, 10)])


def _virtual(file: Any, name: str) -> None:
    source = h5py.VirtualSource("other.h5", "/session/outcome", shape=(10,))
    virtual = h5py.VirtualLayout(shape=(10,), dtype="f8")
    virtual[:] = source
    file.create_virtual_dataset(name, virtual)


def _endless(file: Any, name: str) -> None:
    file.create_dataset(name, (1 << 50,), "f8", chunks=(1 << 16,))


def _reference(file: Any, name: str) -> None:
    file.create_dataset(name, data=file["/session"].ref, dtype=h5py.ref_dtype)


def _type(file: Any, name: str) -> None:
    file[name] = np.dtype([("a", "f8")])


def _object_array(file: Any, name: str) -> None:
    file.create_dataset(name, (3,), h5py.vlen_dtype("f8"))


FOREIGN = (_vlen, _outside, _virtual, _endless, _reference, _type, _object_array)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "name"),
    few(at_places(FOREIGN, ["/session/extra", "/session/outcome", f"{RUN}/readings"]), first=2),
)
def test_what_a_session_never_holds_is_refused(
    sound: Path, tmp_path: Path, make: Callable[[Any, str], None], name: str
) -> None:
    path = Path(shutil.copy(sound, tmp_path / "s.h5"))
    with h5py.File(path, "r+") as file:
        if name in file:
            del file[name]
        make(file, name)
    told("show", path, codes={2})
    told("verify", path, codes={2})


# ------------------------------------------------------------------- other types, shapes, values

ODD_VALUES = (
    np.float64("nan"),
    np.zeros(0),
    np.zeros((2, 2)),
    np.int8(-1),
    np.uint64(2**64 - 1),
    np.bytes_(b"\xff\xfe"),
    np.array([b"a", b"b"]),
    np.zeros(3, dtype=[("index", "i4"), ("x", "c16")]),
    np.float64(1e308),
    np.bool_(True),
)


def _datasets(path: Path) -> list[str]:
    names: list[str] = []
    with h5py.File(path) as file:
        file.visititems(lambda n, o: names.append(f"/{n}") if isinstance(o, h5py.Dataset) else None)
    return names


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("part", [0, *PARTS])
def test_a_dataset_of_another_type_or_shape_or_none_at_all_is_told_in_words(
    sound: Path, tmp_path: Path, part: int
) -> None:
    dice = random.Random(part)
    path = tmp_path / "s.h5"
    for name in _datasets(sound)[part :: 1 + len(PARTS)]:
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            del file[name]
            if dice.random() < 0.8:
                file[name] = dice.choice(ODD_VALUES)
        codes = look_at(path, only=("verify", "recover", "replay"))
        assert 2 in codes, name


def _set_text(file: Any, name: str, text: str) -> None:
    group, _, key = name.rpartition("/")
    del file[name]
    put_text(file[group], key, text)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        f"{layout.SETUP}/schedule",
        pytest.param(f"{layout.SETUP}/resolved", marks=pytest.mark.thorough),
    ],
)
def test_a_plan_that_makes_no_sense_is_refused(sound: Path, tmp_path: Path, name: str) -> None:
    path = tmp_path / "s.h5"
    with h5py.File(sound) as file:
        text = bytes(file[name][()]).decode()
    for odd in ("", "[" * DEEP, '{"a":' * DEEP, "null", "9" * 5000, "{}"):
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            _set_text(file, name, odd or " ")
        codes = look_at(path)
        assert 2 in codes, odd[:20]
    dice = random.Random(4)
    for _ in range(6):
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            _set_text(file, name, _other_leaf(text, dice))
        look_at(path)


def _other_leaf(text: str, dice: random.Random) -> str:
    """The JSON with one leaf made odd."""
    data = json.loads(text)
    spots: list[tuple[Any, Any]] = []

    def visit(node: Any) -> None:
        items = node.items() if isinstance(node, dict) else enumerate(node)
        for key, value in items:
            spots.append((node, key))
            if isinstance(value, dict | list):
                visit(value)

    visit(data)
    node, key = dice.choice(spots)
    node[key] = dice.choice((None, -1, 10**30, 1e308, "x" * 5000, [], {}, [[]], True, 2.5))
    return json.dumps(data)


@pytest.mark.thorough
@pytest.mark.slow
def test_attributes_that_make_no_sense_are_told_in_words(sound: Path, tmp_path: Path) -> None:
    path = tmp_path / "s.h5"
    odd = (
        np.int64(max(layout.READABLE) + 1),
        np.float64("nan"),
        "1",
        np.zeros((3, 3)),
        [1, 2],
        h5py.Empty("f8"),
    )
    for value in odd:
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            file.attrs["labrig_format"] = value
        assert 2 in look_at(path)
        shutil.copy(sound, path)
        with h5py.File(path, "r+") as file:
            file[layout.DERIVED].attrs["sha256"] = value
        assert 2 in look_at(path, only=("show", "verify"))


# ---------------------------------------------------------------------------------- journals


@pytest.fixture(scope="module")
def cut(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A journal without its session, of a recording that was cut short."""
    from labrig.session import SessionWriter
    from tests.labrig.session.session_recording import session_events, settings

    folder = tmp_path_factory.mktemp("cut")
    schedule = small_schedule(readings=1, positions_m=(0.0,))
    writer = SessionWriter(folder / "live.h5", **settings(schedule))  # type: ignore[arg-type]
    kept = folder / "s.h5.journal"
    kept.hardlink_to(journal_path(folder / "live.h5"))
    for event in session_events(schedule):
        writer.handle(event)
    writer.close()
    return folder / "s.h5"


@pytest.mark.thorough
def test_damaged_journals_are_used_as_far_as_they_are_whole(cut: Path, tmp_path: Path) -> None:
    raw = journal_path(cut).read_bytes()
    path = tmp_path / "s.h5"
    dice = random.Random(5)
    codes = set()
    for _ in range(JOURNALS):
        journal_path(path).write_bytes(bytes_of(raw, dice))
        path.with_name("whole.h5").unlink(missing_ok=True)
        codes.add(told("recover", path, "-o", tmp_path / "whole.h5")[0])
    assert codes == {0, 2}


@pytest.mark.slow
@pytest.mark.parametrize(
    "change",
    few(
        [
            {"path": "/session/setup/schedule"},
            thorough({"path": "/session"}),
            thorough({"path": "/"}),
            {"path": "../../etc"},
            thorough({"path": 7}),
            {"path": "/session/run_000/acquisition", "at": None},
            {"at": -1},
            thorough({"at": 10**30}),
            {"at": "x"},
            thorough({"at": None}),
            thorough({"count": -1}),
            {"count": 10**12},
            thorough({"count": None}),
            {"packed": True},
            thorough({"packed": "x"}),
            thorough({"blob": b""}),
            {"blob": b"x"},
        ],
        first=2,
    ),
    ids=str,
)
def test_a_journal_whose_checksums_are_right_and_content_wrong_is_used_up_to_there(
    cut: Path, tmp_path: Path, change: dict[str, Any]
) -> None:
    from tests.fuzz.journals import rewritten

    path = tmp_path / "s.h5"
    journal_path(path).write_bytes(rewritten(journal_path(cut), change))
    told("recover", path, "-o", tmp_path / "whole.h5", codes={0})


@pytest.mark.thorough
@pytest.mark.slow
def test_a_journal_that_would_unpack_to_gigabytes_does_not(cut: Path, tmp_path: Path) -> None:
    import zlib

    from tests.fuzz.journals import rewritten

    bomb = zlib.compress(b"\0" * (600 << 20), 1)
    path = tmp_path / "s.h5"
    for where in ("images", "events"):
        journal_path(path).write_bytes(
            rewritten(journal_path(cut), {"blob": bomb, "packed": True}, where)
        )
        path.with_name("whole.h5").unlink(missing_ok=True)
        told("recover", path, "-o", tmp_path / "whole.h5", codes={0})


@pytest.mark.slow
@pytest.mark.parametrize(
    "number",
    few(
        [
            NUMBERS[1],
            NUMBERS[5],
            *(thorough(number) for number in (NUMBERS[0], *NUMBERS[2:5], *NUMBERS[6:11])),
        ],
        first=3,
    ),
)
@pytest.mark.parametrize(
    "key",
    few(["rate_hz", "frame_shape", "signals", "range_V", "gain", "unit", "frame_dtype"], first=3),
)
def test_a_journal_of_an_absurd_setup_is_refused(
    cut: Path, tmp_path: Path, key: str, number: str
) -> None:
    from tests.fuzz.journals import with_setup

    value: Any = {"nan": float("nan"), "inf": float("inf"), "-inf": -float("inf")}.get(number)
    value = json.loads(number) if value is None and len(number) < 4000 else value
    if key in {"range_V", "gain", "unit"}:
        channel = {"name": "force", "quantity": "force", "unit": "N", "range_V": 1.0, "gain": 1.0}
        key, value = "signals", [channel | {key: value}]
    elif key != "rate_hz" and key != "frame_dtype":
        value = [value] * (2 if key == "frame_shape" else 3)
    path = tmp_path / "s.h5"
    journal_path(path).write_bytes(with_setup(journal_path(cut), {key: value}))
    told("recover", path, "-o", tmp_path / "whole.h5")
