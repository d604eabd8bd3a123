"""Hooks: asked and told with JSON, in time, and with nothing between them and the system."""

from __future__ import annotations

import json
import os
import sys
import time

import pytest

from weaveusd.hooks import hook_command, run_hook


def python(code: str) -> tuple[str, ...]:
    return (sys.executable, "-c", code)


def test_a_hook_reads_its_message_as_json():
    message = {"draft": "twill 織.wif", "seed": 3, "name": None}
    run = run_hook(python("import sys; print(sys.stdin.read())"), message)
    assert run.fault is None
    assert json.loads(run.stdout) == message


def test_the_last_line_on_stderr_is_why_a_hook_failed():
    run = run_hook(
        python("import sys; sys.exit('first\\nthe shot is locked\\n\\n')"), {"draft": "x"}
    )
    assert run.fault == "the shot is locked"


@pytest.mark.parametrize(
    ("code", "fault"),
    [
        ("import sys; sys.exit(3)", "ended with status 3"),
        ("import os; os.kill(os.getpid(), 9)", "was ended by SIGKILL"),
    ],
)
def test_a_silent_hook_is_told_by_how_it_ended(code, fault):
    assert run_hook(python(code), {}).fault.endswith(fault)


def test_a_hook_that_is_no_program_is_told_in_one_line(tmp_path):
    missing = str(tmp_path / "gone")
    assert run_hook((missing,), {}).fault == f"{missing}: cannot be run: No such file or directory"


def test_a_hook_need_not_read_and_may_say_more_than_is_kept():
    run = run_hook(
        python("import sys; sys.stderr.write('x' * 10_000_000 + '\\nlast'); sys.exit(1)"),
        {"long": "y" * 1_000_000},
    )
    assert run.fault == "last"
    assert len(run.stderr) <= 1 << 16


def test_a_hook_gets_no_more_than_its_time_nor_do_its_children(tmp_path):
    alive = tmp_path / "alive"
    child = f"import time; time.sleep(1.5); open({str(alive)!r}, 'w')"
    code = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {child!r}])"
    started = time.monotonic()
    run = run_hook(python(code), {}, seconds=0.5)
    assert run.fault.endswith("took more than 0.5 s")
    assert time.monotonic() - started < 1.4
    time.sleep(max(0.0, 2.5 - (time.monotonic() - started)))
    assert not alive.exists()


def test_a_process_that_a_hook_leaves_behind_is_not_waited_for():
    code = "import subprocess; subprocess.Popen(['sleep', '5']); print('done')"
    started = time.monotonic()
    run = run_hook(python(code), {})
    assert (run.fault, run.stdout) == (None, "done\n")
    assert time.monotonic() - started < 4


def test_no_shell_reads_a_hook(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = hook_command("printf %s '$HOME;' `touch here` \"a b\"")
    assert command == ("printf", "%s", "$HOME;", "`touch", "here`", "a b")
    run_hook(command, {})
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("text", ["", "  ", "'open", "a \\"])
def test_a_command_that_is_none_is_refused(text):
    with pytest.raises(ValueError, match=r"command|quotation|escaped"):
        hook_command(text)
