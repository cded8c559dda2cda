"""Masses of two muons, measured by CMS: the Z boson with its natural width, were the detector perfect."""

from pathlib import Path

import numpy as np

import avobench

WIDTH = 2.4952
"""Of the Z boson, in GeV: Particle Data Group, Phys. Rev. D 98 (2018) 030001."""
LOW, HIGH = 76.0, 106.0
"""Masses that are looked at, in GeV: 15 on either side of the Z boson's, as analyses do."""


def dimuons(theta, rng):
    mass = theta[:, 0]  # a Breit-Wigner distribution between LOW and HIGH, by its inverse
    low, high = (np.arctan((end - mass) / (WIDTH / 2)) for end in (LOW, HIGH))
    return mass + WIDTH / 2 * np.tan(rng.uniform(low, high))


task = avobench.task(dimuons, prior={"mass": (85, 97)}, units={"mass": "GeV"}, features=["mass"])
mass = np.loadtxt(Path(__file__).with_suffix(".csv"))
measured = mass[(mass > LOW) & (mass < HIGH)]

if __name__ == "__main__":
    print(avobench.diagnose(task, measured))
