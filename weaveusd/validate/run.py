"""Runs the checks on an asset and gathers what they found."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace

from weaveusd.contract import MAX_COLORWAYS
from weaveusd.errors import InputError
from weaveusd.stage import captured_diagnostics
from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.profiles import DEFAULT, Profile, find_profile
from weaveusd.validate.registry import Check, Survey, all_checks

MAX_FINDINGS = 20
"""Findings of one check that a report lists; the rest are counted."""

_READING = 0.8
"""Share of the time that goes into reading textures, for the progress bar."""


def validate(
    stage: str | os.PathLike[str],
    *,
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
    checks: Collection[str] | None = None,
    profile: str | Profile = DEFAULT,
) -> Report:
    """Return what the checks find in the asset whose entry layer is the file `stage`.

    `jobs` threads read the textures, by default one for each core. `progress` is told the share
    of the work done, 0…1. `checks` names the checks to run, by id or by the part of it before
    the slash; None runs those of the `profile`, which is one, or the name or file of one.

    Every colorway is judged. Of those beside the one that the asset chooses itself the report has
    what is wrong, and nothing twice.

    Raises
    ------
    StageError
        When the file cannot be opened as a USD stage.
    InputError
        When `checks` names one that does not exist, or the profile is broken.
    """
    return examine(stage, jobs=jobs, progress=progress, checks=checks, profile=profile)[0]


def examine(
    stage: str | os.PathLike[str],
    *,
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
    checks: Collection[str] | None = None,
    profile: str | Profile = DEFAULT,
) -> tuple[Report, OpenAsset]:
    """Return what `validate` returns, and the asset with what its checks have shown of it."""
    chosen_profile = profile if isinstance(profile, Profile) else find_profile(profile)
    chosen = _select(checks, chosen_profile)
    tell = progress or (lambda share: None)
    asset = OpenAsset(stage, jobs, profile=chosen_profile)
    others = [name for name in asset.colorways[:MAX_COLORWAYS] if name != asset.chosen]
    looks = 1 + len(others)
    findings = _judge(chosen, asset, _part(tell, 0, looks))
    told = {(f.code, f.message, f.where) for f in findings}
    for index, colorway in enumerate(others, start=1):
        other = OpenAsset(stage, jobs, colorway, chosen_profile)
        for finding in _judge(chosen, other, _part(tell, index, looks)):
            about = (finding.code, finding.message, finding.where)
            if finding.status > Status.SKIP and about not in told:
                message = f"in the colorway {colorway}: {finding.message}"
                findings.append(replace(finding, message=message))
    return Report(str(stage), tuple(findings), chosen_profile.name), asset


def _part(tell: Callable[[float], None], index: int, count: int) -> Callable[[float], None]:
    """Return what tells the share of part `index` of `count`."""
    return lambda share: tell((index + share) / count)


def _judge(
    chosen: Collection[Check], asset: OpenAsset, tell: Callable[[float], None]
) -> list[Finding]:
    surveys = _surveys(chosen, asset, lambda share: tell(_READING * share))
    findings: list[Finding] = []
    for done, check in enumerate(chosen, start=1):
        findings += run_check(check, asset, surveys.get(check.id))
        tell(_READING + (1 - _READING) * done / len(chosen))
    return findings


def run_check(
    check: Check, asset: OpenAsset, survey: Survey | Exception | None = None
) -> Iterator[Finding]:
    """Yield the findings of one check: at least one, whatever happens inside it.

    `survey` is what has been seen for a check whose rule is one, or what it raised; None makes it
    look now.
    """
    for need in check.needs:
        lack = asset.lacks(need)
        if lack is not None:
            yield Finding(check.id, Status.SKIP, f"{check.id}/skip", lack)
            return
    found: list[Finding] = []
    excess = 0
    try:
        with captured_diagnostics():
            for finding in _judgement(check, asset, survey):
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


def _surveys(
    chosen: Collection[Check], asset: OpenAsset, progress: Callable[[float], None] | None = None
) -> dict[str, Survey | Exception]:
    """Read the textures once for all of `chosen` that look at texels.

    The survey of each that has all it needs but the textures, or what it raised.
    """
    surveys: dict[str, Survey | Exception] = {}
    looks = {}
    for check in chosen:
        others = (need for need in check.needs if need != "textures")
        if not isinstance(check.rule, type) or any(asset.lacks(need) for need in others):
            continue
        try:
            with captured_diagnostics():
                survey = check.rule(asset)
        except Exception as error:
            surveys[check.id] = error
        else:
            surveys[check.id], looks[check.id] = survey, survey.look
    if looks:
        surveys |= asset.sweep(looks, progress)
    return surveys


def _judgement(
    check: Check, asset: OpenAsset, survey: Survey | Exception | None
) -> Iterator[Finding]:
    if not isinstance(check.rule, type):
        return check.rule(asset)
    if survey is None:
        survey = _surveys((check,), asset)[check.id]
    if isinstance(survey, Exception):
        raise survey
    return survey.findings()


def _select(names: Collection[str] | None, profile: Profile) -> tuple[Check, ...]:
    known = all_checks()
    if names is None:
        return tuple(check for check in known if profile.runs(check.id))
    for name in names:
        if not any(name in (check.id, check.id.split("/")[0]) for check in known):
            raise InputError(f"no check is called {name!r}, expected one of docs/validation.md")
    return tuple(c for c in known if c.id in names or c.id.split("/")[0] in names)
