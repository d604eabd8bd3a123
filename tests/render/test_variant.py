from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from weaveusd.errors import InputError, RendererUnavailableError
from weaveusd.render import llvm, variant

SCRIPT = Path(__file__).parents[2] / "scripts" / "fetch_llvm.sh"


@pytest.mark.parametrize(
    ("name", "major"),
    [
        ("libLLVM.so.19.1", 19),
        ("libLLVM-19.so", 19),
        ("libLLVM-14.so.1", 14),
        ("libLLVM-14.0.6.so.1", 14),
        ("libLLVM-19.so.1", 19),
        ("libLLVM.so.22.1", 22),
        ("libLLVM.so", None),
        ("libLLVMCore-19.so", None),
        ("libclang-19.so", None),
    ],
)
def test_the_version_is_read_from_the_name(name: str, major: int | None) -> None:
    assert llvm.version_of(Path("/somewhere") / name) == major


def test_a_link_tells_the_version_of_its_target(tmp_path: Path) -> None:
    (tmp_path / "libLLVM.so.19.1").touch()
    (tmp_path / "libLLVM.so").symlink_to("libLLVM.so.19.1")
    assert llvm.version_of(tmp_path / "libLLVM.so") == 19


def folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, private: list[str], system: list[str]
) -> None:
    """Pretend that these files are all the libraries of the machine."""
    monkeypatch.delenv(llvm.PATH_VARIABLE, raising=False)
    for folder, names in (("private", private), ("system", system)):
        (tmp_path / folder).mkdir()
        for name in names:
            (tmp_path / folder / name).touch()
    monkeypatch.setattr(llvm, "private_folder", lambda: tmp_path / "private")
    monkeypatch.setattr(llvm, "_SYSTEM_FOLDERS", (str(tmp_path / "system"),))


def listed(tmp_path: Path) -> list[str]:
    """The candidates of the pretended folders, in order."""
    return [
        str(path.relative_to(tmp_path))
        for path in llvm.candidates()
        if path.is_relative_to(tmp_path)
    ]


def test_old_libraries_are_never_touched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folders(tmp_path, monkeypatch, [], [f"libLLVM-{k}.so.1" for k in range(14, 19)])
    assert listed(tmp_path) == []


def test_the_environment_comes_first_then_the_private_folder_then_the_newest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folders(tmp_path, monkeypatch, ["libLLVM.so.19.1"], ["libLLVM.so.20.1", "libLLVM-22.so"])
    named = tmp_path / "mine.so"
    named.touch()
    monkeypatch.setenv(llvm.PATH_VARIABLE, str(named))
    assert listed(tmp_path) == [
        "mine.so",
        "private/libLLVM.so.19.1",
        "system/libLLVM-22.so",
        "system/libLLVM.so.20.1",
    ]
    old = tmp_path / "libLLVM-15.so"
    old.touch()
    monkeypatch.setenv(llvm.PATH_VARIABLE, str(old))
    assert "libLLVM-15.so" not in listed(tmp_path)


def test_a_library_is_tried_once_and_the_verdict_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    library = tmp_path / "libLLVM-19.so"
    library.write_bytes(b"no library")
    trials: list[Path] = []

    def probe(path: Path) -> bool:
        trials.append(path)
        return len(trials) > 1

    monkeypatch.setattr(llvm, "_probe", probe)
    assert [llvm.usable(library), llvm.usable(library)] == [False, False]
    assert trials == [library]
    os.utime(library, (1, 1))  # another file under the same name is tried again
    assert llvm.usable(library)
    assert len(trials) == 2


