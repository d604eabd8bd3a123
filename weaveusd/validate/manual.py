r"""The page docs/validation.md, made from the checks themselves.

Write it anew with::

    python -c "from weaveusd.validate.manual import manual; print(manual(), end='')" \
        > docs/validation.md
"""

from __future__ import annotations

from weaveusd.validate.registry import Check, all_checks

_NEEDS = {
    "material": "a cloth material",
    "shader": "the exact shader",
    "textures": "all textures, of one size",
    "renderer": "Mitsuba and libLLVM",
}

_HEAD = """\
# What is checked

`weaveusd.validate(stage)` opens the entry layer of an asset and judges it from its files alone:
none of the code that makes assets is loaded. It returns a report; `report.passed` is false as
soon as one finding is FAIL or ERROR. An asset that does not pass is not published.

| status | meaning |
| --- | --- |
| PASS | the check found nothing |
| SKIP | the check could not run, for the reason given |
| WARN | something is odd, but renders as meant |
| FAIL | the asset is wrong |
| ERROR | the check itself broke down; please report it |

A report has at least one finding for each check. The codes below are permanent. A check that
found nothing says `<check>/pass`, one that could not run `<check>/skip`, and one that broke down
`<check>/error`. One check lists at most 20 findings and counts the rest. Columns and rows of
texels are counted from 0, rows from the top of the image.

`validate(stage, checks=["texture", "path/anchored"])` runs some checks only, by id or by the part
of it before the slash. Every texture is decoded once for all checks, on all cores or on as many as
`jobs` says; two bands of rows are in memory at a time.

An asset from elsewhere is taken for hostile: the sizes of layers, images, documents and of the
manifest are checked before they are read, and no name in a file is used as a path that leaves
the asset's folder. References of the layers are composed by OpenUSD, which opens what they name.
`weaveusd validate` and `validate_apart` judge it in a child process with limits of memory and time.
Where that ends without a report, the report has one finding, of status ERROR: `process-crashed`, or
`process-late` when its time was up.

<!-- From here on written by weaveusd.validate.manual. -->
"""


def manual() -> str:
    """Return docs/validation.md: every check with its reason and codes, as Markdown."""
    return _HEAD + "".join(_section(check) for check in all_checks())


def _section(check: Check) -> str:
    lines = ["", f"## {check.id}", "", check.title, "", f"*Why:* {check.why}", ""]
    if check.needs:
        lines += [f"*Needs:* {', '.join(_NEEDS[need] for need in check.needs)}.", ""]
    lines += ["| code | status | found when |", "| --- | --- | --- |"]
    lines += [f"| `{c.name}` | {c.status.name} | {c.meaning} |" for c in check.codes]
    return "\n".join(lines) + "\n"
