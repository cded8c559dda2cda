"""What goes to a terminal: text alone, as a name, a message or a file from elsewhere could hold orders to it."""

import unicodedata

LAYOUT = "\n\t"
"""The control characters that are printed as they are."""


def plain(text: object) -> str:
    r"""A text in which control characters, marks that turn its direction and halves of characters are written as \x1b.

    They would move the cursor, hide or forge lines, or fail in a terminal's encoding.
    """
    return "".join(
        each if each in LAYOUT or unicodedata.category(each)[0] != "C" else each.encode("unicode_escape").decode()
        for each in str(text)
    )
