"""Whether the material says everything about its cloth."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.contract import CLOTH_ATTRIBUTES, CLOTH_NAMESPACE
from weaveusd.validate.checks._values import judge, strangers
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

MISSING = Code("cloth-missing", Status.FAIL, "An attribute of the cloth is not authored.")
TYPE = Code("cloth-type", Status.FAIL, "An attribute of the cloth has another type.")
LIMITS = Code("cloth-limits", Status.FAIL, "A value about the cloth is outside its limits.")
TOKEN = Code("cloth-token", Status.FAIL, "A word about the cloth is none of those allowed.")
UNKNOWN = Code("cloth-unknown", Status.WARN, "The cloth has an attribute that no reader knows.")


@check(
    id="attribute/cloth",
    why="A program without our schema sees authored values only, and USD enforces neither "
    "limits nor allowed words.",
    needs=("material",),
    codes=(MISSING, TYPE, LIMITS, TOKEN, UNKNOWN),
)
def cloth_attributes(asset: OpenAsset) -> Iterator[Finding]:
    """Every attribute of the cloth is authored, of its type and within its limits."""
    yield from judge(
        asset.material, CLOTH_NAMESPACE, CLOTH_ATTRIBUTES, (MISSING, TYPE, LIMITS, TOKEN)
    )
    for path in strangers(asset.material, CLOTH_NAMESPACE, CLOTH_ATTRIBUTES):
        yield UNKNOWN("is none of the attributes of a cloth", path)
