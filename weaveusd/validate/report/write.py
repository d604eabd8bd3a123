"""Writing the files of a report into a folder."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from weaveusd._version import __version__
from weaveusd.errors import InputError
from weaveusd.validate.model import Report
from weaveusd.validate.report.junit import as_junit
from weaveusd.validate.report.page import as_page

PAGE, DATA, JUNIT = "report.html", "report.json", "report.xml"

MAX_BYTES = 256 << 20
"""Largest file of exhibits that is read: those of the profile `full` take a few megabytes."""


def write_report(report: Report, exhibits: Path | None, folder: Path, *, made: str) -> Path:
    """Write page, JSON and JUnit XML into `folder`, which is made; return the page's path.

    `exhibits` is the file that the judging process wrote, if it came so far; `made` is the day.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    shown = _read(exhibits)
    texts = {
        PAGE: as_page(report, shown, version=__version__, made=made),
        DATA: json.dumps({**report.as_dict(), "made": made}, indent=2, ensure_ascii=False) + "\n",
        JUNIT: as_junit(report),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            part = folder / f".{name}.part"
            part.write_text(text, encoding="utf-8", errors="backslashreplace")
            os.replace(part, folder / name)
    except OSError as error:
        raise InputError(f"{folder}: the report cannot be written: {error.strerror}") from error
    return folder / PAGE


def _read(exhibits: Path | None) -> Mapping[str, Any]:
    if exhibits is None or not exhibits.is_file() or exhibits.stat().st_size > MAX_BYTES:
        return {}
    try:
        found = json.loads(exhibits.read_text(encoding="utf-8"))
    except ValueError:
        return {}  # the process was ended while it wrote
    return found if isinstance(found, dict) else {}
