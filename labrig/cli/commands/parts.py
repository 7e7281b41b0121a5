"""The parts that labrig finds: its own, and those of other distributions."""

from __future__ import annotations

from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json
from labrig.cli.screen import print_json, print_table, warn


def parts(
    kind: Annotated[
        str, typer.Argument(help="one kind, such as cameras: all of its parts, labrig's own too")
    ] = "",
    as_json: Json = False,
) -> None:
    """List the parts that are found, and who they are from.

    Effects, cameras, protocols, commands and all other kinds; docs/howto/extending.md says how to
    add one. A part that cannot be used is left out with a sentence.
    """
    from drivers.plugins import OWN
    from labrig.cli.part_folders import (
        FOLDERS,
        PREFIX,
        folder_of,
        groups_of_no_kind,
        nearest,
    )
    from labrig.errors import BadInputError

    if kind and (kind := kind.removeprefix(PREFIX)) not in FOLDERS:
        close = nearest(kind)
        hint = f"did you mean {close}?" if close else "labrig parts lists all kinds."
        raise BadInputError(f"there is no kind of part '{kind}'; {hint}")
    folders = {name: folder_of(name) for name in ([kind] if kind else FOLDERS)}
    found = {name: list(folder.parts().values()) for name, folder in folders.items()}
    if as_json:
        print_json(
            {
                name: [
                    {"name": one.name, "distribution": one.distribution, "version": one.version}
                    for one in every
                ]
                for name, every in found.items()
            }
        )
    elif kind:
        rows = [[one.name, one.distribution, one.version or "-"] for one in found[kind]]
        print_table(PREFIX + kind, ["name", "distribution", "version"], rows)
    else:
        print_table(
            "Parts",
            ["kind", "entry-point group", "labrig's", "of other distributions"],
            [
                [
                    folders[name].what,
                    PREFIX + name,
                    str(sum(one.distribution == OWN for one in every)),
                    ", ".join(
                        f"{one.name} ({one.distribution} {one.version})"
                        for one in every
                        if one.distribution != OWN
                    )
                    or "-",
                ]
                for name, every in found.items()
            ],
        )
    for sentence in groups_of_no_kind():
        warn(sentence)


COMMAND = Command(
    "parts",
    parts,
    order=255,
    examples=(
        CommandExample(line="labrig parts"),
        CommandExample(line="labrig parts cameras"),
    ),
)
