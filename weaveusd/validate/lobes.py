"""The judge's own statement of what maps for standard shaders hold.

A lobe of GGX is α_t wide across the fibre and α_b along it. Maps store it as the roughness r of
OpenPBR 1.1, r⁴ = (α_t² + α_b²) / 2, and as the rotation (cos 2φ, sin 2φ) p towards its wide axis,
p = (α_t − α_b) / (α_t + α_b); the angle φ is about the normal, from X laid into the surface.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.validate.compiled import compiled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bytes = NDArray[np.uint8]
    Doubles = NDArray[np.float64]

ROUGHNESS, LENGTH = range(2)
LOW, HIGH = range(2)


class Spans:
    """Least and largest of what the texels of each yarn say of its lobe, in levels of 8 bits.

    `of_yarn` is (256 ids, roughness and length of the rotation, least and largest): infinities
    where there is no texel. Texels that are not opaque are loose hairs or gaps, and `loose` counts
    those of them that are not rough all over.
    """

    def __init__(self) -> None:
        self.of_yarn = np.tile(np.array([np.inf, -np.inf]), (256, 2, 1))
        self._loose = np.zeros(1, np.int64)

    @property
    def loose(self) -> int:
        """Texels that are not opaque and have a lobe."""
        return int(self._loose[0])

    def add(self, ids: Bytes, opacity: Bytes, roughness: Bytes, rotation: Bytes) -> None:
        """Take the texels (rows, width, components) of a band."""
        _span(ids, opacity, roughness, rotation, self.of_yarn, self._loose)

    def seen(self) -> Doubles:
        """Return the spans of the yarns that have a texel, (yarns, 2, 2)."""
        return np.asarray(self.of_yarn[np.isfinite(self.of_yarn[:, ROUGHNESS, LOW])])


def directions(stored: Bytes) -> Doubles:
    """Return the rotation that texels of 8 bits stand for, from 0 for -1 to 255 for 1."""
    return np.asarray(stored / 127.5 - 1)


def narrow_alpha(roughness: Doubles, length: Doubles) -> Doubles:
    """Return α_b of lobes with these roughnesses and lengths of rotation."""
    ratio = (1 - np.minimum(length, 1)) / (1 + length)
    return np.asarray(roughness**2 * np.sqrt(2 / (1 + ratio**2)) * ratio)


def across_fibres(normal: Doubles, tangent: Doubles) -> tuple[Doubles, Doubles]:
    """Return (cos 2φ, sin 2φ) (…, 2) of what lies across fibres, and how surely, 0…1.

    `normal` and `tangent` are (…, 3). Across the fibre is n × t. Along X in the surface lies its
    component n_y t_z − n_z t_y, and beside that t_x.
    """
    along = normal[..., 1] * tangent[..., 2] - normal[..., 2] * tangent[..., 1]
    beside = tangent[..., 0]
    square = along**2 + beside**2
    safe = np.maximum(square, 1e-12)
    angle = np.stack([(along**2 - beside**2) / safe, 2 * along * beside / safe], axis=-1)
    return angle, square


@compiled
def _span(
    ids: Bytes,
    opacities: Bytes,
    roughness: Bytes,
    rotation: Bytes,
    spans: Doubles,
    loose: NDArray[np.int64],
) -> None:
    for row in range(ids.shape[0]):
        for column in range(ids.shape[1]):
            rough = float(roughness[row, column, 0])
            x = rotation[row, column, 0] - 127.5
            y = rotation[row, column, 1] - 127.5
            length = (x * x + y * y) ** 0.5
            if opacities[row, column, 0] != 255:
                loose[0] += rough != 255 or length > 1
                continue
            number = ids[row, column, 0]
            spans[number, 0, 0] = min(spans[number, 0, 0], rough)
            spans[number, 0, 1] = max(spans[number, 0, 1], rough)
            spans[number, 1, 0] = min(spans[number, 1, 0], length)
            spans[number, 1, 1] = max(spans[number, 1, 1], length)
