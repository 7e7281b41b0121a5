"""The structure that CONTRIBUTING.md promises, measured from the code's own imports."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow  # every module is read

ROOT = Path(__file__).parents[1]
PACKAGES = ("labrig", "drivers", "protocols", "model", "sim_hardware")
KINDS = (ast.Import, ast.ImportFrom, ast.Call, ast.ClassDef)
MOST_MODULES = 15
MOST_POSITIONAL = 7
# (folder, most direct children, most imports between them, but for `plugins`, which each kind of
# part needs)
FOLDERS = [
    ("model", 12, 33),
    ("labrig/vision", 16, 55),
    ("labrig/report", 16, 55),
    ("labrig/panel", 16, 55),
]
# folders with one part a module: as many as there are
PLUGIN_FOLDERS = {
    "labrig/batch/tasks",
    "labrig/cli/commands",
    "labrig/exports",
    "labrig/extractors",
    "labrig/panel/pages",
    "labrig/report/sections",
    "labrig/vision/checks/kinds",
    "labrig/vision/facts/kinds",
    "drivers/cameras",
    "drivers/positioners",
    "drivers/force_sensors",
    "drivers/boards",
    "protocols/kinds",
    "protocols/extras",
    "model/effects",
    "model/locations",
    "model/dynamics/models",
    "model/discrepancy/criticism/kinds",
    "model/discrepancy/data_checks/kinds",
    "model/identification/reading_patterns/kinds",
    "sim_hardware/families",
    "sim_hardware/ni/boards",
    "sim_hardware/serial_devices",
}


@cache
def modules() -> dict[str, Path]:
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    }


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes(path: Path) -> dict[type[ast.AST], list[ast.AST]]:
    """What the tests look for in a module, by kind: it is walked through once."""
    found: dict[type[ast.AST], list[ast.AST]] = {kind: [] for kind in KINDS}
    for node in ast.walk(tree(path)):
        if type(node) in found:
            found[type(node)].append(node)
    return found


@cache
def imports() -> dict[str, frozenset[str]]:
    """The modules that each module imports by name, for types too.

    A package's face (`__init__`) counts only where it is imported as such.
    """
    return {name: frozenset(_imported(name)) for name in modules()}


def _imported(name: str) -> Iterator[str]:
    found = nodes(modules()[name])
    for node in found[ast.Import]:
        yield from (alias.name for alias in node.names if alias.name in modules())
    for node in found[ast.ImportFrom]:
        for alias in node.names if node.module else ():
            inner = f"{node.module}.{alias.name}"
            if inner in modules():
                yield inner
            elif node.module in modules():
                yield node.module


def test_no_modules_import_each_other_in_a_circle():
    done: dict[str, int] = {}  # 1: under way, 2: done
    circles = []

    def visit(name: str, way: tuple[str, ...]) -> None:
        done[name] = 1
        for other in sorted(imports()[name] - {name}):
            if done.get(other) == 1:
                circles.append(" -> ".join((*way[way.index(other) :], other)))
            elif other not in done:
                visit(other, (*way, other))
        done[name] = 2

    for name in modules():
        if name not in done:
            visit(name, (name,))
    assert circles == []


def test_a_folder_holds_few_modules_unless_it_is_one_of_plug_ins():
    count: dict[str, int] = defaultdict(int)
    for path in modules().values():
        if path.name not in {"__init__.py", "__main__.py"}:
            count[path.parent.relative_to(ROOT).as_posix()] += 1
    crowded = {f: n for f, n in count.items() if n > MOST_MODULES and f not in PLUGIN_FOLDERS}
    assert crowded == {}


@pytest.mark.parametrize(("folder", "most_children", "most_imports"), FOLDERS)
def test_the_parts_of_a_folder_are_few_and_loosely_tied(folder, most_children, most_imports):
    dotted = folder.replace("/", ".") + "."
    inside = [name for name in modules() if name.startswith(dotted)]
    child = {name: name.removeprefix(dotted).split(".")[0] for name in inside}
    ties = {
        (child[name], child[other])
        for name in inside
        for other in imports()[name]
        if other in child and child[other] not in (child[name], "plugins")
    }
    assert len(set(child.values())) <= most_children
    assert len(ties) <= most_imports


def test_a_class_name_means_one_thing():
    places = defaultdict(list)
    for path in modules().values():
        folder = path.parent.relative_to(ROOT).as_posix()
        if folder in PLUGIN_FOLDERS or path.name == "plugins.py" or path.name == "jit.py":
            continue
        for node in tree(path).body:
            if isinstance(node, ast.ClassDef):
                places[node.name].append(path.relative_to(ROOT).as_posix())
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


def test_no_call_passes_many_arguments_by_position():
    many = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in modules().values()
        for node in nodes(path)[ast.Call]
        if _positional(node) > MOST_POSITIONAL
    ]
    assert many == []


def _positional(call: ast.Call) -> int:
    return sum(not isinstance(argument, ast.Starred) for argument in call.args)


def test_data_classes_with_more_than_four_fields_are_keyword_only():
    loose = [
        f"{path.relative_to(ROOT)}:{node.lineno} {node.name}"
        for path in modules().values()
        for node in nodes(path)[ast.ClassDef]
        if _is_loose(node)
    ]
    assert loose == []


def _is_loose(node: ast.ClassDef) -> bool:
    fields = [s for s in node.body if isinstance(s, ast.AnnAssign) and not _is_class_var(s)]
    for decorator in node.decorator_list:
        call = decorator if isinstance(decorator, ast.Call) else None
        name = call.func if call else decorator
        if isinstance(name, ast.Name) and name.id == "dataclass" and len(fields) > 4:
            return not (call and any(k.arg == "kw_only" for k in call.keywords))
    return False


def _is_class_var(statement: ast.AnnAssign) -> bool:
    return "ClassVar" in ast.unparse(statement.annotation)


def test_the_architecture_page_is_made_from_the_code_as_it_is():
    spec = spec_from_file_location("architecture", ROOT / "docs" / "architecture.py")
    assert spec is not None
    assert spec.loader is not None
    architecture = module_from_spec(spec)
    spec.loader.exec_module(architecture)
    architecture.parsed = tree  # what was read and looked through already
    architecture.import_lines = lambda path: nodes(path)[ast.Import] + nodes(path)[ast.ImportFrom]
    kept = (ROOT / "docs" / "reference" / "architecture.md").read_text(encoding="utf-8")
    assert kept == architecture.page(), "run `python docs/architecture.py`"


@pytest.mark.parametrize("package", [name for name in PACKAGES if name != "sim_hardware"])
def test_contributing_names_every_folder_of_a_package(package):
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    folders = [path.parent.name for path in (ROOT / package).glob("*/__init__.py")]
    assert [name for name in sorted(folders) if f"`{name}`" not in text] == []
