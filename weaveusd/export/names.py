"""Names that are safe as file names, USD prims and MaterialX elements all at once."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

from weaveusd.contract import CLOTH_NAMESPACE, LOOK_LAYER, YARN_ATTRIBUTES

MAX_NAME = 64

_DEVICES = {"con", "prn", "aux", "nul", "clock"} | {
    f"{port}{digit}" for port in ("com", "lpt") for digit in range(10)
}
# An asset `look` would have an entry layer of the same file name as its look layer.
_TAKEN = {LOOK_LAYER.split(".")[0], CLOTH_NAMESPACE}
_PROPERTIES = {attribute.name.lower() for attribute in YARN_ATTRIBUTES}


def safe_name(text: str) -> str:
    """Return an ASCII name made from `text` that is safe everywhere an asset's name goes.

    The name matches ``[A-Za-z][A-Za-z0-9_]{0,63}``, is no device name of Windows and never the
    name of another file of the asset. Accents are dropped and every other run of characters
    becomes one underscore; nothing left gives ``cloth``. A name that came from here comes back
    unchanged.
    """
    plain = unicodedata.normalize("NFKD", text[: 16 * MAX_NAME]).encode("ascii", "ignore").decode()
    words = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_")
    if not words:
        return "cloth"
    if words[0].isdigit() or words.lower() in _DEVICES | _TAKEN:
        words = f"cloth_{words}"
    return words[:MAX_NAME].rstrip("_")


def instance_names(names: Iterable[str]) -> tuple[str, ...]:
    """Return a distinct instance name of `WeaveYarnAPI` for each of `names`, in order.

    A name that repeats, or that USD refuses because the schema has a property of that name,
    gets a number or the suffix ``_yarn``.
    """
    taken: set[str] = set()
    result = []
    for name in names:
        base = safe_name(name)
        if base.lower() in _PROPERTIES:
            base = f"{base[: MAX_NAME - 5]}_yarn"
        candidate, number = base, 2
        while candidate in taken:
            candidate = f"{base[: MAX_NAME - 4]}_{number}"
            number += 1
        taken.add(candidate)
        result.append(candidate)
    return tuple(result)
