"""Swatches: small lit pictures of a recipe's cloth, without a renderer, and for a terminal."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.draft.transform import repeat
from weaveusd.synth.textures import MAX_TEXELS, synthesize

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import Band
    from weaveusd.yarn.model import Recipe

    Doubles = NDArray[np.float64]
    Picture = NDArray[np.uint8]

MAX_PIXELS = 1024
"""Pixels along one side of a swatch."""

THREADS, PIXELS = 12, 3
"""Fewest ends across a swatch, unless each had fewer pixels. A larger repeat is shown once."""

FINER = 4
"""Texels along the side of a pixel."""

LIGHT = (-0.52, 0.55, 0.65)
"""Where the light is, from the cloth: above the upper left corner. Its length is about one."""

SKY = 0.3
"""Share of the light that comes from the whole sky."""

GROUND = 0.18
"""Reflectance of the gray table that gaps show."""


def swatch(recipe: Recipe, *, width: int, height: int) -> Picture:
    """Return a picture of the cloth that `recipe` makes in its own weave, else in plain weave.

    Textures of the real yarns are lit by one lamp and a sky. With the occlusion a, the albedo C,
    the reflectance at normal incidence F and the isotropic share k_d, a texel sends ::

        L = a C (S + (1 - S) max(n·l, 0) (k_d + (1 - k_d) g(2γ_v))) + (1 - S) F g(2γ_s)

    where S is `SKY` and g(w) = exp(-(θ_l + θ_v)² / w²), θ the inclinations of light and eye to
    the plane across the fibre: what a fibre reflects, without the integrals of the exact BSDF.
    The picture is as bright as the cloth's mean albedo.

    Parameters
    ----------
    recipe
        A preset or a recipe of one's own; a yarn without a color takes the usual draft's.
    width, height
        Pixels, 1 to `MAX_PIXELS`. Pixels are square on the cloth.

    Returns
    -------
    (height, width, 3) uint8
        Display sRGB, the first row at the top: x, the weft, runs right and the warp up.

    Raises
    ------
    ValueError
        When a size is out of bounds.
    """
    if not (1 <= width <= MAX_PIXELS and 1 <= height <= MAX_PIXELS):
        raise ValueError(f"swatch of {width} × {height}, expected 1 to {MAX_PIXELS} pixels")
    cloth, view_mm = _cut(recipe, width, height)
    pixel_mm = view_mm / width
    finest = FINER * max(cloth.repeat_mm) / pixel_mm
    resolution = min(max(8, math.ceil(finest)), MAX_TEXELS)
    texels = synthesize(cloth, resolution=resolution).whole()
    light = _lit(texels, _Table.of(cloth))
    solid = texels["opacity"] > 0
    albedo = texels["base_color"].mean(axis=-1, dtype=np.float64, keepdims=True)
    light *= float(albedo[solid].mean() / light.mean(axis=-1, keepdims=True)[solid].mean())
    light += (1 - texels["opacity"]) * (GROUND - light)
    linear = _sampled(light, cloth.repeat_mm, pixel_mm, (height, width))
    return _srgb(linear)[::-1].copy()


def swatch_text(image: Picture) -> str:
    """Return `image` (H, W, 3) uint8 as text for a terminal of 24-bit color, two rows a line.

    Each cell is an upper half block whose foreground and background are its two pixels; the last
    line of an odd picture leaves the background alone. Lines are separated by a line feed, and
    every one resets the colors. Raises ValueError for an array of another shape or type.
    """
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise ValueError(f"picture of {image.dtype} {image.shape}, expected uint8 (H, W, 3)")
    lines = []
    for top in range(0, len(image), 2):
        pair = image[top : top + 2].tolist()
        cells = ("".join(_cell(*pixels) for pixels in zip(*pair, strict=True)), "\x1b[0m")
        lines.append("".join(cells))
    return "\n".join(lines)


def _cell(upper: list[int], lower: list[int] | None = None) -> str:
    red, green, blue = upper
    below = "" if lower is None else ";48;2;{};{};{}".format(*lower)
    return f"\x1b[38;2;{red};{green};{blue}{below}m▀"


def _cut(recipe: Recipe, width: int, height: int) -> tuple[Weave, float]:
    """Return the cloth, repeated so that its unevenness shows, and the width in mm to show."""
    draft = make_draft(recipe.weave or "plain")
    once = weave(draft, recipe)
    across, along = once.repeat_mm
    ends = min(THREADS, width / PIXELS)
    view_mm = across * max(1.0, ends / draft.ends)
    repeats = math.ceil(view_mm / across), math.ceil(view_mm * height / width / along)
    limit = max(1, round(MAX_TEXELS / 2 / max(draft.ends, draft.picks)))
    return weave(repeat(draft, min(repeats[0], limit), min(repeats[1], limit)), recipe), view_mm


class _Table(NamedTuple):
    """The optics of each yarn, (yarns,) each."""

    k_d: Doubles
    reflectance: Doubles
    gamma_s: Doubles
    gamma_v: Doubles

    @classmethod
    def of(cls, cloth: Weave) -> _Table:
        optics = [yarn.optics for yarn in cloth.yarns]
        return cls(
            np.array([o.k_d for o in optics]),
            np.array([o.k_s * ((o.eta - 1) / (o.eta + 1)) ** 2 for o in optics]),
            np.array([o.gamma_s for o in optics]),
            np.array([o.gamma_v for o in optics]),
        )


def _lit(texels: Band, table: _Table) -> Doubles:
    """Return the light (H, W, 3) that comes from every texel, seen from above."""
    yarn = np.maximum(texels["yarn_id"][..., 0].astype(np.intp), 0)
    towards_light = np.array(LIGHT) / math.sqrt(math.fsum(c * c for c in LIGHT))
    facing = np.maximum(texels["normal"] @ towards_light, 0)
    sine_light = texels["tangent"] @ towards_light
    sine_view = texels["tangent"][..., 2].astype(np.float64)
    away = np.arcsin(np.clip(sine_light, -1, 1)) + np.arcsin(np.clip(sine_view, -1, 1))
    volume = np.exp(-((away / (2 * table.gamma_v[yarn])) ** 2))
    surface = np.exp(-((away / (2 * table.gamma_s[yarn])) ** 2)) * (facing > 0)
    k_d = table.k_d[yarn]
    scattered = SKY + (1 - SKY) * facing * (k_d + (1 - k_d) * volume)
    color = texels["base_color"] * (scattered * texels["ambient_occlusion"][..., 0])[..., None]
    shine = (1 - SKY) * table.reflectance[yarn] * surface
    return np.asarray(color + shine[..., None], dtype=np.float64)


def _sampled(
    light: Doubles, repeat_mm: tuple[float, float], pixel_mm: float, shape: tuple[int, int]
) -> Doubles:
    """Return pixels (height, width, 3): means of `FINER`² texels of the periodic `light`."""
    rows, columns = (
        ((np.arange(FINER * count) + 0.5) * (pixel_mm / FINER) / size * texels).astype(np.intp)
        % texels
        for count, size, texels in zip(shape, repeat_mm[::-1], light.shape[:2], strict=True)
    )
    fine = light[rows[:, None], columns]
    return np.asarray(fine.reshape(shape[0], FINER, shape[1], FINER, 3).mean(axis=(1, 3)))


def _srgb(linear: Doubles) -> Picture:
    """Return display sRGB (IEC 61966-2-1) of linear Rec.709."""
    low, high = 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    display = np.clip(np.where(linear > 0.0031308, high, low), 0, 1)
    return np.asarray(np.rint(255 * display), dtype=np.uint8)
