"""Find an LLVM that Mitsuba can use, without loading one that kills the process.

Dr.Jit loads libLLVM when it is imported. Versions 15 and 16 load and then abort the whole
process at the first maximum, which no `try` can catch. So the version is read from the file's
name, and what is left is tried once in a child process.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

OLDEST_USABLE = 19
PATH_VARIABLE = "DRJIT_LIBLLVM_PATH"
ADVICE = "install one with `apt-get install libllvm19`, or without root with `make llvm`"

_NAME = re.compile(r"^libLLVM(?:-(\d+)(?:\.[\d.]+)?\.so(?:\.[\d.]+)?|\.so\.(\d+)(?:\.\d+)*)$")
_SYSTEM_FOLDERS = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
    "/usr/local/lib",
)
_PROBE_SECONDS = 120
_PROBE = """
import sys
from weaveusd.render.llvm import preload
from pathlib import Path
preload(Path(sys.argv[1]))
import drjit as dr
from drjit.llvm import Float
x = dr.maximum(Float(1, 2, 3), Float(2, 2, 2)) + dr.safe_sqrt(Float(1, 4, -9))
sys.exit(0 if list(x) == [3, 4, 3] else 1)
"""


def private_folder() -> Path:
    """Return the folder of the environment where `make llvm` unpacks a libLLVM."""
    return Path(sys.prefix) / "lib" / "weaveusd-llvm"


def version_of(library: Path) -> int | None:
    """Return LLVM's major version as the file name tells it, following links; None if untold."""
    for path in (library, library.resolve()):
        match = _NAME.match(path.name)
        if match:
            return int(match[1] or match[2])
    return None


def candidates() -> Iterator[Path]:
    """Yield usable-looking libraries, best first.

    The file of `DRJIT_LIBLLVM_PATH`, then the environment's own folder, then the system's
    folders with the newest version first.
    """
    named = os.environ.get(PATH_VARIABLE)
    if named and Path(named).is_file() and _new_enough(Path(named), unknown=True):
        yield Path(named)
    yield from _newest_first([private_folder()])
    yield from _newest_first(
        [*map(Path, _SYSTEM_FOLDERS), *sorted(Path("/usr/lib").glob("llvm-*/lib"))]
    )


def preload(library: Path) -> None:
    """Load what lies beside a privately unpacked `library`, so that its own loading succeeds.

    A library is loaded once everything it needs is there: the folder is gone through until
    nothing new can be loaded. Folders of the system need no help and are left alone.
    """
    folder = library.parent
    if str(folder).startswith(("/usr/", "/lib")):
        return
    waiting = sorted(p for p in folder.glob("*.so*") if not p.name.startswith("libLLVM"))
    while waiting:
        left = [p for p in waiting if not _load(p)]
        if len(left) == len(waiting):
            return
        waiting = left


def usable(library: Path) -> bool:
    """Return whether a child process could compile and run a kernel with `library`.

    The answer is kept in the user's cache folder, keyed by the file's path, time and size and
    by the version of Dr.Jit.
    """
    note = _note_of(library)
    try:
        return bool(json.loads(note.read_text())["usable"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    verdict = _probe(library)
    try:
        note.parent.mkdir(parents=True, exist_ok=True)
        part = note.with_suffix(f".{os.getpid()}")
        part.write_text(json.dumps({"library": str(library), "usable": verdict}))
        part.replace(note)
    except OSError:
        pass  # a read-only home only costs the next process a second probe
    return verdict


def find() -> Path | None:
    """Return the first candidate that passes its trial, or None."""
    return next((library for library in candidates() if usable(library)), None)


def _new_enough(library: Path, *, unknown: bool) -> bool:
    major = version_of(library)
    return unknown if major is None else major >= OLDEST_USABLE


def _newest_first(folders: list[Path]) -> list[Path]:
    """Return one library a version from `folders`, newest first."""
    found: dict[int, Path] = {}
    for folder in folders:
        for path in sorted(folder.glob("libLLVM*.so*")):
            major = version_of(path)
            if major is not None and major >= OLDEST_USABLE and path.is_file():
                found.setdefault(major, path)
    return [found[major] for major in sorted(found, reverse=True)]


def _load(library: Path) -> bool:
    try:
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    except OSError:
        return False
    return True


def _probe(library: Path) -> bool:
    environment = {**os.environ, PATH_VARIABLE: str(library)}
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE, str(library)],
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=_PROBE_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return done.returncode == 0


def _note_of(library: Path) -> Path:
    """Return the file that keeps the verdict on `library` as it is now."""
    state = library.stat()
    try:
        drjit = version("drjit")
    except PackageNotFoundError:
        drjit = ""
    key = f"{library}\n{state.st_mtime_ns}\n{state.st_size}\n{drjit}\n{sys.version}"
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return cache / "weaveusd" / f"llvm-{hashlib.sha256(key.encode()).hexdigest()[:24]}.json"
