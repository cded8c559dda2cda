from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.fixture(autouse=True)
def _beside_the_toys(monkeypatch):
    """`toys:Normal` is found as a user's own module is: beside the user."""
    monkeypatch.chdir(HERE)
    monkeypatch.syspath_prepend(str(HERE))
