"""What a program's manual says about an integrator, and whether what was measured bears it out."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from substep.core.schemes import Scheme, schemes
from substep.core.schemes import scheme as make_scheme

from .fit import stated
from .identify import WHOLE, Identification, is_claimed
from .orders import Order, written

Verdict = Literal["true", "false", "partly", "not judged", "not stated"]

TOPICS: Mapping[str, Sequence[str]] = {  # what a manual should speak of -> the claims that do
    "scheme": ("scheme",), "order": ("order",), "damping": ("rho_inf",),
    "stability": ("unconditional", "critical_Omega"),
}  # fmt: skip
RADIUS = 3e-3  # how far the spectral radius at Omega = 10^4 may be off its limit, for a double root too


@dataclass(frozen=True)
class Claims:
    """What a manual states; what it does not state is left out.

    scheme: a name of the catalogue, or any other, which is then not judged; parameters: of it, also of a family such as
    rho_inf; without any, it may have all values. order: of u, free and driven.
    rho_inf: the spectral radius as Omega -> oo. unconditional: whether it is stable for every step, undamped.
    critical_Omega: the largest stable omega h, undamped. source: claim -> (quotation, place in the manual).
    """

    scheme: str | None = None
    order: int | None = None
    rho_inf: float | None = None
    unconditional: bool | None = None
    critical_Omega: float | None = None
    parameters: Mapping[str, float] = field(default_factory=dict[str, float])
    source: Mapping[str, tuple[str, str]] = field(default_factory=dict[str, tuple[str, str]])

    def claimed_scheme(self) -> Scheme | None:
        """The scheme with its parameters; rho_inf is one of them where the scheme has it. None for no scheme known.

        Raises ValueError for parameters of no scheme, and what `substep.scheme` does for its parameters.
        """
        if self.scheme is None and self.parameters:
            names = ", ".join(self.parameters)
            raise ValueError(f"expected the scheme of which {names} are claimed, got none; add scheme=...")
        if self.scheme not in schemes():
            return None
        given = dict(self.parameters)
        info = make_scheme(self.scheme).info
        if self.rho_inf is not None and not given and ("rho_inf" in info.families or "rho_inf" in info.parameters):
            given["rho_inf"] = self.rho_inf
        claimed = make_scheme(self.scheme, **given)
        return replace(claimed, given=claimed.parameters) if info.families.keys() & given.keys() else claimed


@dataclass(frozen=True)
class Judgement:
    """A claim, what was found in its place, the verdict, and where the claim stands.

    verdict: "not judged" for a scheme that is not of the catalogue, or what could not be measured; "not
    stated" for a topic of which the manual says nothing, with what was found of it.
    """

    claim: str
    claimed: str
    found: str
    verdict: Verdict
    source: tuple[str, str] = ("", "")
    motions: tuple[str, ...] = ()  # in which an order fails, or may as it is not measured

    @property
    def text(self) -> str:
        """In words, such as 'order = 2: partly (free: 1, driven: 2)'."""
        claim = f"{self.claim} = {self.claimed}" if self.claimed else self.claim
        return f"{claim}: {self.verdict} ({self.found})"


@dataclass(frozen=True)
class Found:
    """What claims are judged by, as numbers and in words.

    orders: of u, v and a by motion. rho_inf: the spectral radius as Omega -> oo. critical: the largest stable Omega,
    None for no limit, NaN where it is not known. blur: by how much the noise may have moved the spectral radius.
    """

    identified: Identification
    orders: Mapping[str, Order]
    rho_inf: float
    critical: float | None
    blur: float

    @property
    def scheme_text(self) -> str:
        """The scheme it is."""
        matches = self.identified.matches
        return matches[0].text if matches else "none of the catalogue"

    @property
    def order_text(self) -> str:
        """The order of u in each motion."""
        return ", ".join(f"{motion}: {written(order[0])}" for motion, order in self.orders.items())

    @property
    def radius_text(self) -> str:
        """The spectral radius, to four digits."""
        return f"{self.rho_inf:.4g}"

    @property
    def limit_text(self) -> str:
        """Up to where it is stable."""
        if self.critical is None:
            return "stable up to Omega = 10^4"
        if math.isnan(self.critical):
            return "stability not known, as runs fail"
        return f"unstable beyond Omega = {self.critical:.10g}"

    def of_topic(self, topic: str) -> str:
        """In words, what was found of one of `TOPICS`."""
        return {
            "scheme": self.scheme_text,
            "order": self.order_text,
            "damping": f"rho_inf = {self.radius_text}",
            "stability": self.limit_text,
        }[topic]


def judged(
    claims: Claims,
    identified: Identification,
    orders: Mapping[str, Order],
    rho_inf: float,
    critical: float | None,
    blur: float = 0.0,
) -> tuple[Judgement, ...]:
    """Every claim that is made, judged, and what was found of each topic that none speaks of.

    Arguments after the claims are those of `Found`.
    """
    found = Found(identified, orders, rho_inf, critical, blur)
    made = [judge(claims, found) for name, judge in JUDGES.items() if getattr(claims, name) is not None]
    silent = unstated({one.claim for one in made} | claims.parameters.keys())
    topics = [Judgement(topic, "", found.of_topic(topic), "not stated") for topic in silent]
    return tuple(replace(one, source=claims.source.get(one.claim, ("", ""))) for one in (*made, *topics))


def _scheme(claims: Claims, found: Found) -> Judgement:
    """True where the whole step is the scheme's, damped too; partly where only its eigenvalues or undamped ones are."""
    claimed = claims.claimed_scheme()
    if claimed is None:
        return Judgement("scheme", str(claims.scheme), found.scheme_text, "not judged")
    identified = found.identified
    matches, undamped = identified.matches, identified.undamped
    candidates = [*matches, *undamped, *([identified.claimed] if identified.claimed else [])]
    same = [match for match in candidates if is_claimed(match.scheme, claimed)]
    levels = (*WHOLE, "recursion") if matches and matches[0].what == "recursion" else WHOLE
    whole = any(x.what in levels and x.damping == "declared" and x not in undamped for x in same)
    verdict: Verdict = "true" if whole else "partly" if same else "false"
    return Judgement("scheme", stated(claimed), found.scheme_text, verdict)


