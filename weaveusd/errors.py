"""The exception tree: what outside data and outside machines can do wrong.

Every class carries the exit status that the command line answers with. A slip of the
programmer raises `ValueError` and the like; it is never caught and shown as a user's fault.
"""

from __future__ import annotations

from typing import Any, ClassVar


class WeaveusdError(Exception):
    """Something outside the program is wrong; the message is one line for its user."""

    exit_status: ClassVar[int] = 1


class InputError(WeaveusdError):
    """A file or value handed in is broken: draft, recipe, image or stage."""

    exit_status = 3


class DraftError(InputError):
    """A draft is broken; the message names file, line, section, found and expected."""


class RecipeError(InputError):
    """A recipe or preset is broken; the message names file, line and key."""


class StageError(InputError):
    """A USD stage cannot be opened or lacks what was asked of it."""


class ValidationFailedError(WeaveusdError):
    """What would have been published failed its own checks; nothing was written.

    `findings` are those of the report, as JSON types.
    """

    exit_status = 4

    def __init__(self, message: str, findings: list[dict[str, Any]]) -> None:
        super().__init__(message)
        self.findings = findings


class VersionConflictError(WeaveusdError):
    """The version asked for exists with other content."""

    exit_status = 5


class HookRefusedError(WeaveusdError):
    """The command that is asked before a publish refused it; nothing was written."""

    exit_status = 6


class HookFailedError(WeaveusdError):
    """The command that is told of a publish failed; the version is there and stays."""

    exit_status = 7


class RendererUnavailableError(WeaveusdError):
    """No renderer can run on this machine; the message says what to install."""
