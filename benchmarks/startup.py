"""CPU seconds of `import weaveusd` and `weaveusd --help`: at most 0.3 s each is the goal.

python benchmarks/startup.py
"""

from __future__ import annotations

import resource
import subprocess
import sys

RUNS = 9


def cpu_seconds(*arguments: str) -> float:
    """Return the least user and system time of `RUNS` runs of the interpreter."""
    times = []
    for _ in range(RUNS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(times)


def main() -> None:
    """Print the times of both, and that of Python alone."""
    for name, arguments in (
        ("python alone", ("-c", "pass")),
        ("import weaveusd", ("-c", "import weaveusd")),
        ("weaveusd --help", ("-m", "weaveusd", "--help")),
    ):
        print(f"{name:<16} {cpu_seconds(*arguments):.3f} s")


if __name__ == "__main__":
    main()
