"""about.toml: title, project, licence, people and sample of an experiment.

Fields map one to one onto NeXus (NXuser, NXsample), DataCite and RO-Crate;
`docs/howto/about.md` has the table.
"""

from __future__ import annotations

import datetime as dt
import re
import unicodedata
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

from packaging.licenses import InvalidLicenseExpression, canonicalize_license_expression
from pydantic import AfterValidator, Field

from labrig.config.base import ClosedModel, parse_toml, read_text, validate
from labrig.config.file_kinds import ABOUT, refuse_other_kind
from labrig.errors import BadInputError

FILE = "about.toml"  # its name beside rig.toml and among a session's texts
_ORCID = re.compile(r"(?:https?://orcid\.org/)?(\d{4}-\d{4}-\d{4}-\d{3}[\dX])")
_EMAIL = re.compile(r"[^@\s]+@[^@\s.]+(\.[^@\s.]+)+")

Role = Literal[
    "operator", "contact", "principal_investigator", "researcher", "data_curator", "other"
]


def _printable(text: str) -> str:
    if any(unicodedata.category(sign) in {"Cc", "Cs"} and sign not in "\n\t" for sign in text):
        raise ValueError("should be text without control characters")
    return text


def _one_line(text: str) -> str:
    if "\n" in text or "\t" in text:
        raise ValueError("should be one line")
    return " ".join(_printable(text).split())


def _licence(text: str) -> str:
    """Return the expression as SPDX writes it; an empty one stays empty."""
    if not text.strip():
        return ""
    try:
        return str(canonicalize_license_expression(text))
    except InvalidLicenseExpression:
        raise ValueError(
            "should be a licence of the SPDX list (https://spdx.org/licenses) such as CC-BY-4.0 "
            "or CC0-1.0"
        ) from None


def _orcid(text: str) -> str:
    """Return the bare identifier; its last character is the checksum of ISO 7064, MOD 11-2."""
    if not text.strip():
        return ""
    found = _ORCID.fullmatch(text.strip())
    if found is None:
        raise ValueError("should be an ORCID iD such as 0000-0002-1825-0097")
    bare = found.group(1)
    total = 0
    for digit in bare.replace("-", "")[:-1]:
        total = (total + int(digit)) * 2
    wanted = (12 - total % 11) % 11
    if bare[-1] != ("X" if wanted == 10 else str(wanted)):
        raise ValueError("has a wrong check digit; copy the ORCID iD again")
    return bare


def _email(text: str) -> str:
    if text and not _EMAIL.fullmatch(text):
        raise ValueError("should be an address such as name@example.org")
    return text


def _not_blank(text: str) -> str:
    if not text:
        raise ValueError("should not be empty")
    return text


Line = Annotated[str, Field(max_length=200), AfterValidator(_one_line)]
Name = Annotated[Line, AfterValidator(_not_blank)]
Paragraph = Annotated[str, Field(max_length=5000), AfterValidator(_printable)]


class Person(ClosedModel):
    """Somebody who has part in the experiment."""

    name: Annotated[Name, Field(description="given name and family name")]
    role: Role = Field("operator", description="in the experiment")
    affiliation: Line = Field("", description="institute or company")
    email: Annotated[Line, AfterValidator(_email)] = Field("", description="address to write to")
    orcid: Annotated[str, Field(max_length=60), AfterValidator(_orcid)] = Field(
        "", description="ORCID iD, such as 0000-0002-1825-0097"
    )


class SampleConfig(ClosedModel):
    """The sheet that is measured."""

    identity: Annotated[Name, Field(description="what tells it from all others")]
    material: Line = Field("", description="of membrane and electrodes")
    batch: Line = Field("", description="of the material, as its maker names it")
    preparation: Paragraph = Field("", description="how it was made and treated")
    made: dt.date | None = Field(None, description="when it was made")
    notes: Paragraph = Field("", description="anything else about the sheet")


class About(ClosedModel):
    """What an experiment is about, and whose it is."""

    title: Line = Field("", description="of the experiment")
    project: Line = Field("", description="to which the experiment belongs")
    licence: Annotated[
        str,
        Field(max_length=200, description="SPDX identifier of the data's licence"),
        AfterValidator(_licence),
    ] = ""
    people: list[Person] = Field([], max_length=50, description="who has part in it")
    sample: SampleConfig | None = Field(None, description="the sheet that is measured")

    @property
    def operators(self) -> tuple[str, ...]:
        """Names of those who operate the rig."""
        return tuple(person.name for person in self.people if person.role == "operator")

    @property
    def is_empty(self) -> bool:
        """Whether nothing at all is stated."""
        return self == About()


def parse_about(text: str, name: str) -> About:
    """about.toml's text as an object."""
    if text.strip():
        refuse_other_kind(text, name, ABOUT)
    return validate(About, parse_toml(text, name), name)


def load_about(path: Path) -> About:
    """Read about.toml."""
    return parse_about(read_text(path, ABOUT), str(path))


def recorded_about(texts: Mapping[str, str]) -> About:
    """Return what a session's texts state; nothing where there is no such text, or an unreadable.

    The text itself stays in the session whatever it holds.
    """
    try:
        return parse_about(texts.get(FILE, ""), FILE)
    except BadInputError:
        return About()
