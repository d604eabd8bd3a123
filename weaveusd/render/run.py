"""Render a stage with Mitsuba: `render` is what `weaveusd.render` answers calls with."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from weaveusd import contract
from weaveusd.errors import InputError
from weaveusd.render.model import AUTO, FULL, MAX_LEVELS, Lod, RenderResult
from weaveusd.render.variant import prepare

__all__ = ["MAX_PIXELS", "RenderResult", "render"]

MAX_PIXELS = 16384
"""Pixels along a side of a picture."""

PURPOSES = ("render", "proxy", "guide")
"""What can be drawn beside the purpose `default`."""


def render(
    stage: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    camera: str | None = None,
    width: int = 768,
    height: int | None = None,
    spp: int = 64,
    seed: int = 0,
    context: str = contract.MITSUBA_CONTEXT,
    frame: float | None = None,
    purposes: Sequence[str] = ("render",),
    lod: Lod = FULL,
    variant: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> RenderResult:
    """Render the USD file `stage`, and write the picture where `output` says.

    Parameters
    ----------
    stage
        Path of a .usda, .usdc, .usd or .usdz file.
    output
        `.exr` for linear half floats, `.png` for 8-bit sRGB; nothing is written for None.
    camera
        Path of a camera prim; by default the stage's first one.
    width, height
        Pixels; without a height it follows from the camera's aperture.
    spp
        Paths of light for each pixel.
    seed
        The same seed gives the same picture, to the byte, on one kind of machine.
    context
        `mitsuba` for the exact cloth, `mtlx` or `openpbr` for MaterialX networks, `preview` for
        UsdPreviewSurface; what a material lacks is looked for in the next of these.
    frame
        Time code of the picture; by default the earliest one.
    purposes
        What is drawn beside the purpose `default`: any of `render`, `proxy` and `guide`.
    lod
        Detail of exact cloths. `full` shows every texel. `auto` shows cloth whose yarns are
        smaller than pixels by what they do together, which is far less noisy and within a few
        percent of their mean (docs/lod.md). A number is a level to use everywhere: 0 has cells of
        a quarter of a crossing, each next one twice as large.
    variant
        `cuda_ad_rgb`, `llvm_ad_rgb` or `scalar_rgb`; by default the fastest that works.
    progress
        Called with the share that is done, 0 to 1, after every pass.

    Raises
    ------
    InputError
        For an output that cannot be written, a number out of range, an unknown context or purpose.
    StageError
        When the stage cannot be opened, or its camera or a cloth in it is broken.
    RendererUnavailableError
        When nothing on this machine can render; the message says what to install.
    """
    begin = time.perf_counter()
    target = None if output is None else Path(output)
    _check_numbers(width, height, spp, seed)
    _check_view(frame, purposes)
    _check_lod(lod)
    if target is not None:
        # The folder is looked at before minutes are spent.
        from weaveusd.render.pictures import check_output

        check_output(target)
    # Opened before a renderer is looked for: a broken stage is the user's first concern.
    from weaveusd.stage import open_stage

    opened = open_stage(stage)
    active = prepare(variant)

    from pxr import Usd

    from weaveusd.render.cameras import aspect_of, find_camera
    from weaveusd.render.trace import trace
    from weaveusd.render.translate import translate

    if height is None:
        moment = Usd.TimeCode.EarliestTime() if frame is None else Usd.TimeCode(frame)
        aspect = aspect_of(find_camera(opened, camera), moment)
        height = min(max(round(width / aspect), 1), MAX_PIXELS)
    translation = translate(
        opened, width=width, height=height, camera=camera, context=context, frame=frame,
        purposes=tuple(purposes), lod=lod,
    )  # fmt: skip
    image = trace(translation.scene, (width, height), spp, seed, progress)
    if translation.exposure != 1:
        image = image * np.float32(translation.exposure)
        image.flags.writeable = False
    if target is not None:
        from weaveusd.render.pictures import write_picture

        write_picture(target, image)
    return RenderResult(
        image=image,
        output=target,
        losses=translation.losses,
        seconds=time.perf_counter() - begin,
        variant=active,
        width=width,
        height=height,
        spp=spp,
    )


def _check_view(frame: float | None, purposes: Sequence[str]) -> None:
    if frame is not None and not abs(frame) < 1e15:
        raise InputError(f"frame is {frame}, expected a time code")
    for purpose in purposes:
        if purpose not in PURPOSES:
            raise InputError(f"unknown purpose '{purpose}': expected {', '.join(PURPOSES)}")


def _check_lod(lod: Lod) -> None:
    if lod not in (AUTO, FULL) and not (isinstance(lod, int) and 0 <= lod < MAX_LEVELS):
        raise InputError(f"lod is {lod!r}, expected auto, full or 0 to {MAX_LEVELS - 1}")


def _check_numbers(width: int, height: int | None, spp: int, seed: int) -> None:
    for name, value in (("width", width), ("height", height)):
        if value is not None and not 1 <= value <= MAX_PIXELS:
            raise InputError(f"{name} is {value}, expected 1 to {MAX_PIXELS} pixels")
    if not 1 <= spp <= 1 << 20:
        raise InputError(f"spp is {spp}, expected 1 to {1 << 20} samples a pixel")
    if not 0 <= seed < 1 << 32:
        raise InputError(f"seed is {seed}, expected 0 to {(1 << 32) - 1}")
