"""Pages that are made from the code hold all that the code has."""

from __future__ import annotations

import inspect
from importlib import import_module

import pytest

from labrig.cli.app import all_commands
from labrig.session.tables import columns

COMMANDS = [command for command in all_commands() if "." not in command.name]


def made(name):
    return import_module(f"made.{name}")


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_every_command_and_subcommand_has_an_example(command):
    commands = made("commands")
    for path in commands.paths(command):
        assert commands.examples(command, path), f"add examples=... to the COMMAND of '{path}'"


def test_a_command_without_an_example_would_be_found():
    from labrig.cli.command import Command

    commands = made("commands")
    bare = Command("bare", test_a_command_without_an_example_would_be_found)
    assert commands.paths(bare) == ["labrig bare"]
    assert commands.examples(bare, "labrig bare") == []


@pytest.mark.slow
def test_the_page_of_commands_runs_each_example_that_is_quick():
    page = made("commands").page()
    for command in COMMANDS:
        for example in command.examples:
            block = page.split(f"\n{example.line}\n")[0].rsplit("````{terminal}", 1)
            assert example.run_by or (len(block) == 2 and "````" not in block[1]), example.line


def test_every_column_of_the_tables_is_described():
    page = made("csv_columns").page()
    names = {name for _, *kinds in columns.TABLES.values() for kind in kinds for name in kind}
    assert all(f"| `{name}` |" in page for name in names)
    assert set(columns.MEANINGS) == names


def test_every_public_name_is_documented_with_a_docstring():
    api = made("python_api")
    page = api.page()
    for name, thing in api.public_names():
        assert name in page
        assert not callable(thing) or inspect.getdoc(thing), f"{name} has no docstring"


def test_what_a_field_of_a_data_class_means_is_on_the_page():
    page = made("python_api").page()
    for said in (
        '- `held_out`: conditions not used: (configuration or "" for all, position in m)',
        "- `position_m`: along the arc; None: free, no load cell touches the sheet",
        "- `most_effects`: more take longer",
    ):
        assert said in page


@pytest.mark.slow
@pytest.mark.parametrize("file", ["rig", "sheet", "protocol", "load_cell", "about", "optics"])
def test_every_key_of_a_configuration_file_is_on_its_page(file):
    from labrig.config.schema import schemas
    from labrig.vision import Optics

    schema = schemas().get(file) or Optics.model_json_schema()
    page = made("configuration").pages()[f"{file}_file"]
    keys = set(keys_of(schema))
    assert keys
    shown = ("`{}`", "{}]", "[{}.")
    assert [key for key in keys if not any(form.format(key) in page for form in shown)] == []


def keys_of(schema):
    """Yield the keys of a table and of all tables in it, those of each kind of a device too."""
    if isinstance(schema, dict):
        yield from schema.get("properties", {})
        for inner in schema.values():
            yield from keys_of(inner)
    elif isinstance(schema, list):
        for inner in schema:
            yield from keys_of(inner)


# -- features of models, the paper's tables 1 and 2


def features_of(model):
    from labrig.analysis.features import FEATURES

    return dict(
        zip([one.name for one in FEATURES], made("model_features").marks(model), strict=True)
    )


@pytest.mark.slow
def test_a_model_has_the_features_that_its_predictions_show():
    from labrig.analysis.features import ProbedModel, respond_of
    from model.dynamics.models import models

    lee, gonzalez, pugal = (
        features_of(ProbedModel("", respond_of(models()[name])))
        for name in ("lee", "gonzalez", "pugal")
    )
    assert lee["linearity"] == "yes"
    assert lee["large deformations"] == "no"
    assert lee["dynamic behaviour"] == "without inertia"
    assert gonzalez["dynamic behaviour"] == "no"
    assert gonzalez["large deformations"] == "yes"
    assert pugal["non-uniform EIBM"] == "yes"
    assert pugal["force output"] == "no"
    assert pugal["linearity"] != "yes"


@pytest.mark.slow
def test_the_papers_model_has_all_but_linearity_and_motion():
    from labrig.analysis.features import labrigs_models

    found = features_of(labrigs_models()["at rest"])
    without = [name for name, answer in found.items() if answer == "no"]
    assert without == ["linearity", "dynamic behaviour"]


def test_a_model_that_ignores_its_contact_has_neither_position_nor_elongation():
    from labrig.analysis.features import ProbedModel
    from model.dynamics.models import Response

    def blocked(run):
        return Response(force_N=1e-3 * run.drive_V)

    found = features_of(ProbedModel("", blocked))
    assert found["force output"] == "yes"
    assert found["varying load position"] == "no"
    assert found["elongation"] == "no"
    assert found["initial curvature"] == "no"
    assert found["large deformations"] == "-"
    assert found["linearity"] == "yes"
    assert found["dynamic behaviour"] == "no"
