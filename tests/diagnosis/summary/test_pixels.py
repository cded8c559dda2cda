import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from avobench.diagnosis.summary.pixels import pixels_of


@given(st.integers(0, 30))
def test_the_moments_of_images_add_up_also_where_there_are_none(cut):
    rng = np.random.default_rng(0)
    images, weights = rng.integers(0, 2, (30, 4 * 10)), rng.standard_normal((30, 3))
    summary = pixels_of(images, images, (4, 10))
    first, rest = summary.moments(images[:cut], weights[:cut]), summary.moments(images[cut:], weights[cut:])
    np.testing.assert_allclose(first + rest, summary.moments(images, weights), rtol=1e-5, atol=1e-5)
