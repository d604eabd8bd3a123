"""The pictures of a glTF material: 8-bit PNGs whose channels are packed as glTF wants them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.export.bands import across_fibre, codes_of, per_yarn, read_bands, size_of, vectors
from weaveusd.export.images import ImageWriter

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from weaveusd.export.bands import Floats, Rows
    from weaveusd.export.files import LookFiles
    from weaveusd.shading.material import StandardFit

    Bytes = NDArray[np.uint8]

BASE_COLOR, NORMAL, SURFACE, ANISOTROPY = "base_color", "normal", "surface", "anisotropy"

_SOURCES = {
    "base_color": "base_color.png",
    "opacity": "opacity.png",
    "normal": "normal.png",
    "tangent": "tangent.png",
    "yarn_id": "yarn_id.png",
    "occlusion": "ambient_occlusion.png",
}


@dataclass(frozen=True, slots=True)
class Pictures:
    """The picture of each texture, and the mean opacity, which is in the color's alpha below 1."""

    files: dict[str, Path]
    cover: float


@dataclass(frozen=True, slots=True)
class GltfLobe:
    """What `KHR_materials_anisotropy` makes of a fit.

    With r the roughness and s the strength, α along the fibre is ``r²`` and α across it
    ``r² + (1 - r²) s²``, where the direction of anisotropy is across the fibre.
    """

    roughness: float
    strength: float


def gltf_lobe(fit: StandardFit) -> GltfLobe:
    """Return the lobe with the GGX roughnesses of `fit`."""
    along, across = fit.alpha_along, fit.alpha_across
    share = (across - along) / (1 - along) if along < 1 else 0.0
    return GltfLobe(math.sqrt(along), math.sqrt(max(share, 0.0)))


def write_pictures(
    asset: Path, files: LookFiles, fits: Sequence[StandardFit], folder: Path
) -> Pictures:
    """Write the pictures of the look `files` of the asset in `asset` into `folder`.

    `base_color` is sRGB, with the opacity as alpha where there are gaps; `normal` is the normal
    in the cloth frame, +y up; `surface` holds ambient occlusion, roughness and no metal;
    `anisotropy` the direction across the fibre and the strength.

    Raises
    ------
    InputError
        A texture is missing or broken.
    WeaveusdError
        A picture could not be written.
    """
    sources = {key: asset / files.texture(name) for key, name in _SOURCES.items()}
    lobes = [gltf_lobe(fit) for fit in fits]
    width, height = size_of(sources["opacity"])
    opaque = sum(
        int(rows["opacity"].sum(dtype=np.int64))
        for rows in read_bands({"opacity": sources["opacity"]})
    )
    cover = opaque / (255 * width * height)
    gaps = cover < 1
    pictures = {name: folder / f"{name}.png" for name in (BASE_COLOR, NORMAL, SURFACE, ANISOTROPY)}
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(
                ImageWriter(
                    path, width, height, 4 if gaps and name == BASE_COLOR else 3, "uint8",
                    {"oiio:ColorSpace": "srgb_rec709_scene" if name == BASE_COLOR else "data"},
                )
            )
            for name, path in pictures.items()
        }  # fmt: skip
        for rows in read_bands(sources):
            for name, codes in _made(rows, lobes, gaps=gaps):
                writers[name].write(codes)
    return Pictures(pictures, cover)


def _made(rows: Rows, lobes: Sequence[GltfLobe], *, gaps: bool) -> Iterator[tuple[str, Bytes]]:
    color, opacity = rows["base_color"], rows["opacity"]
    yield BASE_COLOR, np.concatenate([color, opacity], -1) if gaps else color
    normal, fibre = vectors(rows["normal"]), vectors(rows["tangent"])
    yield NORMAL, _signed(normal)
    roughness = codes_of(per_yarn(rows, [lobe.roughness for lobe in lobes], 1.0))
    occlusion = rows["occlusion"][..., 0]
    yield SURFACE, np.stack([occlusion, roughness, np.zeros_like(occlusion)], -1)
    strength = codes_of(per_yarn(rows, [lobe.strength for lobe in lobes], 0.0))
    direction = _signed(across_fibre(normal, fibre))
    yield ANISOTROPY, np.concatenate([direction, strength[..., None]], -1)


def _signed(values: Floats) -> Bytes:
    return codes_of((values + np.float32(1)) * np.float32(0.5))
