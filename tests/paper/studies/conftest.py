import pytest


@pytest.fixture(autouse=True)
def _beside(beside_users_modules):
    """Every test here may name a module of a user's."""
