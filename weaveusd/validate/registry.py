"""Checks as data: what each is called, why it exists, what it needs and what it can say."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Protocol, TypeVar

from weaveusd.validate.model import Finding, Status

if TYPE_CHECKING:
    from weaveusd.validate.open_asset import OpenAsset
    from weaveusd.validate.textures import Band

Need = Literal["material", "shader", "textures", "moments", "renderer"]
"""What a check cannot do without: a cloth material, its exact shader, a complete set of
textures of one size that decode, moment maps that the shader names, a renderer on this machine.
Without it the check is skipped."""

Rule = Callable[["OpenAsset"], Iterator[Finding]]


class Survey(Protocol):
    """A rule about texels: it sees every band of the textures once, then judges.

    It is made before the textures are read, in the thread that owns the stage. `look` runs
    beside the looks of other rules and must not touch the stage.
    """

    def __init__(self, asset: OpenAsset) -> None: ...

    def look(self, band: Band) -> None:
        """Take from `band`, which holds all textures, what is needed of it."""

    def findings(self) -> Iterator[Finding]:
        """Judge what was seen."""


@dataclass(frozen=True, slots=True)
class Code:
    """One fault that a check can find; calling it makes the finding.

    `name` is permanent and unique among all checks, `meaning` a sentence for the manual.
    """

    name: str
    status: Status
    meaning: str

    def __call__(self, message: str, where: str = "") -> Finding:
        """Return the finding, without the id of its check, which the runner knows."""
        return Finding("", self.status, self.name, message, where)


@dataclass(frozen=True, slots=True)
class Check:
    """A rule, a function or a survey, and what is known about it without running it."""

    id: str
    title: str
    why: str
    needs: tuple[Need, ...]
    codes: tuple[Code, ...]
    rule: Rule | type[Survey]


_CHECKS: dict[str, Check] = {}

_R = TypeVar("_R", bound="Rule | type[Survey]")


def check(
    *,
    id: str,  # noqa: A002  reads as what it is
    why: str,
    codes: tuple[Code, ...],
    needs: tuple[Need, ...] = (),
) -> Callable[[_R], _R]:
    """Register the decorated rule, whose docstring is its title, as the check `id`.

    The rule yields findings made by calling its `codes`, and none when all is well. One that
    is a survey needs `textures`.

    Raises
    ------
    ValueError
        When the id or one of the codes is taken.
    """

    def register(rule: _R) -> _R:
        taken = {code.name for known in _CHECKS.values() for code in known.codes}
        names = [code.name for code in codes]
        if id in _CHECKS or taken & set(names) or len(names) != len(set(names)):
            raise ValueError(f"check {id}: its id or one of its codes {names} is taken")
        title = (rule.__doc__ or "").strip().splitlines()[0]
        _CHECKS[id] = Check(id, title, why, needs, codes, rule)
        return rule

    return register


def all_checks() -> tuple[Check, ...]:
    """Return every check, in the order in which they run."""
    import weaveusd.validate.checks  # noqa: F401  registers them

    return tuple(_CHECKS.values())
