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
    "moments": "moment maps, which assets of older versions lack",
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

Drafts, optics and differences of pictures are computed by code of the judge's own: not by that
which made the textures, nor by that which renders them.

## Profiles

```
weaveusd validate asset.usda                        # quick: files alone
weaveusd validate asset.usda --profile standard     # and small renders
weaveusd validate asset.usda --profile lookdev.toml --waivers waivers.toml --report out/report
```

| profile | what runs |
| --- | --- |
| `quick` | every check of the files; nothing is rendered. `publish` asks it of every asset |
| `standard` | all checks; pictures of 96 pixels, 64 samples each |
| `full` | all checks; pictures of 256 pixels, 256 samples each, and a tighter limit of color |

`python benchmarks/validation.py` prints what they take. A profile is data. Every key but `name` may
be left out; checks are named by id, by the part of it before the slash, or `all`:

```toml
name = "lookdev"
about = "What lookdev signs."
checks = ["all"]
without = ["render/noise"]

[render]
size = 96           # pixels along the longer side of a picture
spp = 64            # samples a pixel
samples = 50000     # directions drawn for each test of a sampler

[tolerance]
delta_e = 2.0       # largest CIE ΔE2000 of the swatch to its prediction
flip = 0.35         # mean FLIP of another network to the exact cloth that warns

[limits]
seconds = 600       # time for the process that judges
memory_mb = 4096    # data that it may hold
```

A package adds one under a name of its own by an entry point of the group `weaveusd.profiles` that
leads to the path of such a file:

```toml
[project.entry-points."weaveusd.profiles"]
lookdev = "studio.profiles:LOOKDEV"    # LOOKDEV = Path(__file__).parent / "lookdev.toml"
```

## Waivers

A finding may pass for a reason. It stays in the report, with the reason beside it, and no longer
decides; `status` and `passed` are those of what is not waived. A waiver names a code, and a place
where it is not meant for all. What broke down (ERROR) cannot be waived. One that is over or covers
nothing is a finding itself: WARN `waiver-expired` or `waiver-unused`.

```toml
[[waiver]]
code = "color-disagrees"
where = "textures/base_color.exr"       # left out: every place
reason = "The client chose the darker lot."
by = "A. Weaver"                        # may be left out
date = 2026-11-01
until = 2027-02-01                      # the last day; left out: for ever
```

## Reports

`--report DIR` writes `report.html`, `report.json` and `report.xml`, JUnit's form. The page has
verdict, findings, renders, every channel and moment map, draft, lobes, yarns, the losses that the
asset states, provenance and hashes. It loads nothing, runs no script and prints. A skip is shown as
one and never counted as a pass. `make report` makes those of three cloths.

![Verdict, findings, renders, networks beside the exact cloth, channels](figures/report.png)

The swatch of `render/swatch` lies on black under an even white sky, seen at 8° to its normal from
four sides. Its mean color is predicted from what is stated: each yarn counts by its share of the
opacity, with `colorReached` and what its surface lobe mirrors, over frames of its texels.

## From afar

Moment maps ([distance.md](distance.md)) are judged by laws that every mean of yarn keeps, such as
that no square is smaller than that of its mean, and then by the textures: every texel of those is
taken off the maps again, and what is left may be 2⁻⁸ at most, which is rounding. Texels whose class
rounded frames leave open, such as those next to straight, are left open. `render/distance` renders
the cloth by its maps, in cells of a crossing and in one cell, and compares the mean color with that
of the yarns.

Of lobe maps the finest level is compared with the textures, in three bands of 64 rows, and with the
fibres; coarse levels of up to 256 texels a side are looked at as a whole, and never hold a lobe
along whose narrow axis α is below 0.8 of the narrowest yarn's. How near the fit of a tile comes is
not judged.

An asset of an older version has neither: `moments-none` and `lobes-none` say so, as skips, and it
passes. Textures that standard shaders read by yarn are asked for as the asset lists them.

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
