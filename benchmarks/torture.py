"""What a publish leaves behind when it is killed, runs out of disk or races with others.

    python benchmarks/torture.py [--steps N] [--kills N] [--sizes N] [--rounds N] [--json]

Four parts, each with a count of trials, of those after which only old versions were there, of those
that left a new one, and of faults. A fault is a version that is not whole to the last bit, an old
one that is gone, or a remain that the next run does not remove; the exit status is 1 where there is
any. `steps` ends a publish by SIGKILL before each of its calls that touch the disk, `kills` real
publishes at random moments, `sizes` publishes on a file system with ever more room, and `rounds`
lets eight processes publish the same cloth at once, another one each round.

The file system is a tmpfs in a mount namespace of its own. Where none is permitted, the size of
each file is limited instead, and the table says so.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import multiprocessing
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # children are forked, which threads do not survive

from weaveusd import pipeline
from weaveusd.errors import WeaveusdError
from weaveusd.export.locks import staging_folder
from weaveusd.export.publish import publish_asset
from weaveusd.patch import Patch
from weaveusd.validate.verify import verify

DRAFT = Path(__file__).parents[1] / "examples" / "drafts" / "plain.wif"
TEXELS = 16
PUBLISHERS = 8
MOUNTED = "--mounted"

# Calls that Python tells of before it makes them, of all that change a disk or look at one.
EVENTS = frozenset(
    ("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.scandir", "os.listdir",
     "os.link", "fcntl.flock", "shutil.rmtree", "tempfile.mkdtemp")
)  # fmt: skip


@dataclass(slots=True)
class Count:
    """What became of the trials of one part."""

    part: str
    trials: int = 0
    old: int = 0
    new: int = 0
    remains: int = 0
    faults: list[str] = field(default_factory=list)
    notes: dict[str, int] = field(default_factory=dict)

    def note(self, what: str, times: int = 1) -> None:
        """Count how a trial ended."""
        self.notes[what] = self.notes.get(what, 0) + times


def cloth(root: Path, seed: int, jobs: int = 1) -> str:
    """Publish a small cloth and return what became of it."""
    done = pipeline.publish(
        DRAFT, preset="linen", root=root, resolution=TEXELS, seed=seed, jobs=jobs
    )
    return done.asset.status


def tiny(root: Path, text: str) -> None:
    """Publish two small files as an asset."""

    def write(folder: Path) -> None:
        (folder / "textures").mkdir()
        (folder / "textures" / "a.bin").write_text(text * 1000)
        (folder / "tiny.usda").write_text("#usda 1.0\n")

    publish_asset(root, "tiny", write)


def warm_up() -> None:
    """Load code and make a cloth in memory, so that each child has that already.

    What starts threads, as USD's registry and OpenImageIO do, is left to the children.
    """
    for module in ("export.asset", "validate.checks", "validate.run"):
        import_module(f"weaveusd.{module}")
    recipe = pipeline.read_recipe(preset="linen", recipe=None)
    pipeline.make_material(pipeline.read_draft(DRAFT), recipe, "cloth", patch=Patch(TEXELS), jobs=1)


def forked(action: Callable[[], str | None]) -> tuple[int, int]:
    """Run `action` in a child; return its id and a descriptor that tells how it ended."""
    read, write = os.pipe()
    child = os.fork()
    if child:
        os.close(write)
        return child, read
    said = "ended"
    try:
        said = action() or "done"
    except WeaveusdError as error:
        said = f"refused: {error}"
    except BaseException as error:
        said = f"broke: {type(error).__name__}: {error}"
    finally:
        with contextlib.suppress(OSError):
            os.write(write, said.encode("utf-8", "replace")[:4000])
        os._exit(0)


def ended(child: int, read: int) -> str:
    """Wait for a child and return what it said, nothing where it was killed."""
    os.waitpid(child, 0)
    with open(read, "rb") as file:
        return file.read().decode()


def states(root: Path) -> dict[str, dict[str, bool]]:
    """Return for each asset below `root` whether each of its versions is whole."""
    homes = [home for home in root.glob("*") if list(home.glob("v*"))]
    return {
        home.name: {v.folder.name: not v.differences for v in verify(home).versions}
        for home in homes
    }


def judge(count: Count, root: Path, before: dict[str, dict[str, bool]], what: str) -> None:
    """Count a trial by what is below `root` now, and have the next run clean up."""
    count.trials += 1
    found = states(root)
    for home, versions in found.items():
        count.faults += [f"{what}: {home}/{v} is a mixture" for v, ok in versions.items() if not ok]
    for home, versions in before.items():
        lost = versions.keys() - found.get(home, {}).keys()
        count.faults += [f"{what}: {home}/{version} is gone" for version in sorted(lost)]
    if found == before:
        count.old += 1
    else:
        count.new += 1
    for home in list(root.glob("*")):
        count.remains += bool(list(home.glob(".*")))
        with staging_folder(home):
            pass  # what every publish does first
        left = list(home.glob(".*")) if home.exists() else []
        count.faults += [f"{what}: {path.name} stays behind" for path in left]


def steps(most: int) -> Count:
    """Kill a first and a second publish before each of their calls to the disk, `most` at most."""
    count = Count("SIGKILL before each step on disk")
    for other_before in (False, True):
        for step in range(1, most + 1):
            with scratch() as root:
                if other_before:
                    tiny(root, "old")
                before = states(root)
                said = ended(*forked(lambda root=root, step=step: dying(root, step)))
                if said:
                    break
                judge(count, root, before, f"step {step}")
    return count


def dying(root: Path, step: int) -> None:
    """Publish, and end by SIGKILL just before call number `step` that touches the disk."""
    made = 0

    def count(event: str, _: object) -> None:
        nonlocal made
        if event in EVENTS:
            made += 1
            if made == step:
                os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(count)
    tiny(root, "new")


def kills(trials: int) -> Count:
    """Kill publishes of a cloth at random moments, until so many have not outrun it."""
    count = Count("SIGKILL at a random moment")
    seed = random.Random(0)
    with scratch() as root:
        usual, cloth_number = timed(root, 0), 0
        while count.notes.get("killed", 0) < trials and cloth_number < 5 * trials:
            cloth_number += 1
            before = states(root)
            child, read = forked(lambda number=cloth_number: cloth(root, number))
            time.sleep(seed.uniform(0.0, usual))
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            said = ended(child, read)
            count.note(said.split(":")[0] or "killed")
            judge(count, root, before, f"kill of cloth {cloth_number}")
            if said.startswith("broke"):
                count.faults.append(said)
            usual *= 0.95 if said else 1.05  # what else the machine does changes
        if ended(*forked(lambda: cloth(root, cloth_number + 1))) != "published":
            count.faults.append("the run after the last kill published nothing")
    return count


def timed(root: Path, number: int) -> float:
    """Return the seconds that publishing a cloth takes."""
    started = time.perf_counter()
    ended(*forked(lambda: cloth(root, number)))
    return time.perf_counter() - started


def full_disk(trials: int) -> Count:
    """Publish a cloth where there is room for nothing, for a part of it, for all of it."""
    with tempfile.NamedTemporaryFile() as answer:
        command = [sys.executable, __file__, MOUNTED, answer.name, "--sizes", str(trials)]
        inside = subprocess.run(
            ["unshare", "--map-root-user", "--mount", *command],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        if inside.returncode == 0:
            return Count(**json.loads(Path(answer.name).read_bytes()))
    reason = inside.stderr.strip().splitlines()[-1:] or ["no reason told"]
    count = filling(trials, "files of limited size", limit_files)
    count.note(f"no file system could be mounted: {reason[0]}")
    return count


def mounted(trials: int) -> Count:
    """Fill a tmpfs, which is there until this process ends."""
    with tempfile.TemporaryDirectory() as folder:
        mount(folder, "size=64m")
        try:
            return filling(trials, "a full disk", lambda room, used: resize(folder, room + used),
                           Path(folder))  # fmt: skip
        finally:
            subprocess.run(["umount", folder], check=True)


def mount(folder: str, options: str) -> None:
    """Mount a tmpfs, or change the one that is there."""
    subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder], check=True)


def resize(folder: str, size: int) -> None:
    """Leave the tmpfs `size` bytes in all."""
    mount(folder, f"remount,size={size}")


def limit_files(room: int, used: int) -> None:
    """Let no file of this process grow beyond half of `room`."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (room // 2, resource.RLIM_INFINITY))


