import numpy as np

from avobench.diagnosis.fit.descent import settled
from avobench.diagnosis.fit.fit import fit_at
from avobench.diagnosis.fit.surrogate import Design, surrogate
from avobench.diagnosis.summary.bins import bins_of
from avobench.diagnosis.summary.target import target_of
from avobench.effects.catalogue import catalogue
from avobench.effects.model import Model
from avobench.tasks.weinberg import Weinberg


def test_what_the_data_identify_is_settled_with_more_events():
    """Two directions: of weinberg's theta only one combination shows, and the smearing. From few events neither is
    plain; from more both are, and the error of the smearing is no longer that of its range."""
    task = Weinberg()
    (smearing,) = [effect for effect in catalogue(task) if effect.key == ("resolution", 0)]
    model, truth = Model(task, (smearing,)), np.array([46.0, 1.0, 0.25])
    rng = np.random.default_rng(4)
    x = model.simulate(np.tile(truth, (20_000, 1)), rng)
    target = target_of(x, bins_of(x, x), x)
    design = Design.box(model.to_cube(truth), np.array([0.01, 0.01, 0.02]))
    few = fit_at(model, surrogate(model, target, design, 10_000, rng), target, model.to_cube(truth))
    assert few.undecided
    assert few.num_identified < 2
    plain = settled(few, target, rng, 20_000, (30, 90))
    assert plain.num_identified == 2
    assert plain.std[2] < 0.01 < 0.1 < few.std[2]
    assert abs(plain.params[2] - truth[2]) < 4 * plain.std[2]
