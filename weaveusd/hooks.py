"""Commands of a studio that are asked before a publish and told after it.

A hook is an argument list, run without a shell. It gets one JSON object on stdin; what it prints
is kept for the log, the last of it only where it is much.
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import IO, Any

SECONDS = 300.0
"""Time that a hook gets, by the clock, unless told otherwise."""

_KEPT = 1 << 16
"""Bytes of what a hook prints that are kept of each stream."""

_AFTER = 1.0
"""Seconds to wait for what a process prints that a hook left behind."""


@dataclass(frozen=True, slots=True)
class HookRun:
    """How a hook ended: None or why it failed, on one line; and what it printed last."""

    fault: str | None
    stdout: str
    stderr: str


def hook_command(text: str) -> tuple[str, ...]:
    """Return the arguments in `text`, split as a shell would and nothing more.

    Raises
    ------
    ValueError
        There are none, or a quote is not closed.
    """
    command = tuple(shlex.split(text))
    if not command:
        raise ValueError("expected a command")
    return command


def run_hook(
    command: Sequence[str], message: Mapping[str, Any], *, seconds: float = SECONDS
) -> HookRun:
    """Run `command` with `message` as JSON on stdin, `seconds` at most, and return how it ended.

    It runs in a session of its own; when its time is over, all of it that is still there is
    killed. A hook need not read what it gets.
    """
    pipe = subprocess.PIPE
    try:
        process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=pipe, start_new_session=True
        )
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
        return HookRun(f"{command[0]}: cannot be run: {reason}", "", "")
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stderr is not None
    data = json.dumps(message, ensure_ascii=False).encode("utf-8", "replace") + b"\n"
    out, err = _Tail(process.stdout), _Tail(process.stderr)
    _in_background(_feed, process.stdin, data)
    late = False
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        late = True
    finally:
        if process.poll() is None:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    stdout, stderr = out.text(), err.text()
    if late:
        return HookRun(f"{command[0]}: took more than {seconds:g} s", stdout, stderr)
    return HookRun(_fault(command[0], process.returncode, stderr), stdout, stderr)


class _Tail:
    """The end of what a stream says, read beside the process so that it never waits for us."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._kept = b""
        self._thread = _in_background(self._read)

    def _read(self) -> None:
        with self._stream as stream, suppress(OSError):
            while block := os.read(stream.fileno(), _KEPT):
                self._kept = (self._kept + block)[-_KEPT:]

    def text(self) -> str:
        self._thread.join(_AFTER)
        return self._kept.decode("utf-8", "replace")


def _feed(stream: IO[bytes], data: bytes) -> None:
    with suppress(OSError), stream:
        stream.write(data)


def _in_background(function: Any, *arguments: Any) -> threading.Thread:
    thread = threading.Thread(target=function, args=arguments, daemon=True)
    thread.start()
    return thread


def _fault(name: str, status: int, stderr: str) -> str | None:
    """Return why a hook failed: its last line on stderr, or how it ended where there is none."""
    if status == 0:
        return None
    said = [line.strip() for line in stderr.splitlines() if line.strip()]
    if said:
        return "".join(c if c.isprintable() else " " for c in said[-1])[:500]
    if status < 0:
        return f"{name}: was ended by {signal.Signals(-status).name}"
    return f"{name}: ended with status {status}"
