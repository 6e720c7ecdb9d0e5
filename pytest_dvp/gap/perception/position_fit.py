"""Latency, offset and noise of detections, from how far they lie from the objects they belong to."""

from __future__ import annotations

from math import inf, log

import numpy as np

from pytest_dvp.gap.compare.start_correction import IntArray
from pytest_dvp.gap.perception.detection_pairs import Frames, Pairs
from pytest_dvp.logs.log_contents import FloatArray

BLOCK = 5.0  # s; of one object: what counts as independent
_FINEST = 0.02  # m, noise that no detector is better than
_HUBER = 2.5  # standard deviations, beyond which a box pulls less
BANDS = ((0.0, 20.0), (20.0, 40.0))  # m, in which a stack acts on what it sees; chosen
_WILD = 3.0  # standard deviations (by the median), beyond which a box is off by more than noise; chosen
_FAR = 4.0  # beyond which it no longer counts as noise
_CLIP = 20.0  # beyond which it brings no more likelihood
_MOVES = 0.05  # m/s: with slower objects no latency shows


class Positions:
    """Latency and offset by weighted least squares, noise by likelihood, from pairs around a first guess.

    step (3,): change of latency, offset x, y; spread (3,) its standard deviation, inf where these data do not tell;
    noise (2,): sigma0, slope, with noise_spread (2,); worth: log-likelihood of latency, offset, noise;
    far [m]: of each pair; blocks, things: which rows depend on each other.
    """

    def __init__(self, f: Frames, p: Pairs, noise: FloatArray) -> None:
        frame, thing = np.nonzero(p.seen)
        e = np.concatenate([p.dx[frame, thing], p.dy[frame, thing]])
        c, s = np.cos(p.yaw[frame]), np.sin(p.yaw[frame])
        x = np.column_stack([
            -np.concatenate([p.vx[frame, thing], p.vy[frame, thing]]), np.concatenate([c, s]), np.concatenate([-s, c])
        ])  # fmt: skip
        block = (f.t[frame] // BLOCK).astype(np.int64) * 1000 + thing
        self.blocks: IntArray = np.unique(np.concatenate([block, block]), return_inverse=True)[1].astype(np.int64)
        things = np.unique(np.concatenate([thing, thing]), return_inverse=True)[1].astype(np.int64)
        self.far, self.things = p.distance[frame, thing], things
        distance = np.concatenate([self.far, self.far])
        self.e, self.x = e, x
        level = np.maximum(noise[0] + noise[1] * distance, _FINEST)
        told = np.sqrt((x * x).sum(axis=0) / len(e)) > np.array([_MOVES, 1e-6, 1e-6])
        self.step = np.zeros(3)
        for _ in range(5):
            rest = (e - x @ self.step) / level
            weight = np.minimum(1.0, _HUBER / np.maximum(np.abs(rest), 1e-9)) / level**2
            a = (x * weight[:, None]).T @ x + np.diag(np.where(told, 1e-9, 1e12))
            self.step = np.linalg.solve(a, (x * weight[:, None]).T @ e)
        rest = e - x @ self.step
        bread, scores = np.linalg.inv(a), x * (weight * rest)[:, None]
        self.spread = np.where(told, _clustered(bread, scores, self.blocks, things), inf)
        self.rest = rest
        self.noise, self.noise_spread = _noise(rest, distance, self.blocks, things)
        self.level = np.maximum(self.noise[0] + self.noise[1] * distance, _FINEST)

    def loss(self, place: FloatArray, without: tuple[int, ...]) -> float:
        """Log-likelihood lost when these of the three parameters are 0 and the others adapt.

        place (3,): latency [s] and offset along x and y [m] that all of them have; without: indices of those set to 0.
        """
        kept = [k for k in range(3) if k not in without]
        e = self.rest + self.x @ place  # as if latency and offset were 0
        w = self.x[:, kept] / self.level[:, None]
        y = e / self.level
        theta = np.linalg.lstsq(w, y, rcond=None)[0] if kept else np.zeros(0)
        left = np.clip(y - w @ theta, -_CLIP, _CLIP) if kept else np.clip(y, -_CLIP, _CLIP)
        full = np.clip(self.rest / self.level, -_CLIP, _CLIP)
        return max(0.5 * float(left @ left - full @ full), 0.0)

    def levels(self) -> FloatArray | None:
        """Noise [m] and its standard deviation by BANDS of distance (bands, 2); None if one of them holds no box.

        Boxes that are wildly off, as of a car that was taken for a turned one, count as _WILD standard deviations.
        """
        distance = np.concatenate([self.far, self.far])
        found = []
        for least, most in BANDS:
            inside = (distance >= least) & (distance < most)
            if not inside.any():
                return None
            wild = _WILD * 1.4826 * float(np.median(np.abs(self.rest[inside])))
            square = np.clip(self.rest[inside], -wild, wild) ** 2
            level = max(float(np.sqrt(square.mean())), _FINEST)
            scores = (square - square.mean())[:, None] / (2.0 * level * len(square))
            groups = (np.unique(by[inside], return_inverse=True)[1] for by in (self.blocks, self.things))
            found.append([level, float(_clustered(np.eye(1), scores, *groups)[0])])
        return np.array(found)

    def noise_worth(self) -> float:
        """Log-likelihood that the noise brings over a detector at its finest."""
        fine = 0.5 * np.clip(self.rest / _FINEST, -_CLIP, _CLIP) ** 2 + log(_FINEST)
        return max(float(np.sum(fine - 0.5 * (self.rest / self.level) ** 2 - np.log(self.level))), 0.0)


def _clustered(bread: FloatArray, scores: FloatArray, *groupings: IntArray) -> FloatArray:
    """Standard deviations with errors that depend on each other within groups (Liang and Zeger 1986), the largest of
    several ways to group the rows.

    By time one object errs anew with each block; by object what is made of its shape stays wrong as long as it is seen.
    With the first alone, two of six drives in which nothing was hidden showed an offset of 0.06 m.
    """
    widest = np.diag(bread @ (scores.T @ scores) @ bread)
    for groups in groupings:
        sums = np.zeros((int(groups.max()) + 1, scores.shape[1]))
        np.add.at(sums, groups, scores)
        m = len(sums)
        widest = np.maximum(widest, np.diag(bread @ (sums.T @ sums) @ bread) * (m / max(m - 1, 1)))
    return np.asarray(np.sqrt(widest))


def _noise(rest: FloatArray, distance: FloatArray, *groupings: IntArray) -> tuple[FloatArray, FloatArray]:
    """sigma0 and slope of sigma = sigma0 + slope distance by Fisher scoring, and their standard deviations."""
    z = np.column_stack([np.ones(len(rest)), distance])
    scale = np.array([1.0, 1.0 / max(float(distance.mean()), 1.0)])
    z = z * scale
    theta = np.array([0.5, 0.5]) * max(1.4826 * float(np.median(np.abs(rest))), 1e-3)
    information = np.eye(2)
    free = np.array([True, True])
    for _ in range(60):
        level = np.maximum(z @ theta, 1e-3)
        each = (-1.0 / level + np.minimum(rest**2, (_FAR * level) ** 2) / level**3)[:, None] * z
        information = (z * (2.0 / level**2)[:, None]).T @ z
        free = (theta > 1e-9) | (each.sum(axis=0) > 0.0)
        step = np.zeros(2)
        own = np.flatnonzero(free)
        if len(own):
            # at one distance alone the two cannot be told apart, and the shortest step does
            step[own] = np.linalg.lstsq(information[np.ix_(own, own)], each.sum(axis=0)[own], rcond=None)[0]
        moved = np.maximum(theta + step, 0.0)
        done = float(np.abs(moved - theta).max()) < 1e-7
        theta = moved
        if done:
            break
    bread: FloatArray = np.linalg.pinv(information).astype(np.float64)
    spread = _clustered(bread, each, *groupings)
    return theta * scale, spread * scale
