"""The benchmarks' renderer, which shares no code with the extractor, for the tests of it."""

import json

import pytest

from benchmarks import vision_scenes
from labrig.vision import Optics, StripGeometry


@pytest.fixture
def one_look(monkeypatch):
    """Curves are found without the second look at a picture, which can take most of the time.

    For tests of something else; test_second_look.py has tests of it.
    """
    monkeypatch.setattr("labrig.vision.extraction.extract.seen_again", lambda found, *_: found)


@pytest.fixture(scope="session")
def scenes():
    return vision_scenes


@pytest.fixture(scope="session")
def known():
    """Optics and strip of a rendered scene."""

    def parts(scene, **changes):
        optics = Optics.from_json(json.dumps(scene.optics | changes))
        mm = {key: value / 1000 for key, value in scene.strip.items()}
        strip = StripGeometry(
            free_length_m=mm["free_length_mm"],
            elongation_m=mm["elongation_mm"],
            thickness_m=mm["thickness_mm"],
        )
        return optics, strip

    return parts


@pytest.fixture(scope="session")
def plain(scenes):
    """One plain long sheet, rendered once."""
    return scenes.make_scene(scenes.Recipe(seed=3, physical=True))
