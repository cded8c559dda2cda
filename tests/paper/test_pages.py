"""Pages whose code is run, with what it prints below it, and blocks that a command prints."""

import subprocess

import pytest

from paper.pages import executed
from paper.printed import filled

PAGE = """# A page

```python
x = 2
print(x, "  ")
```

```text
old
```

Between.

```python
x += 1
open("x.txt", "w").write(str(x))
```
```text
nothing is printed any more
```

<!-- not run -->
```python
raise SystemExit
```

```text
as it is
```

```python
print(x + 1)
```

```
another block
```
"""


def test_each_block_is_followed_by_what_it_prints_and_knows_the_names_of_those_before(tmp_path):
    page = executed(PAGE, tmp_path)
    expected = PAGE.replace("```text\nold\n", "```text\n2\n")
    expected = expected.replace("```\n```text\nnothing is printed any more\n```\n", "```\n")
    expected = expected.replace("print(x + 1)\n```\n", "print(x + 1)\n```\n\n```text\n4\n```\n")
    assert page == expected
    assert (tmp_path / "x.txt").read_text() == "3"
    assert executed(page, tmp_path) == page


PRINTED = """Before.

<!-- printed by: python -c "print('new  ')" -->
```
old
```

```
not ours
```
"""


def test_only_marked_blocks_are_printed_anew():
    assert filled(PRINTED) == PRINTED.replace("old", "new")
    assert filled(filled(PRINTED)) == filled(PRINTED)


def test_a_command_that_fails_is_an_error():
    with pytest.raises(subprocess.CalledProcessError):
        filled(PRINTED.replace("print('new  ')", "raise SystemExit(3)"))
