"""Judging one authored value by the contract's description of its attribute."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from pxr import Usd

from weaveusd.contract import Attribute
from weaveusd.validate.model import Finding
from weaveusd.validate.registry import Code


def judge(
    prim: Usd.Prim,
    namespace: str,
    attributes: tuple[Attribute, ...],
    codes: tuple[Code, Code, Code, Code],
) -> Iterator[Finding]:
    """Judge every attribute of `namespace` that the contract lists.

    `codes` are for an attribute that is missing, of another type, outside its limits and
    outside its tokens.
    """
    missing, typed, limited, tokened = codes
    for attribute in attributes:
        path = f"{prim.GetPath()}.{namespace}:{attribute.name}"
        authored = prim.GetAttribute(f"{namespace}:{attribute.name}")
        if not authored or not authored.HasAuthoredValue():
            if not attribute.optional:
                yield missing("is not authored", path)
            continue
        # A layer may state another type than the schema, which USD answers with.
        types = {str(spec.typeName) for spec in authored.GetPropertyStack()} - {attribute.type}
        if types:
            yield typed(f"has type {', '.join(sorted(types))}, expected {attribute.type}", path)
            continue
        value = authored.Get()
        if value is None:
            yield missing("is blocked", path)
        elif attribute.tokens and value not in attribute.tokens:
            yield tokened(f"is {value!r}, expected one of {', '.join(attribute.tokens)}", path)
        elif not _within(value, attribute.hard):
            yield limited(f"is {value}, expected {_interval(attribute.hard)}", path)


def strangers(prim: Usd.Prim, namespace: str, attributes: tuple[Attribute, ...]) -> list[str]:
    """Return the authored attributes directly in `namespace` that the contract does not list."""
    known = {f"{namespace}:{attribute.name}" for attribute in attributes}
    depth = namespace.count(":") + 1
    return [
        str(found.GetPath())
        for found in prim.GetAuthoredPropertiesInNamespace(namespace)
        if found.GetName().count(":") == depth and found.GetName() not in known
    ]


def _within(value: Any, hard: tuple[float | None, float | None]) -> bool:
    """Whether every number in `value` is finite and within the limits; other values are."""
    if isinstance(value, (str, bytes)) or not isinstance(value, (int, float)):
        try:
            numbers = [float(component) for component in value]
        except (TypeError, ValueError):
            return True
    else:
        numbers = [float(value)]
    low = -math.inf if hard[0] is None else hard[0]
    high = math.inf if hard[1] is None else hard[1]
    return all(math.isfinite(number) and low <= number <= high for number in numbers)


def _interval(hard: tuple[float | None, float | None]) -> str:
    low, high = hard
    if low is None and high is None:
        return "a finite number"
    if high is None:
        return f"at least {low:g}"
    return f"at most {high:g}" if low is None else f"{low:g} to {high:g}"
