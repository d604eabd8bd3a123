"""The reference against values that were found without it (tests/golden/make_shading.py)."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.errors import WeaveusdError
from weaveusd.shading.microcylinder import Parameters, evaluate

if TYPE_CHECKING:
    from weaveusd.yarn.model import Optics

_FIELDS = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau", "A", "gaussian")
_OPTICS = ("eta", "k_d", "k_s", "gamma_s", "gamma_v")


def golden_error(optics: Optics, *, gaussian: bool = False) -> float | None:
    """Return the largest relative error of `evaluate` on the golden cases of these optics.

    It is None where there are none. N_V is part of it.
    """
    errors = [
        _error(case)
        for case in _cases()
        if case["gaussian"] == gaussian
        and all(np.isclose(case[key], getattr(optics, key), rtol=1e-9) for key in _OPTICS)
    ]
    return max(errors, default=None)


def golden_file() -> Path:
    """Return the golden values: inside an installed package, else of the checkout.

    Raises WeaveusdError where neither is.
    """
    package = Path(__file__).parent
    for file in (package / "golden.json", package.parents[1] / "tests" / "golden" / "shading.json"):
        if file.is_file():
            return file
    raise WeaveusdError(f"{package / 'golden.json'}: the golden values are not installed")


@cache
def _cases() -> list[dict[str, Any]]:
    cases: list[dict[str, Any]] = json.loads(golden_file().read_text())["cases"]
    return cases


def _error(case: dict[str, Any]) -> float:
    params = Parameters(*(case[key] for key in _FIELDS))
    found = evaluate(case["wi"], case["wo"], case["n"], case["t"], params)
    expected = np.array(case["eval"])
    return float(np.max(np.abs(found - expected) / np.maximum(np.abs(expected), 1e-12)))
