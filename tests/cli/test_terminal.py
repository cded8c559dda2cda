"""What is printed is text, whatever it was made of."""

import unicodedata

from hypothesis import given
from hypothesis import strategies as st

from avobench.api.terminal import plain


@given(st.text(st.characters()))
def test_what_is_printed_gives_no_orders_to_a_terminal(text):
    printed = plain(text)
    printed.encode()
    assert all(unicodedata.category(each)[0] != "C" or each in "\n\t" for each in printed)
    if text.isprintable():
        assert printed == text
