"""The benchmarks' renderer, which shares no code with the extractor, for the tests of it."""

import importlib.util
import json
import sys
from pathlib import Path

import pytest

from labrig.vision import Optics, StripGeometry


@pytest.fixture(scope="session")
def scenes():
    path = Path(__file__).parents[3] / "benchmarks" / "vision_scenes.py"
    spec = importlib.util.spec_from_file_location("vision_scenes", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["vision_scenes"] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def known():
    """Optics and strip of a rendered scene."""

    def parts(scene, **changes):
        optics = Optics.from_json(json.dumps(scene.optics | changes))
        mm = {key: value / 1000 for key, value in scene.strip.items()}
        strip = StripGeometry(mm["free_length_mm"], mm["elongation_mm"], mm["thickness_mm"])
        return optics, strip

    return parts


@pytest.fixture(scope="session")
def plain(scenes):
    """One plain long sheet, rendered once."""
    return scenes.make_scene(scenes.Recipe(seed=3, physical=True))
