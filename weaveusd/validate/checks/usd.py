"""What OpenUSD's own validators say."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from pxr import UsdShade, UsdValidation

from weaveusd.contract import GLSLFX_CONTEXT
from weaveusd.stage import teach_sdr
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

ERROR = Code("usd-error", Status.FAIL, "A validator of OpenUSD reports an error.")
WARNING = Code("usd-warning", Status.WARN, "A validator of OpenUSD reports a warning.")

_PACKAGE_ONLY = "UsdzValidators"


@check(
    id="usd/validation",
    why="What OpenUSD itself calls broken, other programs may refuse.",
    codes=(ERROR, WARNING),
)
def usd_validation(asset: OpenAsset) -> Iterator[Finding]:
    """OpenUSD's validators, all but those for usdz packages, find nothing."""
    teach_sdr()
    for error in UsdValidation.ValidationContext(_validators()).Validate(asset.stage):
        if _is_unread_glslfx(error):
            continue
        text = " ".join(f"{error.GetName()}: {error.GetMessage()}".split())
        severe = error.GetType() == UsdValidation.ValidationErrorType.Error
        yield (ERROR if severe else WARNING)(text, _where(error))


@cache
def _validators() -> list[Any]:
    registry = UsdValidation.ValidationRegistry()
    names = [
        metadata.name
        for metadata in registry.GetAllValidatorMetadata()
        if not metadata.isSuite and _PACKAGE_ONLY not in metadata.GetKeywords()
    ]
    return [registry.GetOrLoadValidatorByName(name) for name in sorted(names)]


def _is_unread_glslfx(error: Any) -> bool:
    """Return whether `error` is that this OpenUSD, without imaging, reads no glslfx."""
    return error.GetName() == "MissingSourceTypeInRegistry" and all(
        list(UsdShade.Shader(site.GetPrim()).GetSourceTypes()) == [GLSLFX_CONTEXT]
        for site in error.GetSites()
        if site.IsPrim()
    )


def _where(error: Any) -> str:
    """Return the prims or properties that `error` is about."""
    places = []
    for site in error.GetSites():
        if site.IsProperty():
            places.append(str(site.GetProperty().GetPath()))
        elif site.IsPrim():
            places.append(str(site.GetPrim().GetPath()))
    return ", ".join(places)
