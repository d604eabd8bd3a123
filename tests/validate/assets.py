"""A small good asset, published by the real exporter from a surface made by formula.

Every yarn is a convex cap, parabolic along and across, so that heights, normals and tangents
agree exactly. Each cell of the drawdown is `CELL` texels wide and high.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from weaveusd.cloth.model import Floats, Weave
from weaveusd.contract import GAP
from weaveusd.export.asset import write_asset
from weaveusd.export.manifest import list_files, write_manifest
from weaveusd.shading.material import (
    ClothMaterial,
    FitErrors,
    FitsAfar,
    Provenance,
    StandardFit,
    StandardFits,
)
from weaveusd.shading.measured import Measured
from weaveusd.shading.normalization import normalization
from weaveusd.synth.model import Band, TextureSet
from weaveusd.yarn.model import RGB, Optics, System, Yarn

Bools = NDArray[np.bool_]
Doubles = NDArray[np.float64]
Channels = dict[str, NDArray[np.float32]]

CELL = 16
PITCH_MM = 0.5
ALONG, ACROSS = 0.4, 2.0  # curvature in 1/mm
HALF_WIDTH_MM = 0.22
TWIST = 0.2

PROVENANCE = Provenance(
    draft_title="Shot twill",
    draft_sha256="0" * 64,
    draft_wif=b"[WIF]\nVersion=1.1\n",  # of no weave: `cloth` gives it its own
    shafts=4,
    recipe="linen",
    recipe_source="made by hand",
    tool_version="0.1.0",
)

PLAIN = np.array([[1, 0], [0, 1]], dtype=bool)
TWILL = np.array([[(c - r) % 4 < 2 for c in range(4)] for r in range(4)])
SATIN = np.array([[(2 * r - c) % 5 != 0 for c in range(5)] for r in range(5)])


OPTICS = Optics(eta=1.54, k_d=0.3, k_s=1.0, gamma_s=0.21, gamma_v=0.42, tau=0.0)
NORMALIZATION = normalization(1.54, 0.3, 1.0, 0.21, 0.42)
GAIN = 1.3259  # what `weaveusd.shading.measured` finds for either yarn of the twill


def yarn(name: str, system: System, color: RGB) -> Yarn:
    return Yarn(
        name=name,
        system=system,
        fibre="linen",
        tex=66.0,
        plies=1,
        twist_per_m=500.0,
        twist_direction="S",
        packing=0.6,
        width_mm=2 * HALF_WIDTH_MM,
        height_mm=0.25,
        twist_angle=TWIST,
        twist_deviation=0.05,
        twist_correlation_mm=1.0,
        spine="circle",
        kappa=0.0,
        color=color,
        optics=OPTICS,
    )


FIT = StandardFit(alpha_along=0.2, alpha_across=0.8, f0=0.045)
ROUND = StandardFit(0.4, 0.4, 0.045)
FITS = StandardFits(
    FIT, (FIT, FIT), ROUND, (ROUND, ROUND), FitsAfar(FIT, "warp", ROUND),
    FitErrors(0.2, 0.25, 0.4, 0.3, 0.4),
)  # fmt: skip


def drawn(warp_up: Bools) -> bytes:
    """Return a draft of `warp_up`: one shaft for each end, one row of the liftplan a pick."""
    picks, ends = warp_up.shape
    lines = ["[WIF]", "Version=1.1", "[WEAVING]", f"Shafts={ends}", "Rising Shed=true"]
    lines += ["[WARP]", f"Threads={ends}", "[WEFT]", f"Threads={picks}", "[THREADING]"]
    lines += [f"{end}={end}" for end in range(1, ends + 1)]
    lines.append("[LIFTPLAN]")
    for pick, row in enumerate(warp_up, start=1):
        lines.append(f"{pick}=" + (",".join(str(k + 1) for k in np.flatnonzero(row)) or "0"))
    return "\n".join([*lines, ""]).encode()


def surface(
    warp_up: Bools, colors: tuple[RGB, RGB], cell: int = CELL, *, cyclic: bool = True
) -> Channels:
    """Return the channels of the cloth `warp_up`, row 0 at y = 0; floats cut if not `cyclic`."""
    picks, ends = warp_up.shape
    step = PITCH_MM / cell
    y, x = np.mgrid[0 : picks * cell, 0 : ends * cell].astype(float) * step + step / 2
    row, column = (y / PITCH_MM).astype(int), (x / PITCH_MM).astype(int)
    top = warp_up[row, column]

    along_warp = y - float_centers(warp_up, cyclic)[row, column]
    along_weft = x - float_centers(~warp_up.T, cyclic).T[row, column]
    # A thread that is always on top lies straight.
    along = np.nan_to_num(np.where(top, along_warp, along_weft))
    across = np.where(top, x - (column + 0.5) * PITCH_MM, y - (row + 0.5) * PITCH_MM)
    height = -0.5 * (ALONG * along**2 + ACROSS * across**2)
    slope_along, slope_across = -ALONG * along, -ACROSS * across

    def cloth_frame(along: Doubles, across: Doubles, up: Doubles) -> Doubles:
        vector = np.where(
            top[..., None], np.stack([across, along, up], -1), np.stack([along, across, up], -1)
        )
        return vector / np.linalg.norm(vector, axis=-1, keepdims=True)

    one = np.ones_like(height)
    normal = cloth_frame(-slope_along, -slope_across, one)
    straight = cloth_frame(one, 0 * one, slope_along)
    tangent = np.cos(TWIST) * straight + np.sin(TWIST) * np.cross(normal, straight)

    gap = np.abs(across) > HALF_WIDTH_MM
    normal[gap], tangent[gap], height[gap] = (0, 0, 1), (1, 0, 0), -0.4
    index = np.where(top, 0, 1)
    values = {
        "base_color": np.where(gap[..., None], 0.0, np.asarray(colors)[index]),
        "normal": normal,
        "tangent": tangent,
        "height": height[..., None],
        "opacity": np.where(gap, 0.0, 1.0)[..., None],
        "yarn_id": np.where(gap, GAP, index)[..., None],
        "system": np.where(gap, GAP, index)[..., None],
        "fibre_angle": double_angle(tangent),
        "ambient_occlusion": 1 - across[..., None] ** 2,
    }
    return {name: value.astype(np.float32) for name, value in values.items()}


def double_angle(tangent: Doubles) -> Doubles:
    """Return cos 2φ and sin 2φ (…, 2) of the angle φ of `tangent` (…, 3) to X."""
    x, y = tangent[..., 0], tangent[..., 1]
    return np.stack([x * x - y * y, 2 * x * y], -1) / (x * x + y * y)[..., None]


def float_centers(up: Bools, cyclic: bool = True) -> Doubles:
    """Return the middle of the float on each crossing, down the columns, in mm; NaN for endless."""
    length = len(up)
    centers = np.zeros(up.shape)
    for (row, column), is_up in np.ndenumerate(up):
        if is_up and not up[:, column].all():
            first, last = row, row
            while (cyclic or first > 0) and up[(first - 1) % length, column]:
                first -= 1
            while (cyclic or last + 1 < length) and up[(last + 1) % length, column]:
                last += 1
            centers[row, column] = (first + last + 1) / 2 * PITCH_MM
        elif is_up:
            centers[row, column] = np.nan
    return centers


def one_float(crossings: tuple[int, ...]) -> Floats:
    """Return a single float over two crossings: the exporter's figures need no more."""
    zero, length = np.zeros(1, np.int32), np.full(1, 2 * PITCH_MM)
    return Floats(
        thread=zero,
        start=zero,
        count=zero + 2,
        length_mm=length,
        center_mm=length / 2,
        bend_mm=length / 2,
        u_max=np.full(1, 0.4),
        at=np.full(crossings, -1, np.int32),
    )


