"""The command `lobes`: arguments, output and exit status."""

from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from weaveusd.cli import app
from weaveusd.proof import check

renders = pytest.mark.usefixtures("renderer")


def run(*arguments):
    return CliRunner().invoke(app, ["lobes", *arguments])


def test_the_files_that_were_drawn_are_told(tmp_path):
    done = run("polyester", "--out", str(tmp_path), "--angle", "40", "--format", "svg", "--json")
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["status"] == "drawn"
    assert sorted(told["files"]) == sorted(map(str, tmp_path.iterdir()))
    assert len(told["files"]) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "expected a preset, or --check"),
        (("linen", "--quick"), "--quick belongs to --check"),
        (("--check", "--published"), "leave --published"),
    ],
)
def test_arguments_that_contradict_are_refused(arguments, message):
    done = run(*arguments)
    assert done.exit_code == 2
    assert message in re.sub(r"[\s│]+", " ", done.output)


@renders
def test_the_check_prints_a_row_for_each_yarn_and_angle():
    done = run("linen", "shot_silk", "--check", "--quick")
    assert done.exit_code == 0, done.output
    assert done.stdout.count(" ok") == 3 * len(check.QUICK_ANGLES)
    assert "0 of 6 rows are out of bounds" in done.stdout


@renders
def test_a_check_out_of_bounds_exits_with_1(monkeypatch):
    monkeypatch.setattr(check, "ALBEDO_LIMIT", 0.1)
    done = run("linen", "--check", "--quick", "--json")
    assert done.exit_code == 1
    told = json.loads(done.stdout)
    assert told["status"] == "failed"
    assert told["failed"] == 2
    assert all(row["faults"] == ["more light than comes in"] for row in told["rows"])