def test_what_is_no_library_fails_its_trial(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    library = tmp_path / "libLLVM-19.so"
    library.write_bytes(b"no library")
    assert not llvm.usable(library)


def test_a_read_only_cache_does_no_harm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    library = tmp_path / "libLLVM-19.so"
    library.touch()
    monkeypatch.setattr(llvm, "_probe", lambda _: True)
    assert llvm.usable(library)


def test_neighbours_are_loaded_in_an_order_that_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("liba.so.1", "libb.so.1", "libbroken.so.1", "libc.so.1", "libLLVM.so.19.1"):
        (tmp_path / name).touch()
    needs = {"liba.so.1": {"libb.so.1"}, "libb.so.1": {"libc.so.1"}, "libbroken.so.1": {"x"}}
    loaded: list[str] = []

    def load(path: Path) -> bool:
        ready = needs.get(path.name, set()) <= set(loaded)
        if ready:
            loaded.append(path.name)
        return ready

    monkeypatch.setattr(llvm, "_load", load)
    llvm.preload(tmp_path / "libLLVM.so.19.1")
    assert loaded == ["libc.so.1", "libb.so.1", "liba.so.1"]


def test_an_unknown_variant_is_refused() -> None:
    with pytest.raises(InputError, match="unknown variant 'llvm': expected one of cuda_ad_rgb"):
        variant.prepare("llvm")


def test_cuda_without_a_device_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(variant, "cuda_works", lambda: False)
    with pytest.raises(RendererUnavailableError, match="needs an NVIDIA GPU"):
        variant.prepare("cuda_ad_rgb")


def in_a_fresh_process(code: str) -> str:
    environment = {k: v for k, v in os.environ.items() if k != llvm.PATH_VARIABLE}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    return done.stdout + done.stderr


NONE_FOUND = """
from weaveusd.errors import RendererUnavailableError
from weaveusd.render import llvm, variant
variant.cuda_works = lambda: False
llvm.candidates = lambda: iter(())
try:
    variant.prepare()
except RendererUnavailableError as error:
    print(error)
"""


def test_without_any_llvm_one_line_says_what_to_install() -> None:
    said = in_a_fresh_process(NONE_FOUND)
    assert said == (
        "rendering needs libLLVM 19 or newer: install one with `apt-get install libllvm19`, "
        "or without root with `make llvm`\n"
    )


@pytest.mark.parametrize("taken", ["(15, 0, 6)", "(-1, -1, -1)"])
def test_a_bad_llvm_that_is_loaded_already_is_named(taken: str) -> None:
    # Stands in for `import drjit` with such an LLVM, which not every machine has.
    fake = (
        "import sys, types\n"
        "sys.modules['drjit'] = dr = types.ModuleType('drjit')\n"
        f"dr.detail = types.SimpleNamespace(llvm_version=lambda: {taken})\n"
    )
    said = in_a_fresh_process(fake + NONE_FOUND)
    named = "LLVM 15" if "15" in taken else "no LLVM"
    assert said.count("\n") == 1
    assert f"drjit was imported before weaveusd and took {named}" in said


def test_importing_the_package_imports_no_renderer() -> None:
    said = in_a_fresh_process(
        "import sys, weaveusd, weaveusd.render, weaveusd.render.run\n"
        "print([m for m in ('pxr', 'mitsuba', 'drjit', 'OpenImageIO') if m in sys.modules])"
    )
    assert said == "[]\n"


def test_fetching_twice_does_nothing_the_second_time() -> None:
    destination = llvm.private_folder()
    if not any(destination.glob("libLLVM*")):
        pytest.skip("no private libLLVM: `make llvm` was not run")
    before = sorted(p.stat().st_mtime_ns for p in destination.iterdir())
    done = subprocess.run(
        ["sh", str(SCRIPT), str(destination)], capture_output=True, text=True, check=True
    )
    assert (done.stdout, done.stderr) == ("", "")
    assert sorted(p.stat().st_mtime_ns for p in destination.iterdir()) == before


def test_failing_to_fetch_is_one_line_and_no_error(tmp_path: Path) -> None:
    # A machine without package tools: only what the script needs to look around.
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in ("basename", "sed", "ldd", "grep", "id"):
        (tools / name).symlink_to(f"/usr/bin/{name}")
    done = subprocess.run(
        ["/bin/sh", str(SCRIPT), str(tmp_path / "dest")],
        env={"PATH": str(tools)},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.stderr == "":
        pytest.skip("the system has a libLLVM 19 already")
    assert done.returncode == 0
    assert done.stderr.count("\n") == 1
    assert "render needs libllvm19" in done.stderr
    assert "publish works without" in done.stderr
    assert not (tmp_path / "dest").exists()
