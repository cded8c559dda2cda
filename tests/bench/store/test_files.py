"""Files are written whole or not at all, and nowhere but where they belong."""

from pathlib import Path

import pytest

from avobench.bench.store.files import within, write_atomically
from avobench.tasks.errors import UsageError


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "file").write_text("old")
    (tmp_path / "link").symlink_to("file")
    write_atomically(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "file").read_bytes() == b"new"


@pytest.mark.parametrize("name", ["../x", "/x", "a/b", "", ".", "..", "a\0b", "a\\b", "a/../b"])
def test_a_name_that_leads_to_another_folder_is_refused(name):
    with pytest.raises(UsageError, match="would not lie in"):
        within(Path("folder"), name)
    assert within(Path("folder"), "x.json") == Path("folder/x.json")
