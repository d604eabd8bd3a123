"""Draw the figures of some presets into a folder."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from weaveusd.proof.curves import Form
from weaveusd.proof.subjects import Subject, inclinations, subjects

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from weaveusd.proof.sheet import Format

ANGLES = (0.0, 30.0, 60.0)
"""Angles of the viewer to the normal, in degrees."""


def draw(
    presets: Sequence[str],
    folder: str | os.PathLike[str],
    *,
    formats: tuple[Format, ...] = ("png",),
    forms: Sequence[Form] = (Form(),),
    angles_deg: Sequence[float] = ANGLES,
) -> tuple[Path, ...]:
    """Write the figures of every yarn of `presets`; return the files, in order.

    Each way to scatter has its components (the forms together) and its hemispheres (one file a
    form); more than one stand side by side, and two forms against each other.

    Raises
    ------
    InputError
        A preset is none, or an angle is beyond ±89.9°.
    WeaveusdError
        A file cannot be written.
    """
    found, angles = subjects(presets), inclinations(angles_deg)
    from weaveusd.proof import sheet

    files: list[Path] = []
    with sheet.style():
        for name, figure in _figures(found, tuple(forms), angles):
            files += sheet.write(figure(), Path(folder), name, formats)
    return tuple(files)


def _figures(
    found: Sequence[Subject], forms: tuple[Form, ...], angles: tuple[float, ...]
) -> Iterator[tuple[str, Callable[[], Figure]]]:
    """Yield the name of each figure and the function that draws it."""
    from weaveusd.proof import figures

    suffix = "_published" if forms[0].published else ""
    kinds = [(form, "_gaussian" if form.gaussian else "") for form in forms]
    for subject in found:
        name = _slug(subject.yarns[0]) + suffix
        yield f"{name}_components", partial(figures.components, subject, forms, angles)
        for form, kind in kinds:
            yield f"{name}_cone{kind}", partial(figures.cone, subject, form, angles)
    for form, kind in kinds if len(found) > 1 else ():
        yield (
            f"side_by_side{suffix}{kind}",
            partial(figures.side_by_side, found, form, angles),
        )
    if len(forms) > 1:
        yield (
            f"gaussian_against_cauchy{suffix}",
            partial(
                figures.gaussian_against_cauchy,
                found,
                angles[len(angles) // 2],
                published=forms[0].published,
            ),
        )


def _slug(yarn: str) -> str:
    """Return the name of a file for preset/yarn, the name once where both are alike."""
    preset, own = yarn.split("/")
    return re.sub(r"[^A-Za-z0-9_-]", "_", preset if preset == own else f"{preset}_{own}")
