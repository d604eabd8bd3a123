"""Runs the checks on an asset and gathers what they found."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace

from weaveusd.errors import InputError
from weaveusd.stage import captured_diagnostics
from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Check, all_checks

MAX_FINDINGS = 20
"""Findings of one check that a report lists; the rest are counted."""


def validate(
    stage: str | os.PathLike[str],
    *,
    progress: Callable[[float], None] | None = None,
    checks: Collection[str] | None = None,
) -> Report:
    """Return what the checks find in the asset whose entry layer is the file `stage`.

    `progress` is told the share of the checks done, 0…1. `checks` names the checks to run, by
    id or by the part of it before the slash; None runs them all.

    Raises
    ------
    StageError
        When the file cannot be opened as a USD stage.
    InputError
        When `checks` names one that does not exist.
    """
    chosen = _select(checks)
    asset = OpenAsset(stage)
    findings: list[Finding] = []
    for done, check in enumerate(chosen, start=1):
        findings += run_check(check, asset)
        if progress is not None:
            progress(done / len(chosen))
    return Report(str(stage), tuple(findings))


def run_check(check: Check, asset: OpenAsset) -> Iterator[Finding]:
    """Yield the findings of one check: at least one, whatever happens inside it."""
    for need in check.needs:
        lack = asset.lacks(need)
        if lack is not None:
            yield Finding(check.id, Status.SKIP, f"{check.id}/skip", lack)
            return
    found: list[Finding] = []
    excess = 0
    try:
        with captured_diagnostics():
            for finding in check.rule(asset):
                if len(found) < MAX_FINDINGS:
                    found.append(replace(finding, check=check.id))
                else:
                    excess += 1
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        found.append(
            Finding(check.id, Status.ERROR, f"{check.id}/error", f"the check broke down: {what}")
        )
    if excess:
        found[-1] = replace(found[-1], message=f"{found[-1].message} (and {excess} more)")
    if not found:
        found.append(Finding(check.id, Status.PASS, f"{check.id}/pass", check.title))
    yield from found


def _select(names: Collection[str] | None) -> tuple[Check, ...]:
    known = all_checks()
    if names is None:
        return known
    for name in names:
        if not any(name in (check.id, check.id.split("/")[0]) for check in known):
            raise InputError(f"no check is called {name!r}, expected one of docs/validation.md")
    return tuple(c for c in known if c.id in names or c.id.split("/")[0] in names)
