"""Arguments and options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Json = Annotated[bool, typer.Option("--json", help="print JSON")]
Recorded = Annotated[Path, typer.Argument(help="a recorded session")]
RigFile = Annotated[Path, typer.Argument(help="rig.toml")]
AboutFile = Annotated[
    Path | None,
    typer.Option("--about", help="about.toml; by default the one beside rig.toml, if any"),
]
ModelFile = Annotated[Path, typer.Argument(help="a model file, as labrig fit writes it")]
OwnEibm = Annotated[
    list[str] | None,
    typer.Option(
        "--eibm",
        metavar="VOLTAGE=EIBM",
        help="an EIBM of your own in N m, or a table with s_mm, Me_Nm (2=eibm.csv); repeatable",
    ),
]
StatedStiffness = Annotated[
    float | None,
    typer.Option("--stiffness-Nm2", help="B, with sheet.toml and --eibm in place of a model file"),
]
EachConfiguration = Annotated[
    list[str] | None, typer.Option(help="repeatable; by default all that the model has")
]

FigureFormats = Annotated[
    list[str] | None,
    typer.Option("--format", help="of figures: png, svg, pdf; repeatable; default png and svg"),
]

# What `diagnose` and `next` measure the model against: sessions or CSV tables.
Sessions = Annotated[
    list[Path] | None,
    typer.Argument(help="a session; further ones of the same sheet are used together with it"),
]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        "--columns",
        metavar="OURS=THEIRS",
        help="the name of a column in the tables, such as force_mN=F; repeatable, also for one"
        " column: each table takes the first name that it has",
    ),
]
Values = Annotated[
    list[str] | None,
    typer.Option(
        "--value",
        metavar="OURS=VALUE",
        help="a column that is the same in all lines, such as configuration=long; repeatable",
    ),
]
Ignored = Annotated[
    list[str] | None,
    typer.Option(
        "--ignore", metavar="THEIRS", help="a column of the tables to leave out; repeatable"
    ),
]
SheetFile = Annotated[
    Path | None, typer.Option(help="sheet.toml, with CSV tables instead of a session")
]
ForcesFile = Annotated[Path | None, typer.Option(help="forces.csv")]
CurvesFile = Annotated[Path | None, typer.Option(help="curves.csv")]
SignalsFile = Annotated[Path | None, typer.Option(help="signals.csv")]
Stiffness = Annotated[
    float | None,
    typer.Option(
        "--stiffness-Nm2",
        help="B of sheets that no force was measured of; shapes alone determine EIBM/B only",
    ),
]
KnownModel = Annotated[
    Path | None,
    typer.Option(
        "--model", help="a model file whose effects, and dynamics where it has them, are known"
    ),
]
Symmetric = Annotated[
    bool, typer.Option("--symmetric", help="one |EIBM| for both polarities: asymmetry is a finding")
]
