"""What shows beside the sheet's edge, chosen in optics.json or on the command line."""

import json

import pytest

from labrig.cli.main import run


@pytest.fixture(scope="module")
def silhouette(scenes, tmp_path_factory):
    folder = tmp_path_factory.mktemp("look")
    scene = scenes.make_scene(scenes.Recipe(seed=902, physical=True, face=1.0, bright=False))
    scenes.save(scene, folder, "dark")
    return folder / "dark.png"


@pytest.mark.slow
@pytest.mark.parametrize("look", ["auto", "silhouette"])
def test_the_look_is_an_option(silhouette, look, capsys):
    assert run(["curves", str(silhouette), "--look", look, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["ok"]
    assert any("far face" in text for text in told["warnings"])


@pytest.mark.slow
def test_another_look_is_refused_with_what_there_is(silhouette, capsys):
    assert run(["curves", str(silhouette), "--look", "glow"]) == 2
    assert "silhouette" in capsys.readouterr().err
