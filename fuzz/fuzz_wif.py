"""Mutate drafts and read them: anything but a draft or a WeaveusdError is a fault.

    python fuzz/fuzz_wif.py --runs 1000000
    python fuzz/fuzz_wif.py --seconds 60 --seed 7

Seeds are the drafts of examples/drafts, of `--seeds FOLDER`, and of ../shared/corpus where that
is. The state of a run follows from its seed. Prints runs, faults, peak memory and the slowest
input; faults are kept in `--keep FOLDER`. Exits with 1 when there was a fault, or an input took
longer than `--slow` seconds of the processor or the memory went beyond 512 MB.
"""

from __future__ import annotations

import argparse
import random
import resource
import sys
import time
import traceback
from pathlib import Path

from weaveusd.draft.model import drawdown_sha256
from weaveusd.draft.wif import parse_wif
from weaveusd.draft.write import write_wif
from weaveusd.errors import WeaveusdError

ROOT = Path(__file__).parents[1]
LARGEST_SEED = 6000
PEAK_LIMIT_MB = 512

TOKENS = tuple(
    token.encode("utf-8")
    for token in (
        "[WIF]", "[WARP]", "[WEFT]", "[WEAVING]", "[THREADING]", "[TIEUP]", "[TREADLING]",
        "[LIFTPLAN]", "[COLOR PALETTE]", "[COLOR TABLE]", "[WARP COLORS]", "[WEFT SPACING]",
        "[WARP THICKNESS]", "[NOTES]", "[TEXT]", "[YARNS]", "[PRIVATE X Y]", "[", "]", "[]", "[2]A",
        "Threads=", "Shafts=", "Treadles=", "Rising Shed=", "Color=", "Range=", "Entries=",
        "Units=", "Spacing=", "Thickness=", "Spacing Zoom=", "Title=", "Inches", "Decipoints",
        "0", "1", "-1", "255", "65536", "1048577", "2147483647", "99999999999999999999", "1e309",
        "nan", "inf", "1_000", "0,05", "1.5", "0=", "0=0", "1=", "2=1,2", ",", ",,", ";", "=", "==",
        "\n", "\r", "\r\n", "\n\n", "\0", "\x1b[31m", "\ufeff", "é", "١٢", "\u2028", "%",
        "true", "no",
    )
)  # fmt: skip


def mutated(data: bytes, seeds: list[bytes], chance: random.Random) -> bytes:
    """Return `data` after one to six changes: bytes, tokens, lines, or parts of another seed."""
    changed = bytearray(data)
    for _ in range(chance.randint(1, 6)):
        at = chance.randrange(len(changed) + 1)
        to = min(len(changed), at + chance.choice((1, 2, 8, 64)))
        kind = chance.randrange(8)
        if kind == 0 and at < len(changed):
            changed[at] = chance.randrange(256)
        elif kind == 1:
            changed[at:to] = b""
        elif kind in (2, 3):
            changed[at:at] = chance.choice(TOKENS)
        elif kind == 4:
            changed[at:to] = chance.choice(TOKENS)
        elif kind == 5:
            changed[at:at] = changed[at:to] * chance.choice((1, 2, 50))
        elif kind == 6:
            other = chance.choice(seeds)
            start = chance.randrange(len(other))
            changed[at:at] = other[start : start + chance.choice((16, 256))]
        else:
            _swap_value(changed, chance)
    return bytes(changed)


def _swap_value(changed: bytearray, chance: random.Random) -> None:
    """Replace what stands behind one of the equals signs."""
    start = changed.find(b"=", chance.randrange(len(changed) + 1))
    if start >= 0:
        end = changed.find(b"\n", start)
        end = len(changed) if end < 0 else end
        changed[start + 1 : end] = chance.choice(TOKENS)


def try_one(data: bytes, thorough: bool) -> None:
    """Read `data`; where it is a draft and `thorough`, weave it, write it and read it back."""
    try:
        draft = parse_wif(data, "fuzz.wif")
        if thorough and draft.ends * draft.picks < 2**20:
            drawdown_sha256(draft)
            if parse_wif(write_wif(draft), "again.wif") != draft:
                raise AssertionError("what was written is read as another draft")
    except WeaveusdError as error:
        if "\n" in str(error):
            raise AssertionError("a message of two lines") from error


def load_seeds(folders: list[Path]) -> list[bytes]:
    """Return the drafts in the folders, those small enough to mutate quickly."""
    files = sorted(path for folder in folders for path in folder.glob("*.wif"))
    return [data for path in files if len(data := path.read_bytes()) <= LARGEST_SEED]


def main() -> int:
    """Fuzz as the arguments say and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=1_000_000)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--slow", type=float, default=2.0)
    parser.add_argument("--seeds", type=Path, action="append", default=[])
    parser.add_argument("--keep", type=Path, default=None)
    options = parser.parse_args()
    corpus = ROOT.parent / "shared" / "corpus"
    seeds = load_seeds([ROOT / "examples" / "drafts", corpus, *options.seeds])
    chance = random.Random(options.seed)
    start = time.perf_counter()
    runs = faults = 0
    slowest, slowest_data = 0.0, b""
    while runs < options.runs and time.perf_counter() - start < options.seconds:
        data = mutated(chance.choice(seeds), seeds, chance)
        before = time.process_time()
        try:
            try_one(data, thorough=runs % 16 == 0)
        except Exception:
            faults += 1
            sys.stderr.write(f"run {runs}: {traceback.format_exc()}\n")
            _keep(options.keep, f"fault-{options.seed}-{runs}.wif", data)
        took = time.process_time() - before
        if took > slowest:
            slowest, slowest_data = took, data
        runs += 1
    peak = _peak_mb()
    _keep(options.keep, f"slowest-{options.seed}.wif", slowest_data)
    sys.stdout.write(
        f"{len(seeds)} seeds, {runs} runs, {time.perf_counter() - start:.0f} s, {faults} faults, "
        f"peak {peak:.0f} MB, slowest {slowest * 1000:.0f} ms of {len(slowest_data)} bytes\n"
    )
    return 1 if faults or slowest > options.slow or peak > PEAK_LIMIT_MB else 0


def _peak_mb() -> float:
    """Return the most memory that this program held; getrusage counts its parent's too."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    kilobytes = next(x for x in status.read_text().splitlines() if x.startswith("VmHWM:"))
    return int(kilobytes.split()[1]) / 1024


def _keep(folder: Path | None, name: str, data: bytes) -> None:
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)


if __name__ == "__main__":
    sys.exit(main())
