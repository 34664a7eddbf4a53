"""What a job hands to the report: times and errors, goals and whether they are reached, and what was left out."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

from .timing import Measured, Ratio, ratio

BESIDE_C = 1.3  # what is asked of a kernel: its time over that of C for the same work, whatever the CPU


@dataclass(frozen=True)
class Goal:
    """A bound on a measured number; reached is None where it could not be measured, for the reason `why`."""

    text: str
    sense: Literal["<=", ">=", "<"]
    bound: float
    reached: float | None
    low: float | None = None
    high: float | None = None
    why: str = ""
    unit: str = "x"  # "" for an error, "s" for a time

    @property
    def met(self) -> bool | None:
        """Whether it was reached; None if it could not be measured."""
        if self.reached is None:
            return None
        if self.sense == ">=":
            return self.reached >= self.bound
        return self.reached <= self.bound if self.sense == "<=" else self.reached < self.bound


@dataclass
class Table:
    """Alternatives on the same work. unit: what a time is the time of; errors: what each column of errors means."""

    title: str
    unit: str
    rows: list[Measured]
    errors: dict[str, str] = field(default_factory=dict)

    def row(self, name: str) -> Measured | None:
        """The row of that name, None if it was left out."""
        return next((row for row in self.rows if row.name == name), None)


@dataclass
class Job:
    """The results of one job: tables, goals, what was left out and why, and notes for the reader."""

    name: str
    title: str
    tables: list[Table] = field(default_factory=list)
    goals: list[Goal] = field(default_factory=list)
    skipped: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def compare(self, table: Table, text: str, slow: str, fast: str, sense: Literal["<=", ">="], bound: float) -> None:
        """A goal on the time of row `slow` over that of row `fast`."""
        a, b = table.row(slow), table.row(fast)
        if a is None or b is None:
            missing = slow if a is None else fast
            self.goals.append(Goal(text, sense, bound, None, why=f"{missing} was left out"))
            return
        found: Ratio = ratio(a, b)
        self.goals.append(Goal(text, sense, bound, found.median, found.low, found.high))

    def below(self, text: str, bound: float, values: Iterable[float], unit: str = "") -> None:
        """A goal on the largest of some errors."""
        self.goals.append(Goal(text, "<", bound, max(values), unit=unit))
