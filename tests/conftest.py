"""A usable renderer is chosen before any test can load one that aborts the process; fixtures."""

from __future__ import annotations

import contextlib
import sys

import pytest

from weaveusd import cli
from weaveusd.errors import RendererUnavailableError
from weaveusd.render import variant

with contextlib.suppress(RendererUnavailableError):
    variant.prepare()


@pytest.fixture
def renderer() -> None:
    """The renderer is active; a test that asks for it is skipped where there is none."""
    try:
        variant.prepare()
    except RendererUnavailableError as error:
        pytest.skip(str(error))


@pytest.fixture
def run(monkeypatch, capsys):
    """Run the command line in this process: (status, stdout, stderr)."""

    def run(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["weaveusd", *map(str, arguments)])
        with pytest.raises(SystemExit) as stop:
            cli.main()
        captured = capsys.readouterr()
        return int(stop.value.code or 0), captured.out, captured.err

    return run
