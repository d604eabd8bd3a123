"""Whether a WIF counts threads, shafts and treadles from 1, as it should, or from 0."""

from __future__ import annotations

from weaveusd.draft.rows import Rows

_WITNESSES = (("THREADING", "WARP"), ("TREADLING", "WEFT"), ("LIFTPLAN", "WEFT"))


class Numbering:
    """The first number of threads, shafts and treadles in one file.

    A row 0 of [THREADING], [TREADLING] or [LIFTPLAN] shows that the file counts from 0, unless
    that row is unused while the last thread counted from 1 is listed too. Some programs mix
    both ways, so that in such a file each section is judged by itself: one that names as many
    shafts, treadles or threads as there are counts from 1 after all.
    """

    def __init__(self, rows: Rows) -> None:
        self._rows = rows
        self.from_zero = False
        for name, system in _WITNESSES:
            listed = rows.numbers(name)
            line, numbers = listed.get(0, (0, ()))
            unused = not any(numbers) and rows.count(system, "Threads") in listed
            if numbers and not unused:
                self.from_zero = True
                rows.warn(line, name, "has a row 0; the file is read as counting from 0")
                return

    def first_row(self, name: str, count: int | None) -> int:
        """Return the number of the first of `count` threads or treadles that `name` lists."""
        if not self.from_zero:
            return 1
        keys = self._rows.keyed(name)
        return 1 if 0 not in keys and count in keys else 0

    def first_value(self, name: str, count: int | None) -> int:
        """Return the number of the first of `count` shafts or treadles in the rows of `name`."""
        if not self.from_zero:
            return 1
        listed = self._rows.numbers(name).values()
        top = max((max(numbers) for _, numbers in listed if numbers), default=0)
        return 1 if count and top >= count else 0
