"""Time from the bytes of a WIF to its drawdown, beside pyweaving, on files that both can read.

    pip install -e '.[benchmark]' && python benchmarks/drafts.py

Both programs read the same generated files in the same run, and must weave the same drawdown.
Without pyweaving only our own times are printed. The least of three runs counts.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from weaveusd.draft.statistics import describe
from weaveusd.draft.wif import read_wif

SHAFTS = 24
CASES = ((1000, 2000, "treadling"), (1146, 8208, "liftplan"))


def generated(ends: int, picks: int, shed: str) -> str:
    """Return a WIF in the dialect that strict readers accept, of any threading and shed."""
    chance = np.random.default_rng(ends * picks)
    lifts = chance.random((SHAFTS, SHAFTS)) < 0.5
    lists = [",".join(map(str, np.flatnonzero(row) + 1)) or "1" for row in lifts]
    presses = chance.integers(0, SHAFTS, picks)
    sections = {
        "WIF": ["Version=1.1", "Date=April 20, 1997", "Source Program=benchmark"],
        "CONTENTS": [
            "COLOR PALETTE=true", "COLOR TABLE=true", "WEAVING=true", "WARP=true", "WEFT=true",
            "THREADING=true", "WARP COLORS=true", "WEFT COLORS=true",
            *(["LIFTPLAN=true"] if shed == "liftplan" else ["TIEUP=true", "TREADLING=true"]),
        ],
        "WEAVING": ["Rising Shed=true", f"Shafts={SHAFTS}", "Treadles=0"],
        "COLOR PALETTE": ["Entries=2", "Range=0,255", "Form=RGB"],
        "COLOR TABLE": ["1=0,0,0", "2=255,255,255"],
        "WARP": [f"Threads={ends}", "Color=1", "Units=centimeters", "Spacing=0.1"],
        "WEFT": [f"Threads={picks}", "Color=2", "Units=centimeters", "Spacing=0.1"],
        "THREADING": _rows(chance.integers(1, SHAFTS + 1, ends).tolist()),
        "WARP COLORS": _rows([1] * ends),
        "WEFT COLORS": _rows([2] * picks),
    }  # fmt: skip
    if shed == "liftplan":
        sections["LIFTPLAN"] = _rows([lists[n] for n in presses])
    else:
        sections["WEAVING"][-1] = f"Treadles={SHAFTS}"  # 0 with a liftplan, or pyweaving fails
        sections["TIEUP"] = _rows(lists)
        sections["TREADLING"] = _rows((presses + 1).tolist())
    return "\n".join(f"[{name}]\n" + "\n".join(rows) for name, rows in sections.items()) + "\n"


def _rows(values: list[Any]) -> list[str]:
    return [f"{n}={value}" for n, value in enumerate(values, 1)]


def ours(path: Path) -> np.ndarray:
    """Return the drawdown that weaveusd reads."""
    return read_wif(path).drawdown()


def theirs(path: Path) -> np.ndarray:
    """Return the drawdown that pyweaving reads."""
    from pyweaving import WarpThread
    from pyweaving.wif import WIFReader

    columns = WIFReader(str(path)).read().compute_drawdown()
    return np.array([[type(top) is WarpThread for top in column] for column in columns]).T


def least(work: Callable[[], Any], runs: int = 3) -> tuple[float, Any]:
    """Return the least of the seconds of some runs, and the result."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return min(times), result


def main() -> None:
    """Print a line for each case."""
    try:
        import pyweaving  # noqa: F401

        peer = True
    except ImportError:
        peer = False
        print("pyweaving is not installed: pip install -e '.[benchmark]'")
    for ends, picks, shed in CASES:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "generated.wif"
            path.write_text(generated(ends, picks, shed))
            seconds, drawdown = least(lambda path=path: ours(path))
            described, _ = least(lambda path=path: describe(read_wif(path)), 1)
            line = f"{ends} × {picks}, {shed}: weaveusd {seconds * 1000:.0f} ms"
            line += f" (with all statistics {described * 1000:.0f} ms)"
            if peer:
                peer_seconds, peer_drawdown = least(lambda path=path: theirs(path), 1)
                if not np.array_equal(drawdown, peer_drawdown):
                    raise SystemExit(f"{ends} × {picks}: the drawdowns differ")
                ratio = peer_seconds / seconds
                line += f", pyweaving {peer_seconds:.2f} s, ratio {ratio:.0f}, same drawdown"
            print(line)


if __name__ == "__main__":
    main()
