"""Tables in text as people write them, whose values are known: a grammar for hypothesis."""

from typing import Any

from hypothesis import strategies as st

VALUES = st.floats(-1e6, 1e6).map(lambda value: round(value, 3))
FORMS = st.fixed_dictionaries(
    {
        "separator": st.sampled_from([",", ";", "\t", "|", " ", "   "]),
        "comma": st.booleans(),
        "header": st.booleans(),
        "units": st.booleans(),
        "comments": st.booleans(),
        "blank": st.booleans(),
        "trailing": st.booleans(),
        "end": st.sampled_from(["\n", "\r\n"]),
        "bom": st.booleans(),
        "gz": st.booleans(),
    }
)


def written(rows: list[tuple[Any, ...]], form: dict[str, Any]) -> tuple[str, list[int]]:
    """The text of a table, and the number of the line of each row."""
    separator, blanks = form["separator"], form["separator"].isspace() and form["separator"] != "\t"
    point = "," if form["comma"] and separator in (";", "\t", "|") else "."
    ends = separator if form["trailing"] and not blanks else ""
    lines = ["# measured on a Monday", "# with care"] if form["comments"] else []
    if form["header"]:
        lines.append(separator.join("abc"[: len(rows[0])]))
        if form["units"]:
            lines.append(separator.join(["keV"] * len(rows[0])))
    numbers = []
    for row in rows:
        lines += ["", "# a pause"] if form["blank"] and len(numbers) == 1 else []
        lines.append(separator.join(str(value).replace(".", point) for value in row) + ends)
        numbers.append(len(lines))
    return ("\ufeff" if form["bom"] else "") + form["end"].join(lines) + form["end"], numbers
