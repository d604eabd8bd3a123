"""The report as one page of HTML that needs nothing beside itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.registry import all_checks
from weaveusd.validate.report.style import STYLE
from weaveusd.validate.text import summary

_VERDICTS = {True: "passed", False: "not passed"}
_GROUPS = ("Renders", "Networks", "Channels", "Moment maps")
_NOTES = {
    "Networks": "What other renderers make of the asset, beside the exact cloth.",
    "Channels": "Texels at even steps, none mixed; the top row of the file is at the top.",
    "Moment maps": "What warp and weft do below each texel, for a cloth seen from afar: albedo in "
    "color, all else component by component from the left and from the top, white the largest "
    "value, and black 0 or the opposite of the largest where there are values below 0.",
}


def as_page(report: Report, shown: Mapping[str, Any], *, version: str, made: str) -> str:
    """Return the page: verdict, findings, pictures, draft, yarns, losses, provenance, hashes.

    `shown` is what `gather` returned, or empty where the asset could not be opened. `version` is
    that of weaveusd, `made` the day. Nothing in the page is loaded from elsewhere, and no script
    runs: a policy in its head forbids both.
    """
    name = str(shown.get("name") or report.asset)
    parts = [
        _verdict(report, name, made),
        _findings(report),
        *(_exhibits(group, shown.get("exhibits", [])) for group in _GROUPS),
        _draft_and_lobes(shown),
        _table("Yarns", shown.get("yarns", []), head=True),
        _readme(str(shown.get("readme", ""))),
        _table("Provenance and measures", shown.get("cloth", []), head=False),
        _table("Files, bytes and SHA-256", shown.get("files", []), head=False),
        _absent(shown.get("absent", {})),
        f"<footer>weaveusd {escape(version)}, profile {escape(report.profile or '—')}, "
        f"{escape(made)}</footer>",
    ]
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<link rel="icon" href="data:,">'
        f"<title>{escape(name)}: {_VERDICTS[report.passed]}</title>"
        f"<style>{STYLE}</style></head>\n<body>\n"
        + "\n".join(filter(None, parts))
        + "\n</body></html>\n"
    )


def _verdict(report: Report, name: str, made: str) -> str:
    waived = sum(bool(finding.waived) for finding in report.findings)
    skipped = [f for f in report.findings if f.status is Status.SKIP]
    notes = [f"Profile {report.profile or '—'}", made, summary(report)]
    if skipped:
        notes.append(f"{len(skipped)} skipped, which is no pass")
    if waived:
        notes.append(f"{waived} waived")
    state = "pass" if report.passed else "fail"
    return (
        f'<header class="{state}"><h1>{escape(name)}</h1>'
        f'<p class="verdict">{_VERDICTS[report.passed]} '
        f'<span class="chip {report.status.name.lower()}">{report.status.name}</span></p>'
        f"<p>{escape(' · '.join(notes))}</p>"
        f'<p class="path">{escape(report.asset)}</p></header>'
    )


def _findings(report: Report) -> str:
    whys = {check.id: check.why for check in all_checks()}
    order = sorted(report.findings, key=lambda f: (bool(f.waived), -f.status))
    told = [f for f in order if f.status is not Status.PASS]
    passed = [f for f in order if f.status is Status.PASS]
    rows = "".join(_row(finding, whys.get(finding.check, "")) for finding in told)
    head = "<tr><th></th><th>Finding</th><th>Where</th><th>What</th></tr>"
    table = f'<table class="findings">{head}{rows}</table>' if rows else "<p>Nothing to tell.</p>"
    listed = "".join(f"<li><b>{escape(f.check)}</b> {escape(f.message)}</li>" for f in passed)
    return (
        f"<section><h2>Findings</h2>{table}"
        f"<details><summary>{len(passed)} checks passed</summary><ul>{listed}</ul></details>"
        "</section>"
    )


def _row(finding: Finding, why: str) -> str:
    state = "waived" if finding.waived else finding.status.name.lower()
    label = "WAIVED" if finding.waived else finding.status.name
    reason = f'<p class="reason">Waived: {escape(finding.waived)}</p>' if finding.waived else ""
    about = f'<p class="why">{escape(why)}</p>' if why and finding.status > Status.SKIP else ""
    return (
        f'<tr><td><span class="chip {state}">{label}</span></td>'
        f"<td><code>{escape(finding.code)}</code><br><small>{escape(finding.check)}</small></td>"
        f"<td><code>{escape(finding.where)}</code></td>"
        f"<td>{escape(finding.message)}{about}{reason}</td></tr>"
    )


def _exhibits(group: str, exhibits: Sequence[Mapping[str, str]]) -> str:
    figures = "".join(
        f'<figure><img src="{escape(e["source"])}" alt="{escape(e["title"])}">'
        f"<figcaption><b>{escape(e['title'])}</b><br>{escape(e['text'])}</figcaption></figure>"
        for e in exhibits
        if e["group"] == group
    )
    if not figures:
        return ""
    note = f"<p>{escape(_NOTES[group])}</p>" if group in _NOTES else ""
    return f'<section><h2>{group}</h2>{note}<div class="grid">{figures}</div></section>'


def _draft_and_lobes(shown: Mapping[str, Any]) -> str:
    # These drawings are made of numbers alone, and need no escaping.
    draft = str(shown.get("draft", ""))
    lobes = "".join(
        f"<figure>{lobe['svg']}<figcaption><b>{escape(lobe['yarn'])}</b></figcaption></figure>"
        for lobe in shown.get("lobes", [])
    )
    parts = []
    if draft:
        parts.append(
            f"<section><h2>Draft</h2><p>Warp on top is dark; the first end is on the left, the "
            f"first pick at the bottom.</p>{draft}</section>"
        )
    if lobes:
        parts.append(
            "<section><h2>Lobes</h2><p>White yarns in the plane of the fibre, seen from 0°, 30° "
            f'and 60°; two decades, logarithmic.</p><div class="grid">{lobes}</div></section>'
        )
    return "\n".join(parts)


def _table(title: str, rows: Sequence[Sequence[str]], *, head: bool) -> str:
    if not rows:
        return ""
    body = ""
    for number, row in enumerate(rows):
        tag = "th" if head and number == 0 else "td"
        first, *rest = (escape(str(cell)) for cell in row)
        cells = "".join(f"<{tag}>{cell}</{tag}>" for cell in rest)
        body += f"<tr><th>{first}</th>{cells}</tr>"
    return f'<section><h2>{title}</h2><div class="wide"><table>{body}</table></div></section>'


def _readme(text: str) -> str:
    if not text:
        return ""
    return (
        "<section><h2>Losses and use, as the asset states them</h2>"
        f"<pre>{escape(text)}</pre></section>"
    )


def _absent(absent: Mapping[str, str]) -> str:
    if not absent:
        return ""
    rows = "".join(f"<li><b>{escape(name)}</b>: {escape(why)}</li>" for name, why in absent.items())
    return f"<section><h2>Not shown</h2><ul>{rows}</ul></section>"