def cloth(
    warp_up: Bools = TWILL,
    *,
    cell: int = CELL,
    change: Callable[[Channels], None] | None = None,
) -> ClothMaterial:
    """Return the material of `warp_up`; `change` may spoil its channels, row 0 at y = 0."""
    yarns = yarn("ecru", "warp", (0.6, 0.5, 0.4)), yarn("indigo", "weft", (0.05, 0.06, 0.2))
    channels = surface(warp_up, (yarns[0].color, yarns[1].color), cell)
    if change is not None:
        change(channels)

    def band(first: int, last: int) -> Band:
        return {name: values[first:last] for name, values in channels.items()}

    picks, ends = warp_up.shape
    height, width = channels["height"].shape[:2]
    repeat_mm = ends * PITCH_MM, picks * PITCH_MM
    weave = Weave(
        warp_up=warp_up,
        yarns=yarns,
        warp_yarn=np.zeros(ends, np.int32),
        weft_yarn=np.ones(picks, np.int32),
        warp_edge_mm=np.arange(ends + 1) * PITCH_MM,
        weft_edge_mm=np.arange(picks + 1) * PITCH_MM,
        warp_width_mm=np.full(ends, 2 * HALF_WIDTH_MM),
        weft_width_mm=np.full(picks, 2 * HALF_WIDTH_MM),
        warp_height_mm=np.full(ends, 0.25),
        weft_height_mm=np.full(picks, 0.25),
        warp_floats=one_float(warp_up.shape),
        weft_floats=one_float(warp_up.shape),
        crimp_balance=0.5,
    )
    return ClothMaterial(
        name="shot_twill",
        weave=weave,
        textures=TextureSet(width, height, repeat_mm, 7, band),
        normalization=(NORMALIZATION, NORMALIZATION),
        measured=tuple(Measured(GAIN, yarn.color) for yarn in yarns),
        fits=FITS,
        provenance=replace(PROVENANCE, draft_wif=drawn(warp_up)),
    )


def publish(folder: Path, material: ClothMaterial | None = None) -> Path:
    """Write an asset with its manifest into the new `folder` and return its entry layer."""
    folder.mkdir(parents=True)
    entry = write_asset(material or cloth(), folder)
    write_manifest(folder, "shot_twill", list_files(folder))
    return entry
