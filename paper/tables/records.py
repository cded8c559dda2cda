"""The fields of a record as a table in Markdown, for docs/records.md: `python -m paper.tables.records`."""

from typing import Any

from avobench.bench.store.record import Record


def fields_table() -> str:
    """The fields of a record with their types and meaning, one row per field."""
    properties = Record.model_json_schema()["properties"]
    rows = [f"| `{name}` | {_type(shape)} | {shape['description']} |" for name, shape in properties.items()]
    rows.insert(1, "| `sha256` | text | checksum of all other fields |")
    return "\n".join(["| field | type | meaning |", "|---|---|---|", *rows]) + "\n"


def _type(shape: dict[str, Any]) -> str:
    """A type of the JSON schema in a word or two."""
    if "anyOf" in shape:
        return " or ".join(map(_type, shape["anyOf"]))
    if shape.get("type") == "array":
        return f"list of {_type(shape['items']).replace(' or ', 's or ')}s"
    words = {"string": "text", "integer": "whole number"}
    if "Status" in shape.get("$ref", ""):
        return "text"
    kind = shape.get("type", "object")
    return words.get(kind, kind)


if __name__ == "__main__":
    print(fields_table(), end="")
