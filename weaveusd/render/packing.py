"""One array of eight numbers a texel: all that the BSDF looks up, fetched at once.

A yarn's frame is a rotation, so three numbers hold it: the vector part of the unit quaternion that
turns X, Y and Z to t × n, the tangent t and the normal n. A yarn looks the same with n, t or both
reversed. Of these four frames the one nearest to the cloth's is stored: its quaternion's real
part is at least ½, and so follows from the other three.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd import contract

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats32 = NDArray[np.float32]
    Packed = NDArray[np.floating[Any]]

FRAME, COLOR, OPACITY, YARN = 0, 3, 6, 7
"""First component of the quaternion's vector part and of each channel in the packed array."""

COMPONENTS = 8

PACKED_CHANNELS = ("normal", "tangent", "base_color", "opacity", "yarn_id")

_ROWS = 256
_SHORTEST = 1e-3
_BRIGHTEST = float(np.finfo(np.float16).max)
_UNIT_X = np.array((1.0, 0.0, 0.0), np.float32)
_UNIT_Y = np.array((0.0, 1.0, 0.0), np.float32)
_UNIT_Z = np.array((0.0, 0.0, 1.0), np.float32)
_REVERSALS = np.array(((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)), np.float32)


def pack(
    arrays: Mapping[str, NDArray[Any]], yarns: int, dtype: type[np.floating[Any]] = np.float32
) -> tuple[Packed, int]:
    """Return the packed channels and how many texels of yarn had to be mended.

    Parameters
    ----------
    arrays
        Channel name to (H, W, components) or, with one component, (H, W); row 0 at v = 0.
        `yarn_id` is the yarn's index, `contract.GAP` where there is none.
    yarns
        Number of yarns that the indices may name.
    dtype
        float32, or float16 for files that hold no more: half the memory, frames within 0.03°.

    Returns
    -------
    packed : (H, W, 8) of `dtype`
        Texels without a yarn have opacity 0, whatever the opacity channel says.
    mended : int
        Texels with a yarn whose vectors were too short or too parallel to be normalized.

    Raises
    ------
    ValueError
        When a channel is missing, has another shape or holds what it cannot mean; the message
        is one line and names the channel.
    """
    shaped = {name: _shaped(name, arrays) for name in PACKED_CHANNELS}
    height, width = shaped["normal"].shape[:2]
    for name, array in shaped.items():
        if array.shape[:2] != (height, width):
            raise ValueError(
                f"{name}: is {array.shape[1]} x {array.shape[0]} texels, "
                f"expected {width} x {height} as the normals"
            )
    packed: Packed = np.zeros((height, width, COMPONENTS), dtype)
    mended = 0
    for first in range(0, height, _ROWS):
        rows = slice(first, first + _ROWS)
        mended += _pack_rows({k: v[rows] for k, v in shaped.items()}, yarns, packed[rows])
    return packed, mended


def _pack_rows(band: Mapping[str, NDArray[Any]], yarns: int, out: Packed) -> int:
    """Fill `out` with one band of rows; return the number of texels mended."""
    for name, array in band.items():
        if not np.isfinite(array).all():
            raise ValueError(f"{name}: holds a value that is no finite number")
    yarn = np.rint(band["yarn_id"][..., 0])
    if yarn.min() < contract.GAP or yarn.max() >= yarns:
        found = int(yarn.max() if yarn.max() >= yarns else yarn.min())
        raise ValueError(f"yarn_id: names yarn {found}, but the shader describes {yarns}")
    color, opacity = band["base_color"], band["opacity"][..., 0]
    too_bright = color.min() < 0 or color.max() > _BRIGHTEST
    if too_bright or opacity.min() < 0 or opacity.max() > 1:
        name = "base_color" if too_bright else "opacity"
        raise ValueError(f"{name}: leaves the range of a reflectance or a coverage")

    gap = yarn < 0
    normal, bad_normal = _unit(band["normal"], _UNIT_Z)
    tangent = band["tangent"] - normal * np.sum(
        normal * band["tangent"], axis=-1, keepdims=True, dtype=np.float32
    )
    tangent, bad_tangent = _unit(tangent, _UNIT_Y)
    if bad_tangent.any():
        # Any direction in the tangent plane, through the axis that is farthest from the normal.
        steep = np.abs(normal[..., 1:2]) > 0.9
        axis = np.where(steep, _UNIT_X, _UNIT_Y)
        spare, _ = _unit(axis - normal * np.sum(normal * axis, -1, keepdims=True), _UNIT_X)
        tangent = np.where(bad_tangent[..., None], spare, tangent)

    out[..., FRAME : FRAME + 3] = _quaternion(normal, tangent)
    out[..., COLOR : COLOR + 3] = color
    out[..., OPACITY] = np.where(gap, 0, opacity)
    out[..., YARN] = np.where(gap, 0, yarn)
    return int(np.count_nonzero((bad_normal | bad_tangent) & ~gap))


def _quaternion(normal: Floats32, tangent: Floats32) -> Floats32:
    """Return the vector part (…, 3) of the frame's quaternion, one reversal chosen of four."""
    frame = np.stack((np.cross(tangent, normal), tangent, normal), axis=-2)
    diagonal = np.diagonal(frame, axis1=-2, axis2=-1)
    traces = diagonal @ _REVERSALS.T
    nearest = np.argmax(traces, axis=-1)
    frame = frame * _REVERSALS[nearest][..., None]
    twice_real = np.sqrt(1 + np.max(traces, axis=-1))
    x, y, z = frame[..., 0, :], frame[..., 1, :], frame[..., 2, :]
    turn = np.stack((y[..., 2] - z[..., 1], z[..., 0] - x[..., 2], x[..., 1] - y[..., 0]), axis=-1)
    vector: Floats32 = turn / (2 * twice_real[..., None])
    return vector


def _unit(vectors: NDArray[Any], instead: Floats32) -> tuple[Floats32, NDArray[np.bool_]]:
    """Return unit vectors, and where they were too short and replaced."""
    vectors = np.asarray(vectors, np.float32)
    length = np.sqrt(np.sum(np.square(vectors), axis=-1, keepdims=True))
    bad = length < _SHORTEST
    unit = np.where(bad, instead, vectors / np.where(bad, 1, length))
    return unit.astype(np.float32), bad[..., 0]


def _shaped(name: str, arrays: Mapping[str, NDArray[Any]]) -> NDArray[Any]:
    """Return the channel as (H, W, components)."""
    if name not in arrays:
        raise ValueError(f"{name}: is missing, expected the channels {', '.join(PACKED_CHANNELS)}")
    array = np.asarray(arrays[name])
    components = contract.CHANNELS[name].components
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or array.shape[2] != components or 0 in array.shape:
        raise ValueError(f"{name}: has shape {array.shape}, expected (H, W, {components})")
    return array
