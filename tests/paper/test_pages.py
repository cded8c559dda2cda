"""Pages whose code is run, with what it prints below it."""

from paper.pages import executed

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
