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


def test_a_command_that_fails_is_an_error():
    with pytest.raises(subprocess.CalledProcessError):
        filled(PAGE.replace("print('new  ')", "raise SystemExit(3)"))
