"""Names that a key of a configuration table cannot have, since the table's model has them."""

from __future__ import annotations

# public attributes of the models of tables (labrig.config.derived), of any version of pydantic
RESERVED = frozenset(
    {
        "construct",
        "copy",
        "dict",
        "former_names",
        "from_orm",
        "json",
        "keys",
        "parse_file",
        "parse_obj",
        "parse_raw",
        "schema",
        "schema_json",
        "settings",
        "settings_type",
        "suggestion",
        "update_forward_refs",
        "validate",
        "with_paths_from",
    }
)


def is_reserved(name: str) -> bool:
    """Return whether every table uses a name itself."""
    return name in RESERVED or name.startswith(("_", "model_"))