def _order(claims: Claims, found: Found) -> Judgement:
    """Partly true where some motions are of a lower order. An order is None where u is exact, NaN where not known."""
    least = float(claims.order or 0) - 0.5
    u = {motion: order[0] for motion, order in found.orders.items()}
    bad = [motion for motion, order in u.items() if order is not None and order < least]
    unknown = any(order is not None and math.isnan(order) for order in u.values())
    fails: Verdict = "false" if len(bad) == len(u) else "partly"
    verdict: Verdict = fails if bad else "not judged" if unknown or not u else "true"
    may_fail = tuple(motion for motion, order in u.items() if order is not None and not order >= least)
    return Judgement("order", str(claims.order), found.order_text, verdict, motions=may_fail)


def _rho_inf(claims: Claims, found: Found) -> Judgement:
    """To RADIUS, or to what noise blurs."""
    claimed = float(claims.rho_inf or 0.0)
    near = abs(found.rho_inf - claimed) <= max(RADIUS, found.blur)
    verdict: Verdict = "not judged" if math.isnan(found.rho_inf) else _verdict(near)
    return Judgement("rho_inf", f"{claimed:g}", found.radius_text, verdict)


def _unconditional(claims: Claims, found: Found) -> Judgement:
    """Whether there is a limit or not, as claimed."""
    return _of_limit(
        "unconditional", str(claims.unconditional), found, claims.unconditional == (found.critical is None)
    )


def _critical_Omega(claims: Claims, found: Found) -> Judgement:
    """The limit to a thousandth, or to what noise blurs."""
    claimed = float(claims.critical_Omega or 0.0)
    off = math.inf if found.critical is None else abs(found.critical - claimed)
    return _of_limit("critical_Omega", f"{claimed:g}", found, off <= max(1e-3, found.blur) * claimed)


def _of_limit(claim: str, claimed: str, found: Found, holds: bool) -> Judgement:
    unsure = found.critical is not None and math.isnan(found.critical)
    return Judgement(claim, claimed, found.limit_text, "not judged" if unsure else _verdict(holds))


JUDGES: Mapping[str, Callable[[Claims, Found], Judgement]] = {  # what a claim is called in `Claims` -> how it is judged
    "scheme": _scheme, "order": _order, "rho_inf": _rho_inf, "unconditional": _unconditional,
    "critical_Omega": _critical_Omega,
}  # fmt: skip


def unstated(made: Collection[str]) -> list[str]:
    """The topics of which none of the claims that are made speaks."""
    return [topic for topic, names in TOPICS.items() if not any(name in made for name in names)]


def _verdict(holds: bool) -> Verdict:
    return "true" if holds else "false"
