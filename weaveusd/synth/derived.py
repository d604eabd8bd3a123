"""Channels that follow from others, texel by texel."""

from __future__ import annotations

from weaveusd.synth.compiled import compiled


@compiled
def fill_derived(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    tangent, yarn_id, system_of_yarn, system, fibre_angle
):
    """Fill `system` from `yarn_id` and `fibre_angle` from `tangent`.

    All are (rows, width × components); `system_of_yarn` holds 0 for warp and 1 for weft. The
    angle φ of the fibre to x is stored as cos 2φ and sin 2φ; of a fibre that stands upright as 1
    and 0.
    """
    rows, width = system.shape
    for k in range(rows):
        for i in range(width):
            yarn = int(yarn_id[k, i])
            system[k, i] = system_of_yarn[yarn] if yarn >= 0 else -1
        for i in range(width):
            x, y = tangent[k, 3 * i], tangent[k, 3 * i + 1]
            flat = x * x + y * y
            scale = 1.0 / flat if flat > 0.0 else 0.0
            fibre_angle[k, 2 * i] = (x * x - y * y) * scale if flat > 0.0 else 1.0
            fibre_angle[k, 2 * i + 1] = 2.0 * x * y * scale
