"""Blocks of a page that a command prints."""

import subprocess

import pytest

from paper.printed import filled

PAGE = """Before.

<!-- printed by: python -c "print('new  ')" -->
```
old
```

```
not ours
```
"""


def test_only_marked_blocks_are_printed_anew():
    assert filled(PAGE) == PAGE.replace("old", "new")
    assert filled(filled(PAGE)) == filled(PAGE)


def test_a_file_is_shown_as_it_is(tmp_path):
    (tmp_path / "kills.txt").write_text("1000 kills\n")
    page = f"<!-- text of: {tmp_path / 'kills.txt'} -->\n```\nold\n```\n"
    assert filled(page) == page.replace("old", "1000 kills")


def test_a_command_that_fails_is_an_error():
    with pytest.raises(subprocess.CalledProcessError):
        filled(PAGE.replace("print('new  ')", "raise SystemExit(3)"))
