"""What texture files store, to the bit."""

from __future__ import annotations

import numpy as np

from weaveusd.contract import CHANNELS
from weaveusd.export.encode import encode
from weaveusd.yarn.color import decode_srgb

BORDERS = np.array([decode_srgb((k + 0.5) / 255) for k in range(255)], np.float32)


def codes(linear: np.ndarray) -> np.ndarray:
    return encode(CHANNELS["base_color"], ".png", linear)


def test_a_code_changes_exactly_at_its_border():
    before = np.nextafter(BORDERS, np.float32(-1))
    np.testing.assert_array_equal(codes(BORDERS), np.arange(1, 256))
    np.testing.assert_array_equal(codes(before), np.arange(255))


def test_codes_are_those_of_a_search_among_the_borders():
    rng = np.random.default_rng(1)
    linear = rng.uniform(0, 1.2, 100_000).astype(np.float32) ** 4
    linear = np.concatenate([linear, -linear[:100], [0, -0.0, 1e-45, np.inf]]).astype(np.float32)
    np.testing.assert_array_equal(codes(linear), np.searchsorted(BORDERS, linear, side="right"))


def test_levels_of_vectors_are_rounded_once_and_clipped():
    rng = np.random.default_rng(2)
    components = rng.uniform(-1.1, 1.1, (500, 4, 3)).astype(np.float32)
    levels = encode(CHANNELS["normal"], ".png", components)
    exact = np.clip(np.rint(components.astype(np.float64) * 32767) + 32767, 0, 65534)
    np.testing.assert_array_equal(levels, exact)


def test_what_is_turned_over_or_cut_out_is_encoded_in_its_own_order():
    rng = np.random.default_rng(3)
    values = rng.uniform(0, 1, (6, 5, 3)).astype(np.float32)
    for channel in ("base_color", "normal"):
        whole = encode(CHANNELS[channel], ".png", values)
        part = encode(CHANNELS[channel], ".png", values[::-1, 1:3])
        np.testing.assert_array_equal(part, whole[::-1, 1:3])
