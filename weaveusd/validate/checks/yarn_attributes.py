"""Whether the material says everything about its yarns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from weaveusd.contract import MAX_YARNS, YARN_API, YARN_ATTRIBUTES, YARN_NAMESPACE
from weaveusd.validate.checks._values import judge, strangers
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset, applied_schemas
from weaveusd.validate.registry import Code, check

MISSING = Code("yarn-missing", Status.FAIL, "An attribute of a yarn is not authored.")
TYPE = Code("yarn-type", Status.FAIL, "An attribute of a yarn has another type.")
LIMITS = Code("yarn-limits", Status.FAIL, "A number about a yarn is outside its limits.")
TOKEN = Code("yarn-token", Status.FAIL, "A word about a yarn is none of those allowed.")
UNKNOWN = Code("yarn-unknown", Status.WARN, "A yarn has an attribute that no reader knows.")
LIST = Code(
    "yarn-list", Status.FAIL, "weave:yarns and the instances of the yarn schema do not agree."
)
ORDER = Code("yarn-order", Status.FAIL, "The ids of the yarns do not count up from 1.")


@check(
    id="attribute/yarns",
    why="The id texture and the shader's arrays find a yarn by its place in weave:yarns.",
    needs=("material",),
    codes=(MISSING, TYPE, LIMITS, TOKEN, UNKNOWN, LIST, ORDER),
)
def yarn_attributes(asset: OpenAsset) -> Iterator[Finding]:
    """Every yarn is listed once, in the order of its id, with all attributes authored."""
    path = str(asset.material.GetPath())
    prefix = f"{YARN_API}:"
    applied = [
        name.removeprefix(prefix)
        for name in applied_schemas(asset.material)
        if name.startswith(prefix)
    ]
    listed = asset.cloth("yarns") or ()
    if not 1 <= len(listed) <= MAX_YARNS or sorted(listed) != sorted(applied):
        yield LIST(
            f"weave:yarns lists {_names(listed)}, but {YARN_API} is applied for {_names(applied)}",
            path,
        )
    for yarn in applied:
        namespace = f"{YARN_NAMESPACE}:{yarn}"
        codes = (MISSING, TYPE, LIMITS, TOKEN)
        yield from judge(asset.material, namespace, YARN_ATTRIBUTES, codes)
        for stranger in strangers(asset.material, namespace, YARN_ATTRIBUTES):
            yield UNKNOWN("is none of the attributes of a yarn", stranger)
    for place, yarn in enumerate(asset.yarns, start=1):
        number = asset.yarn(yarn, "id")
        if yarn in applied and number is not None and number != place:
            yield ORDER(f"{yarn} has id {number}, expected {place}, its place in the list", path)


def _names(names: Sequence[str]) -> str:
    """Return `names`, the first few of many, as part of a sentence."""
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return (", ".join(names[:8]) or "nothing") + more
