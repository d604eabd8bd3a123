"""Profiles are data: ours, a studio's by entry point, anybody's by file."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from weaveusd.errors import InputError
from weaveusd.validate import profiles
from weaveusd.validate.profiles import find_profile, profile_names, read_profile
from weaveusd.validate.registry import all_checks

STUDIO = """\
name = "lookdev"
about = "What lookdev signs."
checks = ["texture", "path/anchored", "render"]
without = ["render/noise"]

[render]
size = 64
spp = 16

[tolerance]
delta_e = 1
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "lookdev.toml"
    path.write_text(STUDIO)
    return path


def test_three_come_with_us_and_each_runs_all_that_the_one_before_runs() -> None:
    assert profile_names()[:3] == ("quick", "standard", "full")
    ran: set[str] = set()
    for name in ("quick", "standard", "full"):
        profile = find_profile(name)
        runs = {check.id for check in all_checks() if profile.runs(check.id)}
        assert profile.name == name
        assert profile.about.endswith(".")
        assert ran <= runs
        ran = runs
    assert ran == {check.id for check in all_checks()}


def test_the_quick_one_renders_nothing() -> None:
    quick = find_profile("quick")
    rendering = [check.id for check in all_checks() if "renderer" in check.needs]
    assert rendering
    assert not any(quick.runs(check) for check in rendering)


def test_a_file_says_what_runs_and_how_closely(file: Path) -> None:
    profile = find_profile(file)
    assert (profile.name, profile.size, profile.spp, profile.delta_e) == ("lookdev", 64, 16, 1)
    assert profile.runs("texture/tiles")
    assert profile.runs("render/swatch")
    assert not profile.runs("render/noise")
    assert not profile.runs("agreement/draft")


def test_a_package_adds_one_by_an_entry_point(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "studio_profiles.py").write_text(f"LOOKDEV = {str(file)!r}\n")
    monkeypatch.syspath_prepend(tmp_path)
    points = [
        EntryPoint("lookdev", "studio_profiles:LOOKDEV", profiles.GROUP),
        EntryPoint("quick", "studio_profiles:LOOKDEV", profiles.GROUP),
    ]
    monkeypatch.setattr(profiles, "entry_points", lambda group: points)
    assert find_profile("lookdev") == read_profile(file)
    assert find_profile("quick").name == "quick", "nobody takes a name of ours"


def test_an_entry_point_that_leads_nowhere_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    points = [EntryPoint("lost", "no_such_module:PATH", profiles.GROUP)]
    monkeypatch.setattr(profiles, "entry_points", lambda group: points)
    with pytest.raises(InputError, match=r"entry point lost of weaveusd\.profiles"):
        find_profile("lost")
    assert find_profile("quick").name == "quick", "a broken neighbour disturbs nobody"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "lookdev"', "", "name is missing"),
        ('"path/anchored"', '"path/anchors"', "names 'path/anchors', which is no check"),
        ("size = 64", "size = 1000000", r"\[render\] size is 1000000, expected 16 to 2048"),
        ("spp = 16", "spp = true", "spp is True, expected a whole number"),
        ("spp = 16", "spq = 16", "unknown key 'spq'"),
        ("delta_e = 1", "delta_e = nan", "delta_e is nan"),
        ("[render]", "[render", "no TOML"),
        ("checks = [", "checks = 3 #[", "checks is 3, expected a list"),
    ],
)
def test_a_broken_profile_is_one_line_that_names_the_key(
    file: Path, old: str, new: str, message: str
) -> None:
    file.write_text(STUDIO.replace(old, new))
    with pytest.raises(InputError, match=message) as error:
        find_profile(file)
    assert str(error.value).startswith(str(file))
    assert "\n" not in str(error.value)


def test_a_profile_that_is_not_there_says_which_are(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no profile 'slow', expected full, quick, standard"):
        find_profile("slow")
    with pytest.raises(InputError, match="cannot be read"):
        find_profile(tmp_path / "absent.toml")
