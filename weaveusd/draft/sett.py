"""The sett of a tartan: stripes of color, as weavers write them down."""

from __future__ import annotations

import re

RGB8 = tuple[int, int, int]

_PLAIN: dict[str, RGB8] = {
    "K": (16, 16, 16),
    "W": (236, 234, 226),
    "N": (128, 128, 128),
    "R": (184, 24, 30),
    "G": (20, 92, 44),
    "B": (34, 52, 116),
    "A": (92, 140, 182),
    "Y": (226, 182, 28),
    "O": (206, 96, 24),
    "T": (98, 62, 34),
    "P": (98, 40, 96),
}

TARTAN_COLORS: dict[str, RGB8] = {
    **_PLAIN,
    **{f"D{k}": (r * 5 // 9, g * 5 // 9, b * 5 // 9) for k, (r, g, b) in _PLAIN.items()},
    **{
        f"L{k}": ((r + 255) // 2, (g + 255) // 2, (b + 255) // 2) for k, (r, g, b) in _PLAIN.items()
    },
}
"""Black, white, grey (N), red, green, blue, azure, yellow, orange, tan and purple, each also
dark (D) and light (L), as display sRGB in 0…255. A register names colors, not values: these are
ours."""

_STRIPE = re.compile(r"([DL]?[A-Z])(/?)([0-9]{1,4})")


def parse_sett(text: str) -> list[tuple[str, int]]:
    """Return the stripes of one repeat as color and number of threads.

    A stripe is a letter of `TARTAN_COLORS` and a count: `K4 R24 G2`. With a slash in the first
    and the last stripe, `K/4 R24 G/2`, these two are pivots: the sett is read back from the
    last to the first, each pivot being woven once in full.

    Raises
    ------
    ValueError
        When a stripe is not of that form, its color unknown or its count 0, or when one pivot
        or a middle stripe has a slash.
    """
    stripes: list[tuple[str, int]] = []
    slashes: list[bool] = []
    for part in text.upper().replace(",", " ").split():
        match = _STRIPE.fullmatch(part)
        if match is None or match[1] not in TARTAN_COLORS or int(match[3]) == 0:
            raise ValueError(f"stripe {part[:20]!r}")
        stripes.append((match[1], int(match[3])))
        slashes.append(bool(match[2]))
    if not stripes:
        raise ValueError("no stripe")
    if not any(slashes):
        return stripes
    if len(stripes) < 2 or not (slashes[0] and slashes[-1]) or any(slashes[1:-1]):
        raise ValueError("slashes elsewhere than in the first and the last stripe")
    return stripes + stripes[-2:0:-1]
