from avobench.diagnosis.effort import Effort, effort_for
from avobench.tasks.poisson import Poisson


def test_effort_follows_the_number_of_simulations():
    task = Poisson()
    assert effort_for(task, "counts", None, 20_000) == Effort()
    less = effort_for(task, "counts", 400_000, 20_000)
    assert less.fit < Effort().fit
    assert less.fit >= 2000
