"""The hooks of one publish: who is asked, who is told, and what becomes of their answers."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from weaveusd.cli_telling import Log
from weaveusd.errors import HookFailedError, HookRefusedError
from weaveusd.hooks import SECONDS, run_hook

__all__ = ["SECONDS", "Hooks", "ended_by_sigterm"]


@dataclass(frozen=True, slots=True)
class Hooks:
    """The commands before and after a publish, None for none, and the time that each gets."""

    before: tuple[str, ...] | None
    after: tuple[str, ...] | None
    seconds: float

    def ask(self, request: Mapping[str, Any], log: Log) -> None:
        """Ask the command before; raises HookRefusedError where it fails."""
        fault = self._run("pre", self.before, {"event": "pre-publish", "request": request}, log)
        if fault is not None:
            raise HookRefusedError(f"the pre-hook refused: {fault}")

    def tell(self, request: Mapping[str, Any], publication: Mapping[str, Any], log: Log) -> None:
        """Tell the command after; raises HookFailedError where it fails.

        It is told of a version that is `unchanged` too: what was killed between publishing and
        telling is told by the next run. Of a dry run it is not told.
        """
        if request["dry_run"]:
            return
        message = {"event": "post-publish", "request": request, "publication": publication}
        fault = self._run("post", self.after, message, log)
        if fault is not None:
            what = f"{publication['asset']} {publication['version']} is published"
            raise HookFailedError(f"{what}, but the post-hook failed: {fault}")

    def _run(
        self, which: str, command: tuple[str, ...] | None, message: Mapping[str, Any], log: Log
    ) -> str | None:
        if command is None:
            return None
        run = run_hook(command, message, seconds=self.seconds)
        for stream, text in (("stdout", run.stdout), ("stderr", run.stderr)):
            for line in text.splitlines():
                log.note(f"{which}-hook {stream}: {line}")
        log.note(f"{which}-hook: {run.fault or 'done'}")
        return run.fault


@contextmanager
def ended_by_sigterm() -> Iterator[Callable[[], None]]:
    """Have SIGTERM, with which farms cancel, end the body as an exception, so that it cleans up.

    What is yielded raises that exception again once SIGTERM has come: where the signal arrives
    while compiled code calls Python, the first one is lost.
    """
    asked = False

    def end(number: int, frame: object) -> None:
        nonlocal asked
        asked = True
        go_on()

    def go_on() -> None:
        if asked:
            sys.exit(128 + signal.SIGTERM)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield go_on
    finally:
        signal.signal(signal.SIGTERM, before)
