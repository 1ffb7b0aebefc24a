"""From pictures and times to figures."""

import flip_evaluator
import numpy as np


def displayed(picture):
    """Linear RGB as sRGB with a hard clip."""
    clipped = np.clip(picture, 0, 1)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055).astype(np.float32)


class Truth:
    """A converged picture: two halves with different seeds, and what their difference tells of the noise of their mean."""

    def __init__(self, first, second):
        self.picture = (first + second) / 2
        self.mean = float(self.picture.mean())
        self.noise = float(np.mean((first - second) ** 2)) / 4

    @property
    def relative_noise(self):
        return self.noise**0.5 / self.mean

    def squared_error(self, picture):
        """Square of the relRMSE of a picture, the truth's own noise taken out."""
        return (float(np.mean((picture - self.picture) ** 2)) - self.noise) / self.mean**2


    def flip(self, picture):
        """Mean FLIP of a picture as displayed; the truth's own noise counts, too."""
        _, mean, _ = flip_evaluator.evaluate(displayed(self.picture), displayed(picture), "LDR", applyMagma=False)
        return float(mean)


def time_to(target, points):
    """Time at which the error falls to `target`, by straight lines between the logarithms of (time, error) points.

    None if it is never reached; the first point's time if that is good enough, since there is no less than a sample.
    """
    before = None
    for time, error in points:
        if error <= target:
            if before is None:
                return time
            (t0, e0), (t1, e1) = before, (time, error)
            share = np.log(e0 / target) / np.log(e0 / e1)
            return float(np.exp(np.log(t0) + share * np.log(t1 / t0)))
        before = (time, error)
    return None


def median(times, key):
    return float(np.median([time[key] for time in times]))


def correlation(a, b):
    """Of the brightness of two pictures, averaged over 4 x 4 pixels: 1 if they show the same but for exposure."""
    def coarse(picture):
        height, width, _ = picture.shape
        return picture.mean(axis=2).reshape(height // 4, 4, width // 4, 4).mean(axis=(1, 3)).ravel()

    return float(np.corrcoef(coarse(a), coarse(b))[0, 1])
