"""A session's curves both ways on the command line: of the mean image, and frame by frame."""

import json

import pytest

from labrig.analysis import analyze
from labrig.cli.main import run
from labrig.session import load_measurements
from protocols import Place, make_schedule
from protocols.kinds.pulse_train import PulseTrain
from tests.labrig.analysis.analysed import record_with, with_pictures

pytestmark = pytest.mark.slow
TRAIN = PulseTrain(zero_readings=2, readings_per_voltage=2)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """At 2 V the sheet holds still, otherwise its readings differ."""
    path = tmp_path_factory.mktemp("both") / "s.h5"

    def curvature(voltage_V, reading):
        return 12.0 if voltage_V > 0 else 10.0 + 0.25 * (reading % 4)

    schedule = make_schedule(TRAIN, [Place("long", (0.005,))])
    return record_with(path, schedule, with_pictures(curvature), frame_shape=(260, 360))


def test_both_ways_are_stored_and_reported_with_their_difference(session, capsys):
    analyze(session)
    zero, plus, _ = load_measurements(session).conditions
    for condition in (zero, plus):
        assert condition.curve is not None
        assert all(reading.curve is not None for reading in condition.readings)
    assert run(["curves", str(session), "--json"]) == 0
    told = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [line["image"] for line in told] == [
        "long, 5 mm, 0 V",
        "long, 5 mm, +2 V",
        "long, 5 mm, -2 V",
    ]
    moved, still = (line["by_frame"] for line in told[:2])
    assert moved["frames"] == still["frames"] == 2
    # two curvatures 0.25 per m apart: tips 0.31 mm apart; the mean of much more shows no end
    assert max(moved["scatter_mm"]) == pytest.approx(0.305 / 2**0.5, rel=0.05)
    assert max(still["scatter_mm"]) < 0.01
    assert still["from_mean_image_mm"] < 0.005
    assert run(["curves", str(session)]) == 0
    assert "2 frames scatter by 0.00" in capsys.readouterr().out.splitlines()[1]
