"""A job of the Open Job Description that publishes drafts on a render farm, one a task.

Written as YAML whose every value is a JSON string or number, which YAML reads the same, so that
no text can be taken for something else.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence

from weaveusd.errors import InputError

MAX_TASKS = 1024
"""Drafts in one job: the longest list that the Open Job Description allows."""

MAX_VALUE = 1024
"""Characters of a parameter's value that it allows."""

TASK_SECONDS = 3600
"""Time that one publish gets."""


def job_template(
    drafts: Sequence[str],
    root: str,
    arguments: Sequence[str],
    *,
    name: str = "weaveusd publish",
    command: str = "weaveusd",
) -> str:
    """Return the job template, version ``jobtemplate-2023-09``, that publishes `drafts`.

    Each task runs ``weaveusd publish`` with one of `drafts` and `arguments`, tells the farm how it
    goes and fails with the publish. The job's parameters are `Root` and `Command`;
    a relative `root` is taken from the folder of the job's file.

    Raises
    ------
    InputError
        There is no draft or more than `MAX_TASKS`, or a value is too long, breaks a line, or holds
        what a farm would replace: ``{{``.
    """
    if not 1 <= len(drafts) <= MAX_TASKS:
        raise InputError(f"found {len(drafts)} drafts, expected 1 to {MAX_TASKS} in one job")
    for value in (*drafts, root, *arguments, name, command):
        _check(value)
    fixed = [
        "publish", "{{Task.Param.Draft}}", "--root", "{{Param.Root}}", "--progress", "openjd",
        "--result", "{{Session.WorkingDirectory}}/result.json", *arguments,
    ]  # fmt: skip
    return "\n".join(
        (
            "# openjd check job.yaml; openjd run job.yaml --step Publish",
            "specificationVersion: jobtemplate-2023-09",
            f"name: {_quoted(name)}",
            "parameterDefinitions:",
            *_root(root),
            "  - name: Command",
            "    type: STRING",
            '    description: "weaveusd, as it is called on the farm."',
            f"    default: {_quoted(command)}",
            "steps:",
            "  - name: Publish",
            "    parameterSpace:",
            "      taskParameterDefinitions:",
            "        - name: Draft",
            "          type: PATH",
            "          range:",
            *(f"            - {_quoted(draft)}" for draft in drafts),
            "    script:",
            "      actions:",
            "        onRun:",
            '          command: "{{Param.Command}}"',
            "          args:",
            *(f"            - {_quoted(argument)}" for argument in fixed),
            f"          timeout: {TASK_SECONDS}",
            "          cancelation:",
            "            mode: NOTIFY_THEN_TERMINATE",
            "            notifyPeriodInSeconds: 15",
            "",
        )
    )


def _root(root: str) -> list[str]:
    """Return the parameter `Root`. Of a path only a relative default is allowed."""
    kind = ["    type: STRING"]
    if not os.path.isabs(root):
        kind = ["    type: PATH", "    objectType: DIRECTORY", "    dataFlow: OUT"]
    return [
        "  - name: Root",
        *kind,
        '    description: "Folder that holds all assets."',
        f"    default: {_quoted(root)}",
    ]


def _check(value: str) -> None:
    if "{{" in value or not value.isprintable() or not 0 < len(value) <= MAX_VALUE:
        shown = repr(value if len(value) <= 80 else f"{value[:79]}…")
        raise InputError(
            f"found {shown}, expected 1 to {MAX_VALUE} printable characters without '{{{{'"
        )


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
