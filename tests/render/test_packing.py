from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.render.cloths import plain_arrays
from weaveusd.render.packing import COMPONENTS, FRAME, pack


def turned(vectors: Any, packed: Any) -> Any:
    """The vectors (…, 3) after the rotation whose quaternion's vector part is packed."""
    v = packed[..., FRAME : FRAME + 3].astype(np.float64)
    real = np.sqrt(1 - np.sum(v * v, axis=-1, keepdims=True))
    once = np.cross(v, vectors) + real * vectors
    return vectors + 2 * np.cross(v, once)


def random_frames(size: int) -> dict[str, Any]:
    rng = np.random.default_rng(5)
    arrays = plain_arrays(size=size)
    arrays["normal"] = unit(rng.normal(size=(size, size, 3)))
    tangent = rng.normal(size=(size, size, 3))
    along = np.sum(tangent * arrays["normal"], axis=-1, keepdims=True)
    arrays["tangent"] = unit(tangent - along * arrays["normal"])
    return arrays


def unit(vectors: Any) -> Any:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.mark.parametrize(("dtype", "degrees"), [("float32", 1e-4), ("float16", 0.06)])
def test_a_packed_frame_is_the_yarns_or_its_reversal(dtype: str, degrees: float) -> None:
    arrays = random_frames(64)
    packed, mended = pack(arrays, 1, np.dtype(dtype).type)
    assert packed.dtype == dtype
    assert packed.shape == (64, 64, COMPONENTS)
    assert mended == 0
    # A quaternion with a real part of a half or more is well told from the other three numbers.
    assert np.sum(np.square(packed[..., FRAME : FRAME + 3], dtype=np.float64), -1).max() <= 0.7501
    for name, axis in (("normal", (0, 0, 1)), ("tangent", (0, 1, 0))):
        found = turned(np.broadcast_to(np.array(axis, float), (64, 64, 3)), packed)
        sine = np.linalg.norm(np.cross(found, arrays[name]), axis=-1)
        assert np.degrees(np.arcsin(sine.max())) < degrees


def test_packing_mends_vectors_and_counts_them() -> None:
    arrays = plain_arrays(size=2)
    arrays["normal"][0, 0] = 0
    arrays["tangent"][0, 1] = (0, 0, 1)
    arrays["normal"][1, 0] *= 3
    packed, mended = pack(arrays, 1)
    assert mended == 2
    # Mended texels have the cloth's own frame, a longer normal is the same normal.
    np.testing.assert_allclose(packed[..., FRAME : FRAME + 3], 0, atol=1e-6)


def test_a_color_beyond_half_floats_is_refused() -> None:
    arrays = plain_arrays()
    arrays["base_color"][...] = 1e5
    with pytest.raises(ValueError, match="base_color: leaves the range of a reflectance"):
        pack(arrays, 1, np.float16)
