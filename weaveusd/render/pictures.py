"""Finished pictures as files: written whole or not at all, the same bytes every time."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.errors import InputError
from weaveusd.render.textures import to_srgb

if TYPE_CHECKING:
    from numpy.typing import NDArray

SUFFIXES = (".exr", ".png")
_DATE = "1980:01:01 00:00:00"


def check_output(output: Path) -> None:
    """Raise `InputError` unless a picture can be written there; nothing is written."""
    if output.suffix.lower() not in SUFFIXES:
        raise InputError(f"{output}: ends in '{output.suffix}', expected {' or '.join(SUFFIXES)}")
    if not output.parent.is_dir():
        raise InputError(f"{output}: the folder {output.parent} does not exist")
    if output.is_dir():
        raise InputError(f"{output}: is a folder, expected the name of a picture")


def write_picture(output: Path, image: NDArray[np.float32]) -> None:
    """Write linear pixels (H, W, 3), row 0 at the top, as the suffix of `output` says.

    An .exr holds them as half floats; a .png as 8-bit sRGB, clipped, no exposure applied. The
    file appears under its name when it is complete.

    Raises
    ------
    InputError
        When the file cannot be written.
    """
    check_output(output)
    suffix = output.suffix.lower()
    height, width, channels = image.shape
    if suffix == ".exr":
        stored = np.clip(image, -65504, 65504).astype(np.float32)
        spec = oiio.ImageSpec(width, height, channels, oiio.HALF)
        spec.attribute("compression", "zip")
        spec.attribute("DateTime", _DATE)
        spec.attribute("oiio:ColorSpace", "lin_rec709_scene")
    else:
        stored = np.rint(to_srgb(image) * 255).astype(np.uint8)
        spec = oiio.ImageSpec(width, height, channels, oiio.UINT8)
        spec.attribute("oiio:ColorSpace", "srgb_rec709_scene")
    handle, part = tempfile.mkstemp(
        suffix=suffix, prefix=f".{output.stem[:64]}-", dir=output.parent
    )
    os.close(handle)
    try:
        _write(part, spec, np.ascontiguousarray(stored), output)
        # mkstemp makes files for their owner alone; a picture gets the rights of any new file.
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(part, 0o666 & ~mask)
        os.replace(part, output)
    except OSError as error:
        raise InputError(f"{output}: cannot be written: {error.strerror}") from None
    finally:
        if os.path.exists(part):
            os.unlink(part)


def _write(part: str, spec: Any, stored: NDArray[Any], output: Path) -> None:
    writer = oiio.ImageOutput.create(part)
    done = writer is not None and writer.open(part, spec) and writer.write_image(stored)
    if writer is not None:
        done = writer.close() and done
    if not done:
        reason = " ".join(str(oiio.geterror()).split()) or "unknown reason"
        raise InputError(f"{output}: cannot be written: {reason}")
