"""Whether pictures of two seeds differ by noise alone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.errors import StageError
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

BIASED = Code(
    "noise-biased", Status.FAIL, "Pictures of two sets of seeds differ by more than noise."
)
STILL = Code("noise-none", Status.FAIL, "Pictures of two seeds are the same: a seed does nothing.")
BROKEN = Code("render-not-finite", Status.FAIL, "A pixel of a render is infinite or no number.")

PICTURES = 4
"""Pictures of each set, from which the noise of a pixel is estimated."""

SIGMAS = 5.0
"""Largest difference of the sets' means, in standard errors of the whole picture."""

LARGEST = 2.5
"""Largest mean square of the pixels' t-values; 1.5 is expected of six degrees of freedom."""


@check(
    id="render/noise",
    why="A difference that stays when the seed changes is in the picture, not in the noise.",
    needs=("material", "shader", "textures", "renderer"),
    codes=(BIASED, STILL, BROKEN),
)
def seed_noise(asset: OpenAsset) -> Iterator[Finding]:
    """The same stage at other seeds differs by noise alone."""
    from weaveusd.validate.trial import Setting, trials

    setting = Setting(8.0, sky=0.3, lamp=45.0)
    spp = max(4, asset.profile.spp // PICTURES)
    try:
        with trials(asset) as trial:
            pictures = [
                trial.render(setting, spp=spp, seed=seed).image.mean(axis=-1, dtype=np.float64)
                for seed in range(2 * PICTURES)
            ]
    except StageError:
        return  # render/swatch reports it
    where = str(asset.material.GetPath())
    if not np.isfinite(pictures).all():
        yield BROKEN("a pixel is no finite number", where)
    elif np.array_equal(pictures[0], pictures[1]):
        yield STILL("the pictures of seeds 0 and 1 are the same", where)
    else:
        sigmas, square = compared(np.array(pictures[:PICTURES]), np.array(pictures[PICTURES:]))
        if abs(sigmas) > SIGMAS or square > LARGEST:
            yield BIASED(
                f"the means differ by {sigmas:.1f} standard errors, and pixels by {square:.2f} "
                f"in the mean square, expected at most {SIGMAS:g} and {LARGEST:g}",
                where,
            )


def compared(one: Doubles, other: Doubles) -> tuple[float, float]:
    """Return how two sets (N, H, W) of pictures differ: z of their means, mean t² of pixels.

    Noise is estimated from picture to picture, so that the samples of a pixel need not be
    independent, as they are not. z had a root mean square of 0.9 over 50 pairs of sets with 16
    samples a pixel, and of 1.3 with 4, where seeds four or eight apart are correlated by 0.14.
    Pixels without noise that differ by nothing do not count.
    """
    count = len(one)
    difference = one.mean(axis=0) - other.mean(axis=0)
    variance = (one.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / count
    noisy = (variance > 1e-12) | (np.abs(difference) > 1e-5)
    safe = np.maximum(variance[noisy], 1e-12)
    t = difference[noisy] / np.sqrt(safe)
    sigmas = difference[noisy].sum() / np.sqrt(safe.sum())
    # One pixel whose few samples happen to agree must not decide.
    return float(sigmas), float(np.mean(np.minimum(t**2, 100.0))) if t.size else 0.0
