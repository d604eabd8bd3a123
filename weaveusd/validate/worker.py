"""The child of `weaveusd.validate.apart`: reads one request, judges one stage, answers in JSON."""

from __future__ import annotations

import json
import os
import resource
import sys
from pathlib import Path
from typing import Any, BinaryIO

from weaveusd.errors import InputError


def main() -> None:
    """Answer the request on stdin where stdout was; what libraries print goes to stderr."""
    request = json.loads(sys.stdin.buffer.read())
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        _limit(request["memory_bytes"])
        _send(answers, _judge(request, answers))


def _limit(memory_bytes: int) -> None:
    """Let this process hold so much data, and leave no core behind."""
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    allowed = memory_bytes if hard == resource.RLIM_INFINITY else min(memory_bytes, hard)
    resource.setrlimit(resource.RLIMIT_DATA, (allowed, allowed))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _judge(request: dict[str, Any], answers: BinaryIO) -> dict[str, Any]:
    from weaveusd.validate.profiles import Profile
    from weaveusd.validate.run import examine

    try:
        report, asset = examine(
            request["stage"],
            jobs=request["jobs"],
            checks=request["checks"],
            profile=Profile(**request["profile"]),
            progress=lambda share: _send(answers, {"share": share}),
        )
    except InputError as error:
        return {"fault": type(error).__name__, "message": str(error)}
    if request["exhibits"] is not None:
        from weaveusd.validate.report.gather import gather

        Path(request["exhibits"]).write_text(json.dumps(gather(asset)), encoding="utf-8")
    return {"findings": [finding.as_dict() for finding in report.findings]}


def _send(answers: BinaryIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message).encode() + b"\n")
    answers.flush()
