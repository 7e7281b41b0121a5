"""labrig export --as video: the frames of each run, as they were recorded."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.exports import video
from labrig.exports.choice import export
from labrig.session import open_session
from tests.labrig.report_data import measure, session


@pytest.fixture(scope="module")
def session_file(tmp_path_factory):
    return session(tmp_path_factory.mktemp("video") / "session.h5", measure("long"))


def frames_of(path) -> list[np.ndarray]:
    video, found = cv2.VideoCapture(str(path)), []
    while True:
        ok, frame = video.read()
        if not ok:
            return found
        found.append(frame[..., 0])


@pytest.mark.slow
def test_each_run_becomes_a_video_of_its_frames(session_file, tmp_path, capsys):
    assert run(["export", str(session_file), "-o", str(tmp_path), "--as", "video"]) == 0
    names = sorted(path.name for path in tmp_path.glob("*.avi"))
    assert names == ["run-01-long-0mm.avi", "run-02-long-10mm.avi"]
    assert f"wrote {tmp_path / names[0]}" in capsys.readouterr().out
    with open_session(session_file) as recorded:
        first = recorded.run(0)
        frames = frames_of(tmp_path / names[0])
        assert len(frames) == first.frame_count
        for number, frame in enumerate(frames):
            image = first.image(number)
            times = 320 // image.shape[1]  # small images are enlarged
            rows, columns = (times * length for length in image.shape)
            assert frame.shape[1] == columns
            pixels = frame[:rows].reshape(rows // times, times, columns // times, times)
            away = np.abs(pixels.mean(axis=(1, 3)) - image)
            assert away.mean() < 4.0  # JPEG
            assert frame[rows:].max() > 200  # the caption
        steps = np.diff(first.frame_column("time"))
        rate = cv2.VideoCapture(str(tmp_path / names[0])).get(cv2.CAP_PROP_FPS)
        assert rate == pytest.approx(1.0 / np.median(steps), rel=0.02)


@pytest.mark.slow
def test_a_folder_that_cannot_be_written_leaves_no_part_of_a_video(
    session_file, tmp_path, monkeypatch, capsys
):
    class Closed:
        def __init__(self, *_, **__) -> None: ...
        def isOpened(self) -> bool:
            return False

        def release(self) -> None: ...

    monkeypatch.setattr(cv2, "VideoWriter", type("W", (Closed,), {"fourcc": lambda *_: 0}))
    assert run(["export", str(session_file), "-o", str(tmp_path), "--as", "video"]) != 0
    error = capsys.readouterr().err
    assert "run-01-long-0mm.avi" in error
    assert "Traceback" not in error
    assert list(tmp_path.glob("*.avi")) == []


@pytest.mark.slow
def test_a_video_export_that_is_stopped_leaves_no_video_and_can_be_repeated(
    session_file, tmp_path, monkeypatch
):
    writer, written = video._write, []

    def stopped(run_, path):
        if written:
            raise KeyboardInterrupt
        writer(run_, path)
        written.append(path)

    with monkeypatch.context() as patched:
        patched.setattr(video, "_write", stopped)
        with pytest.raises(KeyboardInterrupt):
            export(session_file, tmp_path, "video")
    assert written
    assert list(tmp_path.iterdir()) == []
    assert len(export(session_file, tmp_path, "video")) == 2


def test_a_video_that_is_there_is_left_alone(session_file, tmp_path, capsys):
    (tmp_path / "run-02-long-10mm.avi").write_text("mine")
    assert run(["export", str(session_file), "-o", str(tmp_path), "--as", "video"]) == 2
    assert "run-02-long-10mm.avi exists already" in capsys.readouterr().err
    assert [path.read_text() for path in tmp_path.glob("*.avi")] == ["mine"]
