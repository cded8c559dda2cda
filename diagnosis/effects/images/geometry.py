"""A detector that is not where the simulation has it: hits move between the cells of a sphere in (eta, phi)."""

from dataclasses import dataclass

import numpy as np

from avobench.diagnosis.effects.base import Parameter
from avobench.diagnosis.effects.images.base import ImageEffect
from avobench.tasks.alignment import MAX_ETA

SOURCE = "V. Blobel, Nucl. Instrum. Methods A 566 (2006) 5"
AZIMUTH = Parameter("azimuth", -np.pi, np.pi, None, "rad")


@dataclass(frozen=True)
class Moved(ImageEffect):
    """Each hit, taken to lie anywhere in its cell, is moved on the sphere; what leaves |eta| < MAX_ETA is lost."""

    source = SOURCE

    def moved(self, n, phi):
        """New directions, not normalised: unit vectors n (3, m), phi (m, q) -> (3, m)."""
        raise NotImplementedError

    def apply(self, simulate, theta, phi, rng):
        x = simulate(theta, rng)
        rows, columns = self.grid
        event, cell = np.nonzero(x)
        eta = ((cell // columns + rng.random(len(cell))) / rows * 2 - 1) * MAX_ETA
        azimuth = (cell % columns + rng.random(len(cell))) / columns * 2 * np.pi
        across = 1 / np.cosh(eta)
        n = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.tanh(eta)])
        a, b, c = self.moved(n, phi[event])
        row = np.floor((np.arcsinh(c / np.hypot(a, b)) / MAX_ETA + 1) / 2 * rows).astype(int)
        column = np.floor(np.arctan2(b, a) / (2 * np.pi) * columns).astype(int) % columns
        # A hit of an effect that is absent stays where it is, whatever rounding does to it.
        still = phi[event, 0] == 0
        row, column = np.where(still, cell // columns, row), np.where(still, cell % columns, column)
        seen = (row >= 0) & (row < rows)
        image = np.zeros_like(x)
        at = (event[seen], (row * columns + column)[seen])
        if x.dtype.kind in "iu":
            np.maximum.at(image, at, x[event, cell][seen])
        else:
            np.add.at(image, at, x[event, cell][seen])
        return image


@dataclass(frozen=True)
class TransverseOffset(Moved):
    """The interaction point is `shift` radii of the sphere away from its axis, towards an azimuth."""

    name = "transverse_offset"
    sentence = "The collisions do not happen on the axis of the detector."
    parameters = (Parameter("shift", 0, 0.5, 0, "of the radius"), AZIMUTH)

    def moved(self, n, phi):
        r = np.stack([phi[:, 0] * np.cos(phi[:, 1]), phi[:, 0] * np.sin(phi[:, 1]), np.zeros(len(phi))])
        return n + r - n * (n * r).sum(axis=0)


@dataclass(frozen=True)
class AxialTilt(Moved):
    """The axis of the detector is tilted against the beam by an angle, towards an azimuth."""

    name = "axial_tilt"
    sentence = "The axis of the detector is tilted against the beam."
    parameters = (Parameter("tilt", 0, 0.5, 0, "rad"), AZIMUTH)

    def moved(self, n, phi):
        towards = np.stack([np.cos(phi[:, 1]), np.sin(phi[:, 1])])
        along = (n[:2] * towards).sum(axis=0)
        sine, cosine = np.sin(phi[:, 0]), np.cos(phi[:, 0])
        turned = along * cosine + n[2] * sine
        return np.concatenate([n[:2] + towards * (turned - along), (n[2] * cosine - along * sine)[None]])
