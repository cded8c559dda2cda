"""A histogram as it was published (Greenwood and Yule 1920), whose last class is open: 5 accidents or more."""

import avobench

workers = [447, 132, 42, 21, 3, 2]  # with 0, 1, 2, 3, 4, and 5 or more accidents
table = avobench.Table([-0.5, 0.5, 1.5, 2.5, 3.5, 4.5, 99.5], workers, feature="accidents", name="workers")


def accidents(theta, rng):  # a simulator: all workers are equally liable to accidents
    return rng.poisson(theta[:, 0])


task = avobench.task(accidents, prior={"rate": (0.1, 3)}, features=["accidents"])

if __name__ == "__main__":
    print(avobench.diagnose(task, table))
