"""Reflectance spectra: the CSV that a spectrophotometer's software exports."""

from __future__ import annotations

import math
from pathlib import Path, PurePosixPath

from weaveusd.errors import RecipeError
from weaveusd.yarn.toml import read_text, shown

MAX_BYTES = 1 << 16
RANGE_NM = (380.0, 730.0)
"""Wavelengths that a spectrum has to cover."""
LIMITS_NM = (300.0, 1100.0)
MAX_STEP_NM = 20.0


def read_reflectance(
    folder: Path, name: str, place: str
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return wavelengths in nm and reflectances 0…1 of the CSV `name` in `folder`.

    A row is ``wavelength, reflectance``; blank rows, rows that begin with ``#`` and one row of
    headings above the numbers are passed over. Wavelengths rise in equal steps of at most
    `MAX_STEP_NM` and cover `RANGE_NM`.

    Raises RecipeError, which begins with `place` where the name is at fault and with file and
    line where the rows are.
    """
    path = _inside(folder, name, place)
    file = folder / name
    text = read_text(path, MAX_BYTES, f"{place}: {name}", "utf-8-sig")
    rows: list[tuple[float, float]] = []
    headings = 0
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        row = _numbers(line)
        if row is None and not rows and not headings:
            headings += 1
            continue
        at = f"{file}:{number}"
        if row is None:
            expected = "expected a wavelength in nm and a reflectance"
            raise RecipeError(f"{at}: found {shown(line)}, {expected}")
        rows.append(_checked(row, rows, at))
    low, high = RANGE_NM
    if not rows or rows[0][0] > low or rows[-1][0] < high:
        found = f"{rows[0][0]:g} to {rows[-1][0]:g} nm" if rows else "no rows"
        raise RecipeError(f"{file}: found {found}, expected at least {low:g} to {high:g} nm")
    return tuple(nm for nm, _ in rows), tuple(r for _, r in rows)


def _inside(folder: Path, name: str, place: str) -> Path:
    """Return the regular file `name` below `folder`; links that lead out of it are refused."""
    parts = PurePosixPath(name)
    expected = f"expected a file beside the recipe or below, found {shown(name)}"
    if not name or "\\" in name or ":" in name or parts.is_absolute() or ".." in parts.parts:
        raise RecipeError(f"{place}: {expected}")
    root = folder.resolve()
    try:
        path = (root / parts).resolve()
        regular = path.is_file()
    except (OSError, RuntimeError) as error:  # links in a circle, names too long
        raise RecipeError(f"{place}: {expected}") from error
    if not path.is_relative_to(root):
        raise RecipeError(f"{place}: {expected}")
    if not regular:
        raise RecipeError(f"{place}: no such file: {name}")
    return path


def _numbers(line: str) -> tuple[float, float] | None:
    cells = line.replace(";", ",").replace("\t", ",").split(",")
    try:
        nm, reflectance = (float(cell) for cell in cells)
    except ValueError:
        return None
    return nm, reflectance


def _checked(
    row: tuple[float, float], before: list[tuple[float, float]], at: str
) -> tuple[float, float]:
    nm, reflectance = row
    low, high = LIMITS_NM
    if not low <= nm <= high:
        raise RecipeError(f"{at}: found {nm:g} nm, expected {low:g} to {high:g} nm")
    if not 0 <= reflectance <= 1:
        raise RecipeError(f"{at}: found a reflectance of {reflectance:g}, expected 0 to 1")
    if before:
        step = nm - before[-1][0]
        if not 0 < step <= MAX_STEP_NM:
            expected = f"above 0 and at most {MAX_STEP_NM:g} nm"
            raise RecipeError(f"{at}: found a step of {step:g} nm, expected one {expected}")
        if len(before) > 1 and not math.isclose(step, before[1][0] - before[0][0], abs_tol=1e-6):
            expected = f"{before[1][0] - before[0][0]:g} nm as above"
            raise RecipeError(f"{at}: found a step of {step:g} nm, expected {expected}")
    return row
