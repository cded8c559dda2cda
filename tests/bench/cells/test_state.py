"""What one cell does to the process is nothing to the next."""

import pytest
from dirty import WAYS

from fuzz.answers import Methods


@pytest.fixture(scope="module")
def methods(tmp_path_factory):
    return Methods(tmp_path_factory.mktemp("dirty"))


@pytest.mark.parametrize("how", WAYS)
def test_a_dirty_cell_costs_itself_at_most_and_leaves_no_trace(how, methods):
    methods.check([how])
