"""Channels that follow from others, texel by texel."""

from __future__ import annotations

from weaveusd.synth.compiled import compiled


@compiled
def fill_derived(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    tangent, yarn_id, system_of_yarn, system, fibre_angle
):
    """Fill `system` from `yarn_id` and `fibre_angle` from `tangent`, all (rows, width, components).

    `system_of_yarn` holds 0 for warp and 1 for weft. The angle φ of the fibre to x is stored as
    cos 2φ and sin 2φ; of a fibre that stands upright as 1 and 0.
    """
    for k in range(tangent.shape[0]):
        for i in range(tangent.shape[1]):
            yarn = int(yarn_id[k, i, 0])
            system[k, i, 0] = system_of_yarn[yarn] if yarn >= 0 else -1
        for i in range(tangent.shape[1]):
            x, y = tangent[k, i, 0], tangent[k, i, 1]
            flat = x * x + y * y
            scale = 1.0 / flat if flat > 0.0 else 0.0
            fibre_angle[k, i, 0] = (x * x - y * y) * scale if flat > 0.0 else 1.0
            fibre_angle[k, i, 1] = 2.0 * x * y * scale
