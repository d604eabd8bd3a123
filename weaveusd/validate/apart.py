"""Judging in a child process: a stage that crashes USD, or never ends, costs a finding.

The child gets its request on stdin and answers with JSON, one object a line: `{"share": …}` while
it goes on, then `{"findings": […]}`, or `{"fault": …, "message": …}` for what is to be raised.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from weaveusd.errors import InputError, StageError
from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.profiles import DEFAULT, Profile, find_profile

CHECK = "process/alive"
CRASHED, LATE = "process-crashed", "process-late"

# Python would look for modules in the working directory first, and that may be the asset's.
_START = (
    "import sys; sys.path[:1] = []; sys.path.append(sys.argv[1]); "
    "from weaveusd.validate.worker import main; main()"
)
_ROOT = Path(__file__).resolve().parents[2]
_MAX_LINE = 16 << 20
_FAULTS = {kind.__name__: kind for kind in (InputError, StageError)}


def validate_apart(
    stage: str | os.PathLike[str],
    *,
    jobs: int | None = None,
    progress: Callable[[float], None] | None = None,
    checks: Collection[str] | None = None,
    profile: str | Profile = DEFAULT,
    memory_bytes: int | None = None,
    seconds: float | None = None,
    exhibits: Path | None = None,
) -> Report:
    """Return what `weaveusd.validate.run.validate` finds, run in a child process of its own.

    The child may hold `memory_bytes` of data and take `seconds`, by default as the profile says.
    Where it ends without a report, the report has one finding, of status ERROR and code
    `process-crashed` or `process-late`. Into the file `exhibits` it writes, as JSON, what
    `weaveusd.validate.report` shows of the asset; it is not there when the child ends early.

    Raises
    ------
    StageError
        When the file cannot be opened as a USD stage.
    InputError
        When `checks` names one that does not exist, or the profile is broken.
    """
    chosen = profile if isinstance(profile, Profile) else find_profile(profile)
    seconds = chosen.seconds if seconds is None else seconds
    request = {
        "stage": os.fspath(stage),
        "jobs": jobs,
        "checks": None if checks is None else list(checks),
        "profile": asdict(chosen),
        "memory_bytes": chosen.memory_mb << 20 if memory_bytes is None else memory_bytes,
        "exhibits": None if exhibits is None else os.fspath(exhibits),
    }
    # OpenBLAS takes memory for each core; no check multiplies matrices.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    with subprocess.Popen(
        [sys.executable, "-c", _START, str(_ROOT)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=environment,
    ) as process:
        late = threading.Event()
        timer = threading.Timer(seconds, _end, (process, late))
        timer.start()
        try:
            answer = _answer(process, request, progress or (lambda share: None))
        finally:
            timer.cancel()
            process.kill()
    if "fault" in answer:
        raise _FAULTS[answer["fault"]](answer["message"])
    if "findings" in answer:
        findings = tuple(_finding(fields) for fields in answer["findings"])
        return Report(str(stage), findings, chosen.name)
    death = _death(process.returncode, late.is_set(), seconds)
    return Report(str(stage), (death,), chosen.name)


def _end(process: subprocess.Popen[bytes], late: threading.Event) -> None:
    late.set()
    process.kill()


def _answer(
    process: subprocess.Popen[bytes], request: dict[str, Any], progress: Callable[[float], None]
) -> dict[str, Any]:
    """Send `request` and return the last object that the child sends, empty where it has none."""
    assert process.stdin is not None
    answer: dict[str, Any] = {}
    with suppress(BrokenPipeError):
        process.stdin.write(json.dumps(request).encode())
        process.stdin.close()
    for message in _messages(process):
        if "share" not in message:
            answer = message
            break
        progress(message["share"])
    process.wait()
    return answer


def _messages(process: subprocess.Popen[bytes]) -> Iterator[dict[str, Any]]:
    """Yield what the child sends, up to a line that is cut short."""
    assert process.stdout is not None
    with suppress(json.JSONDecodeError):
        while line := process.stdout.readline(_MAX_LINE):
            yield json.loads(line)


def _finding(fields: dict[str, str]) -> Finding:
    return Finding(**{**fields, "status": Status[fields["status"]]})  # type: ignore[arg-type]


def _death(status: int, late: bool, seconds: float) -> Finding:
    if late:
        message = f"judging the stage took more than {seconds:g} s"
        return Finding(CHECK, Status.ERROR, LATE, message)
    how = f"ended with status {status}"
    if status < 0:
        how = f"was ended by {signal.Signals(-status).name}"
    message = f"the process that judges the stage {how}"
    return Finding(CHECK, Status.ERROR, CRASHED, message)
