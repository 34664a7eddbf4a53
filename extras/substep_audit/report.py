"""What an audit found, as an object, as text, as JSON, and as a page."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .causes import Deviation
from .claims import Judgement
from .control import Control
from .curve import Curve
from .defaults import WrittenOut
from .free_motion import Energy, Growth
from .identify import Identification, Match
from .loads import LoadTaking
from .measured_stability import same_limit
from .noise import QUIET, Noise
from .orders import Order, written
from .outputs import instants_text
from .programs.adapter import LOADS
from .stepper import Stepper


@dataclass(frozen=True)
class Report:
    """An audit.

    found: the schemes it does the same as, or the nearest one. exact: None, or the load for which its motion is exact.
    orders: of u, v, a, for each motion, damped and undamped; None where exact or not returned. rho_inf: the spectral
    radius as Omega -> oo of the scheme, where one is identified, beside which measured_rho_inf is that of the program
    at Omega = 10^4; which stands for it where none is. critical_Omega: None where it is stable up to there, NaN where
    runs fail that would tell; that of the scheme, where one is identified, beside which measured_critical is that of
    the program, found by bisection, and scheme_critical the scheme's, to as few digits. overshoot: as the catalogue
    writes it. loads: how it takes the load. start: where its first acceleration comes from. judgements: of the claims.
    deviations: root causes. curves: what was measured, for charts. growth: where undamped free motion grows like a
    power of n. energy: what happens to that of undamped free motion; empty where no velocity at the ends of steps is
    returned. control: what it does in steps of its own choice, None where it does not choose. failed: Omega, xi and
    the error where the program raised; what is said of it rests on the other runs. noise: how well it repeats itself,
    which all that is said rests on. ignores_a0: whether nothing moves from rest with a given acceleration. instants:
    by how many steps v and a stand after the end of their step, where they do, as the adapter declares it or not.
    defaults: whether it does the same with the defaults of its arguments written out; None without any. left_out: what
    was not compared or not run, and why. seconds: of CPU that the audit took here and in the program's own process;
    None where that is the same one.
    """

    stepper: Stepper
    found: Identification
    exact: str | None
    orders: Mapping[str, Order]
    rho_inf: float
    critical_Omega: float | None
    overshoot: str
    loads: LoadTaking
    judgements: tuple[Judgement, ...]
    deviations: tuple[Deviation, ...]
    curves: tuple[Curve, ...]
    growth: tuple[Growth, ...] = ()
    energy: tuple[Energy, ...] = ()
    control: Control | None = None
    failed: tuple[tuple[float, float, str], ...] = ()
    noise: Noise = QUIET
    defaults: WrittenOut | None = None
    left_out: tuple[str, ...] = ()
    measured_critical: float | None = None
    scheme_critical: float | None = None
    ignores_a0: bool = False
    instants: Mapping[str, float] = field(default_factory=dict)
    seconds: tuple[float, float] | None = None
    measured_rho_inf: float = math.nan

    @property
    def matches(self) -> tuple[Match, ...]:
        """The schemes it does the same as, best first."""
        return self.found.matches

    @property
    def identified(self) -> str:
        """The scheme, such as 'generalized_alpha(rho_inf = 4/5), all entries to 3e-14', or an equation of several."""
        if self.exact is not None:
            return f"exact, for a load {self.exact}" if self.exact != "otherwise" else "exact without a load"
        if not self.matches:
            nearest = self.found.nearest
            if self.noise.hides:
                return f"not found: results repeat to {self.noise.digits} digits"
            near = f"; nearest: {nearest.text}, off by {nearest.error:.0e}{self.found.differs}" if nearest else ""
            if self.found.undamped:
                return f"{self.found.undamped[0].text} without damping, none of the catalogue with it"
            return f"none of the catalogue{near}"
        what = {
            "matrix": "all entries",
            "displacements": "displacements",
            "recursion": "the recursion of u",
            "spectrum": "eigenvalues only,",
        }
        same = " = ".join(match.text for match in self.matches if not match.doubtful)
        if doubtful := [match.text for match in self.matches if match.doubtful]:
            same += f" or, within the noise: {'; '.join(doubtful)}"
        return f"{same}, {what[self.matches[0].what]} to {self.matches[0].error:.0e}"

    @property
    def nonlinear(self) -> tuple[str, ...]:
        """What a cubic spring tells, in words: nothing where none was tried."""
        least = self.found.nonlinear
        if least is None:
            return ()
        if least > self.noise.match:
            return (f"none of these under a cubic spring: off by {least:.0e}",)
        apart = tuple(f"not {match.text}: off by {error:.0e}" for match, error in self.found.apart)
        return (f"the same under a cubic spring, to {least:.0e}", *apart)

    @property
    def start(self) -> str:
        """Where the acceleration at t = 0 comes from: "computed", "zero", "own", or "unknown"."""
        return self.matches[0].start if self.matches else "unknown"

    @property
    def order(self) -> float | None:
        """The least order of u over the motions; None where all are exact, not measured, or none was run."""
        known = (order[0] for order in self.orders.values())
        return min((x for x in known if x is not None and not math.isnan(x)), default=None)

    @property
    def stable(self) -> str:
        """Up to where it is stable, in words, and whether a bisection of the program's own runs finds the same."""
        text = _limit(self.critical_Omega)
        if not self.matches:
            return f"{text} (measured)"
        measured, scheme = self.measured_critical, self.scheme_critical
        same = same_limit(measured, scheme, self.noise)
        return f"{text} (measured the same)" if same else f"{text} by the scheme, measured: {_limit(measured)}"

    @property
    def claimed_order(self) -> int | None:
        """The order that is claimed; None if none is."""
        return next((int(one.claimed) for one in self.judgements if one.claim == "order" and one.claimed), None)

    @property
    def load(self) -> str:
        """How it takes the load, and how that is given to it."""
        given = self.stepper.can.load
        return (self.exact or self.loads.text) + (f" ({LOADS[given]})" if given != "none" else "")

    @property
    def facts(self) -> list[tuple[str, str]]:
        """What was found, in words: pairs of a label and a text, which the text and the page show."""
        ignored = "; one that is given is ignored" if self.ignores_a0 else ""
        found = [("is", self.identified), ("digits", self.noise.text)]
        found += [("nonlinear", line) for line in self.nonlinear]
        found += [("order", f"{name}: {_order(order, self.claimed_order)}") for name, order in self.orders.items()]
        measured = f"{self.measured_rho_inf:.4g} measured at Omega = 10^4"
        limits = f"rho_inf = {self.rho_inf:.4g} ({measured}), {self.stable}, overshoot {self.overshoot}"
        found.append(("stability", limits))
        found += [("growth", growth.text) for growth in self.growth]
        found += [("energy", f"at Omega = {energy.Omega:g}: {energy.text}") for energy in self.energy]
        found += [("own steps", line) for line in (self.control.text if self.control else ())]
        found += [("load", self.load), ("start", f"acceleration at t = 0: {self.start}{ignored}")]
        found += [("outputs", instants_text(self.instants))] if self.instants else []
        found += [("defaults", self.defaults.text)] if self.defaults else []
        found += [("left out", line) for line in self.left_out]
        found += [("not run", f"at Omega = {Omega:g}, xi = {xi:g}: {error}") for Omega, xi, error in self.failed]
        if self.seconds is not None:
            found.append(("took", "{:.1f} s of CPU here and {:.1f} s in the program".format(*self.seconds)))
        return found

    @property
    def text(self) -> str:
        """The report in lines, of which each is a fact, a claim or a deviation."""
        lines = [f"{self.stepper.name} {self.stepper.version}".rstrip()]
        lines += [f"  {label:<11}{text}" for label, text in self.facts]
        for judgement in self.judgements:
            lines.append(f"  claim      {judgement.text}")
            if judgement.source[0]:
                lines.append(f'             "{judgement.source[0]}" ({judgement.source[1]})')
        for deviation in self.deviations:
            lines.append(f"  departs    {deviation.kind}: {deviation.text}")
            lines += [f"             so that {consequence}" for consequence in deviation.consequences]
        if not self.deviations:
            lines.append("  departs    nowhere")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data: what `to_json` writes. A number that is not finite is text, "inf", "-inf" or "nan"."""
        found = {
            "program": self.stepper.name,
            "version": self.stepper.version,
            "arguments": dict(self.stepper.arguments),
            "identified": self.identified,
            "exact": self.exact,
            "matches": [
                {
                    "scheme": m.scheme.name,
                    "parameters": {key: float(x) for key, x in m.scheme.parameters.items()},
                    "text": m.text,
                    "what": m.what,
                    "damping": m.damping,
                    "start": m.start,
                    "error": m.error,
                }
                for m in self.matches
            ],
            "noise": asdict(self.noise) | {"text": self.noise.text},
            "nonlinear": list(self.nonlinear),
            "orders": {name: list(order) for name, order in self.orders.items()},
            "rho_inf": self.rho_inf,
            "measured_rho_inf": self.measured_rho_inf,
            "critical_Omega": self.critical_Omega,
            "measured_critical": self.measured_critical,
            "ignores_a0": self.ignores_a0,
            "instants": dict(self.instants),
            "overshoot": self.overshoot,
            "growth": [asdict(growth) | {"text": growth.text} for growth in self.growth],
            "energy": [asdict(energy) | {"verdict": energy.verdict, "text": energy.text} for energy in self.energy],
            "control": None if self.control is None else self.control.to_dict(),
            "loads": asdict(self.loads) | {"text": self.loads.text},
            "claims": [asdict(judgement) for judgement in self.judgements],
            "deviations": [asdict(deviation) for deviation in self.deviations],
            "not_run": [list(one) for one in self.failed],
            "defaults": None if self.defaults is None else asdict(self.defaults) | {"text": self.defaults.text},
            "left_out": list(self.left_out),
            "seconds": None if self.seconds is None else [round(x, 1) for x in self.seconds],
            "curves": [{key: np.asarray(x).tolist() for key, x in asdict(curve).items()} for curve in self.curves],
        }
        return _plain(found)

    def to_json(self) -> str:
        """The report as JSON."""
        return json.dumps(self.to_dict(), indent=1, allow_nan=False)

    def to_html(self, path: str | Path) -> Path:
        """Write the report as one static page, with the measured curves over those of the identified scheme."""
        from .page import write  # noqa: PLC0415 (loads Matplotlib)

        matched = self.matches[0].scheme if self.matches else None
        return write(self, self.curves, matched, Path(path))

    def __repr__(self) -> str:
        return f"Report({self.identified!r}, {len(self.deviations)} deviations)"


def _plain(data: Any) -> Any:
    """The same with text in place of numbers that JSON does not know."""
    if isinstance(data, Mapping):
        return {key: _plain(x) for key, x in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(x) for x in data]
    return str(float(data)) if isinstance(data, float) and not math.isfinite(data) else data


def _limit(critical: float | None) -> str:
    if critical is None:
        return "stable up to Omega = 10^4"
    return "not known, as runs fail" if math.isnan(critical) else f"unstable beyond {critical:.9g}"


def _order(order: Order, claimed: int | None) -> str:
    """Of u, v and a beside the claim, which is one of u: v and a that are returned may be less accurate."""
    text = ", ".join(f"{name} {'-' if x is None else written(x)}" for name, x in zip("uva", order, strict=True))
    if claimed is None:
        return text
    less = [name for name, x in zip("uva", order, strict=True) if x is not None and x < claimed - 0.5]
    return f"{text}; claimed {claimed}" + (f", not that of {', '.join(less)}" if less else "")
