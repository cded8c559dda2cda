"""The gallery of real data."""

import re
from pathlib import Path

from paper.gallery import EXAMPLES, PAGE, page
from paper.studies.real import read

ROOT = Path(__file__).parents[2]


def test_the_gallery_is_of_the_committed_records_and_small_pictures_of_all_examples():
    shown = (ROOT / PAGE).read_text()
    assert shown == page(read(ROOT / "results" / "real"))
    pictures = [ROOT / PAGE.parent / path for path in re.findall(r"\]\((figures/.*?)\)", shown)]
    assert [path.stem for path in pictures] == sorted(path.stem for path in (ROOT / EXAMPLES).glob("*.py"))
    assert all(path.stat().st_size < 60_000 for path in pictures)
