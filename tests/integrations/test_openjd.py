"""A job for a render farm: valid, run for real, and safe from what drafts are called."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from weaveusd.errors import InputError
from weaveusd.integrations.openjd import MAX_TASKS, job_template
from weaveusd.validate.verify import verify

DRAFTS = Path(__file__).parents[2] / "examples" / "drafts"
BIN = Path(sys.executable).parent
WEAVEUSD = BIN / "weaveusd"
OPENJD = shutil.which("openjd", path=str(BIN)) or shutil.which("openjd")

needs_openjd = pytest.mark.skipif(OPENJD is None, reason="openjd-cli is not installed")


def template(run, *arguments: object) -> str:
    status, out, err = run("farm-template", *arguments)
    assert (status, err) == (0, "")
    return out


def openjd(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(OPENJD), *arguments], cwd=folder, capture_output=True, text=True, timeout=300
    )


@needs_openjd
@pytest.mark.parametrize("root", ["assets", "/mnt/a b/assets"])
def test_a_job_passes_the_check_of_openjd(run, tmp_path, root):
    job = template(run, DRAFTS / "plain.wif", DRAFTS / "satin_5.wif", "--root", root,
                   "--options", "--preset linen", "--job-name", 'cloths: "all"')  # fmt: skip
    (tmp_path / "job.yaml").write_text(job)
    checked = openjd(tmp_path, "check", "job.yaml")
    assert checked.returncode == 0, checked.stdout
    summary = openjd(tmp_path, "summary", "job.yaml")
    assert summary.returncode == 0, summary.stdout
    assert 'cloths: "all"' in summary.stdout
    assert f'default: "{root}"' in job


@needs_openjd
@pytest.mark.slow
def test_a_job_publishes_every_draft_and_one_that_fails_fails_its_task(run, tmp_path):
    odd = tmp_path / "it's; 'odd' $HOME {draft}.wif"
    shutil.copy(DRAFTS / "satin_5.wif", odd)
    job = template(run, DRAFTS / "plain.wif", odd, "--root", "assets", "--command", WEAVEUSD,
                   "--options", "--preset linen --resolution 32")  # fmt: skip
    (tmp_path / "job.yaml").write_text(job)
    done = openjd(tmp_path, "run", "job.yaml", "--step", "Publish")
    assert done.returncode == 0, done.stdout
    assert "openjd_progress: 100.0" in done.stdout
    names = ["it_s_odd_HOME_draft_linen", "plain_linen"]
    assert sorted(p.name for p in (tmp_path / "assets").iterdir()) == names
    for name in names:
        assert verify(tmp_path / "assets" / name).intact
    odd.write_text("no draft")
    failed = openjd(tmp_path, "run", "job.yaml", "--step", "Publish")
    assert failed.returncode == 1
    assert "openjd_fail: " in failed.stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--preset linen --resolution much", "--resolution"),
        ("--preset linen --root elsewhere", "--root, which the job decides"),
        ("--preset linen --json", "--json"),
        ("--preset 'linen", "quotation"),
        ("--colour red", "--colour"),
    ],
)
def test_options_that_a_publish_would_refuse_are_refused_at_once(run, options, message):
    status, out, err = run("farm-template", DRAFTS / "plain.wif", "--root", "x",
                           "--options", options)  # fmt: skip
    assert (status, out) == (2, "")
    assert message in err


def test_a_draft_that_is_not_there_is_told(run, tmp_path):
    status, _, err = run("farm-template", tmp_path / "gone.wif", "--root", "x",
                         "--options", "--preset linen")  # fmt: skip
    assert status == 3
    assert "gone.wif: no such file" in err


@pytest.mark.parametrize(
    "name", ["{{Param.Root}}.wif", "a\nb.wif", "", "x" * 1025, "\ud800.wif", "\u202e.wif"]
)
def test_a_name_that_a_farm_would_read_as_more_than_a_name_is_refused(name):
    with pytest.raises(InputError, match="printable characters without"):
        job_template([name], "assets", ["--preset", "linen"])


@pytest.mark.parametrize("count", [0, MAX_TASKS + 1])
def test_a_job_has_no_more_tasks_than_a_farm_takes(count):
    with pytest.raises(InputError, match="drafts, expected 1 to 1024"):
        job_template(["a.wif"] * count, "assets", [])
