"""Who is told how a publish goes: a terminal, a render farm, a log, the caller's file.

Where ``--progress openjd`` is asked for, stdout is for the farm's lines alone: each stands on a
line of its own and begins as the Open Job Description has it, so that nothing a draft says can be
taken for one.
"""

from __future__ import annotations

import os
import platform
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import Any

from weaveusd._version import __version__
from weaveusd.cli_output import json_text, progress_bar
from weaveusd.errors import WeaveusdError
from weaveusd.files import check_target, write_whole


class ProgressKind(str, Enum):
    """How progress is shown."""

    bar = "bar"
    openjd = "openjd"
    none = "none"


@contextmanager
def told_progress(kind: ProgressKind, what: str) -> Iterator[Callable[[float], None] | None]:
    """Show the progress of the body in the way of `kind`, and to a farm also whether it failed."""
    if kind is ProgressKind.none:
        yield None
        return
    if kind is ProgressKind.bar:
        with progress_bar(what) as bar:
            yield bar
        return
    tell_farm("status", what)
    last = -1

    def tell(share: float) -> None:
        nonlocal last
        if (percent := int(100 * share)) > last:
            last = percent
            tell_farm("progress", f"{percent}.0")

    try:
        yield tell
    except Exception as error:
        tell_farm("fail", str(error) or type(error).__name__)
        raise


def tell_farm(kind: str, text: str) -> None:
    """Print one line of the Open Job Description: progress, status or fail."""
    line = " ".join(f"openjd_{kind}: {text}".split())
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


class Log:
    """A log of one run: lines with the time in UTC, added to the end of a file.

    Without a file nothing is kept.
    """

    def __init__(self, path: Path | None) -> None:
        """Open `path`, made if missing; raises InputError where it is a link or cannot be."""
        self._descriptor: int | None = None
        if path is None:
            return
        check_target("log file", path)
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        try:
            self._descriptor = os.open(path, flags, 0o666)
        except OSError as error:
            raise WeaveusdError(f"log file {path}: {error.strerror}") from error

    def __enter__(self) -> Log:
        return self

    def __exit__(self, *error: object) -> None:
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def start(self, request: Mapping[str, Any]) -> None:
        """Note what runs where, and what it was asked for."""
        self.note(f"weaveusd {__version__}, Python {platform.python_version()}")
        self.note(f"process {os.getpid()} on {platform.node()}, {platform.platform()}")
        self.note(f"request {json_text(request)}")

    def note(self, text: str) -> None:
        """Add `text`, each line of it with the time; a full disk ends no publish."""
        if self._descriptor is None:
            return
        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        lines = "".join(f"{now} {line}\n" for line in text.splitlines())
        try:
            os.write(self._descriptor, lines.encode("utf-8", "replace"))
        except OSError as error:
            sys.stderr.write(f"weaveusd: the log ends here: {error.strerror}\n")
            self._descriptor = None

    def note_error(self, error: BaseException) -> None:
        """Add an error and where it came from."""
        self.note("".join(traceback.format_exception(error)))

    def following(self, tell: Callable[[float], None] | None) -> Callable[[float], None]:
        """Return a function that notes every tenth of the work and tells `tell` all of it."""
        last = 0

        def follow(share: float) -> None:
            nonlocal last
            if (tenth := int(10 * share)) > last:
                last = tenth
                self.note(f"{10 * tenth} % done")
            if tell is not None:
                tell(share)

        return follow


class ResultFile:
    """The file that the result of a run goes to as JSON, whole; without a path, none."""

    def __init__(self, path: Path | None) -> None:
        """Remove the result of an earlier run; raises InputError where no file can be made."""
        self._path = path
        if path is None:
            return
        check_target("result file", path)
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise WeaveusdError(f"result file {path}: {error.strerror}") from error

    def write(self, result: Mapping[str, Any]) -> None:
        """Write the result in place of what was there."""
        if self._path is not None:
            write_whole(self._path, json_text(result).encode("utf-8", "replace"))