def filling(
    trials: int, part: str, limit: Callable[[int, int], None], folder: Path | None = None
) -> Count:
    """Publish with ever more room than an old version took, up to half as much again."""
    count = Count(part)
    with scratch(folder) as root:
        ended(*forked(lambda: cloth(root, 0)))
        used = sum((p.stat().st_size + 4095) // 4096 * 4096 for p in root.rglob("*") if p.is_file())
        for trial in range(trials):
            before = states(root)
            room = int(1.5 * used * trial / max(trials - 1, 1)) // 4096 * 4096
            if folder is not None:
                limit(max(room, 4096), used)

            def publish(room: int = room) -> str:
                if folder is None:
                    limit(room, used)
                return cloth(root, 1)

            said = ended(*forked(publish))
            count.note(said.split(":")[0])
            if said.startswith("broke"):
                count.faults.append(f"{room} bytes: {said}")
            if folder is not None:
                limit(1 << 26, 0)
            judge(count, root, before, f"{room} bytes")
            for newer in root.glob("*/v002"):
                shutil.rmtree(newer)
    return count


def race(rounds: int) -> Count:
    """Have eight processes publish one cloth at once, and another one in each round."""
    count = Count(f"{PUBLISHERS} publishers at once, {rounds} rounds")
    context = multiprocessing.get_context("fork")
    with scratch() as root:
        gate, said = context.Barrier(PUBLISHERS), context.SimpleQueue()
        runners = [
            context.Process(target=racer, args=(root, rounds, gate, said))
            for _ in range(PUBLISHERS)
        ]
        for runner in runners:
            runner.start()
        told = Counter(said.get() for _ in range(PUBLISHERS * rounds))
        for runner in runners:
            runner.join()
        for (_, outcome), times in told.items():
            count.note(outcome, times)
        judge(count, root, {}, "race")
        count.trials = sum(told.values())
        count.new = sum(map(len, states(root).values()))
        for number in range(rounds):
            outcomes = {what: times for (at, what), times in told.items() if at == number}
            if outcomes != {"published": 1, "unchanged": PUBLISHERS - 1}:
                count.faults.append(f"round {number}: {outcomes}")
        if count.new != rounds:
            count.faults.append(f"{count.new} versions of {rounds} cloths")
    return count


def racer(root: Path, rounds: int, gate: Any, said: Any) -> None:
    """Publish cloth after cloth, each when all others are ready for it."""
    for number in range(rounds):
        gate.wait()
        try:
            outcome = cloth(root, number)
        except BaseException as error:
            outcome = f"{type(error).__name__}: {error}"
        said.put((number, outcome))


@contextlib.contextmanager
def scratch(folder: Path | None = None) -> Iterator[Path]:
    """Make a root for assets and remove it again."""
    with tempfile.TemporaryDirectory(dir=folder) as name:
        yield Path(name)


def show(count: Count) -> None:
    """Print the line of a part, and its faults below."""
    often = sorted(count.notes.items(), key=lambda note: -note[1])[:4]
    notes = ", ".join(f"{times} × {what}" for what, times in often)
    print(f"{count.part:<36}{count.trials:>7}{count.old:>7}{count.new:>7}", end="")
    print(f"{count.remains:>9}{len(count.faults):>8}   {notes}", flush=True)
    for fault in count.faults[:10]:
        print(f"  {fault}")


def main() -> None:
    """Print a line for each part; exit with 1 where anything was lost or left behind."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=500, help="steps tried at most; 0 for none")
    parser.add_argument("--kills", type=int, default=100, help="random kills")
    parser.add_argument("--sizes", type=int, default=24, help="sizes of the full disk")
    parser.add_argument("--rounds", type=int, default=25, help="rounds of the race")
    parser.add_argument("--json", action="store_true", help="print the counts as JSON")
    parser.add_argument(MOUNTED, metavar="FILE", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    warm_up()
    if arguments.mounted is not None:
        arguments.mounted.write_text(json.dumps(asdict(mounted(arguments.sizes))))
        return
    parts = ((steps, arguments.steps), (kills, arguments.kills),
             (full_disk, arguments.sizes), (race, arguments.rounds))  # fmt: skip
    if not arguments.json:
        print(f"{'':<36}{'trials':>7}{'old':>7}{'new':>7}{'remains':>9}{'faults':>8}")
    counts = []
    for part, trials in parts:
        if trials:
            counts.append(part(trials))
            if not arguments.json:
                show(counts[-1])
    if arguments.json:
        print(json.dumps([asdict(count) for count in counts], indent=2))
    sys.exit(any(count.faults for count in counts))


if __name__ == "__main__":
    main()
