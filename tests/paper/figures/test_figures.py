"""The paper's figures; what they show of the committed records is compared in tests/docs/test_published.py."""

import numpy as np
import pytest

from avobench.bench.cells.streams import observe
from avobench.tasks.errors import StoreError
from avobench.tasks.weinberg import Weinberg
from paper.figures import alignment, dimension, poisson, weinberg


@pytest.mark.parametrize(("std", "mean"), [(1e-6, 7), (0.3, 7 * np.exp(0.3**2 / 2))])
def test_the_model_of_a_proposal_has_the_mean_of_a_poisson_of_a_lognormal_rate(std, mean):
    record = {"trace": [{"simulations": 1, "theta": [np.log(7)], "std": [std]}]}
    counts = np.arange(40)
    np.testing.assert_allclose(poisson.model(record, counts) @ counts, mean, rtol=1e-4)


def test_weinberg_draws_the_very_observation_and_the_density_at_the_estimate(benchmark):
    _, table = weinberg.drawn(benchmark)
    panel = table[(table["target"] == 1) & (table["method"] == "bolfi")]
    x = observe(Weinberg(), 1, 2_000, 0)
    np.testing.assert_allclose(panel["observed_density"], np.histogram(x, 20, (-1, 1), density=True)[0], rtol=1e-5)
    theta = Weinberg().targets()[1] - 1e-2
    np.testing.assert_allclose(panel["fitted_density"], Weinberg().density(panel["cos_a"], theta), rtol=1e-5)


NEEDS = [(poisson, "study"), (alignment, "study"), (weinberg, "weinberg"), (dimension, "study dimension")]


@pytest.mark.parametrize(("figure", "said"), NEEDS)
def test_without_the_records_that_it_needs_a_figure_says_so(figure, said):
    with pytest.raises(StoreError, match=said):
        figure.drawn([])
