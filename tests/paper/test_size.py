"""What is counted of the rooms."""

import ast

import pytest

from paper.size import constants, functions, slowest


@pytest.mark.parametrize(
    ("line", "count"),
    [("A = 3", 1), ("A: float = -1e-3", 1), ("A = 10**6", 1), ("A = (1, 2.5)", 1), ("A = B + 1", 0), ("A = True", 0)],
)
def test_a_number_of_a_module_counts(line, count):
    assert constants(ast.parse(line)) == count
    assert constants(ast.parse(f"def f():\n    {line}")) == 0


def test_functions_and_tests_are_listed_with_their_lengths(tmp_path):
    assert list(functions(ast.parse("def f():\n    x = 1\n    return x\n"))) == [(3, "f")]
    (tmp_path / "junit.xml").write_text(
        '<testsuites><testsuite><testcase classname="a" name="fast" time="0.1"/>'
        '<testcase classname="b" name="slow" time="9"/></testsuite></testsuites>'
    )
    assert slowest(tmp_path / "junit.xml")["test"].tolist() == ["b::slow", "a::fast"]
