"""Profiles: which checks run, how much they render and what they let pass, as data.

A profile is a TOML file. Three come with weaveusd; a package adds its own by an entry point of
the group `weaveusd.profiles` that leads to the path of such a file, and anybody by naming one.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from weaveusd.errors import InputError
from weaveusd.validate.tables import known_keys, read_toml

GROUP = "weaveusd.profiles"
DEFAULT = "quick"
ALL = "all"

OURS = ("quick", "standard", "full")
"""Profiles that come with weaveusd, each running what the one before it runs."""

_FOLDER = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class Profile:
    """What is judged and how closely.

    `checks` and `without` are ids of checks, the part of them before the slash, or `all`.
    """

    name: str
    about: str = ""
    checks: tuple[str, ...] = (ALL,)
    without: tuple[str, ...] = ()
    size: int = 96  # pixels along the longer side of a picture
    spp: int = 64  # paths of light a pixel
    samples: int = 50_000  # directions drawn for each test of a sampler
    delta_e: float = 2.0  # largest CIE ΔE2000 of the swatch to its prediction
    flip: float = 0.35  # mean FLIP of the preview to the exact cloth that warns
    seconds: float = 600.0  # time for the process that judges
    memory_mb: int = 4096  # data that it may hold

    def runs(self, check: str) -> bool:
        """Whether the check of that id runs."""
        return _among(check, self.checks) and not _among(check, self.without)


_TOP: dict[str, type | tuple[type, ...]] = {
    "name": str, "about": str, "checks": list, "without": list,
    "render": dict, "tolerance": dict, "limits": dict,
}  # fmt: skip
_NUMBER = (int, float)
_TABLES: dict[str, dict[str, tuple[type | tuple[type, ...], float, float]]] = {
    "render": {
        "size": (int, 16, 2048),
        "spp": (int, 4, 65536),
        "samples": (int, 10_000, 10_000_000),
    },
    "tolerance": {"delta_e": (_NUMBER, 0.1, 100), "flip": (_NUMBER, 0.0, 1.0)},
    "limits": {"seconds": (_NUMBER, 1, 86400), "memory_mb": (int, 256, 1 << 20)},
}


def read_profile(path: str | os.PathLike[str]) -> Profile:
    """Return the profile in the TOML file `path` (the format: docs/validation.md).

    Raises
    ------
    InputError
        One line that names file and key, for a key that is unknown or out of its limits.
    """
    where = os.fspath(path)
    data = read_toml(Path(path))
    known_keys(where, data, _TOP)
    if not data.get("name"):
        raise InputError(f"{where}: name is missing, expected text")
    settings: dict[str, Any] = {"name": data["name"], "about": data.get("about", "")}
    for key in ("checks", "without"):
        if key in data:
            settings[key] = _names(where, key, data[key])
    for table, numbers in _TABLES.items():
        found = data.get(table, {})
        known_keys(
            f"{where}: [{table}]", found, {key: kind for key, (kind, _, _) in numbers.items()}
        )
        for key, value in found.items():
            _, low, high = numbers[key]
            if not low <= value <= high:
                raise InputError(
                    f"{where}: [{table}] {key} is {value}, expected {low:g} to {high:g}"
                )
            settings[key] = value
    return Profile(**settings)


def find_profile(name: str | os.PathLike[str]) -> Profile:
    """Return the profile of that name, or of the TOML file that `name` is the path of.

    Raises
    ------
    InputError
        There is none, or it is broken.
    """
    text = os.fspath(name)
    if text.endswith(".toml") or os.sep in text:
        return read_profile(text)
    if text in OURS:
        return read_profile(_FOLDER / f"{text}.toml")
    points = _points()
    if text not in points:
        known = ", ".join(sorted({*OURS, *points}))
        raise InputError(f"no profile {text!r}, expected {known} or a .toml file")
    return read_profile(_led_to(points[text]))


def profile_names() -> tuple[str, ...]:
    """Return the names of all profiles that are installed, ours first."""
    return (*OURS, *sorted(_points()))


def _points() -> dict[str, Any]:
    """Return the entry points by name; a name of ours is not taken by others."""
    return {point.name: point for point in entry_points(group=GROUP) if point.name not in OURS}


def _led_to(point: Any) -> Path:
    """Return the path that an entry point leads to; raises InputError where it is none."""
    try:
        found = point.load()
        return Path(found)
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        raise InputError(
            f"entry point {point.name} of {GROUP}: expected the path of a TOML file: {what}"
        ) from error


def _names(where: str, key: str, values: list[Any]) -> tuple[str, ...]:
    from weaveusd.validate.registry import all_checks

    ids = [check.id for check in all_checks()]
    known = {ALL, *ids, *(i.split("/")[0] for i in ids)}
    for value in values:
        if not isinstance(value, str) or value not in known:
            raise InputError(
                f"{where}: {key} names {value!r}, which is no check; see docs/validation.md"
            )
    return tuple(values)


def _among(check: str, names: tuple[str, ...]) -> bool:
    return any(name in (ALL, check, check.split("/")[0]) for name in names)
