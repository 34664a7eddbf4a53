"""What a program's manual says about an integrator, and whether what was measured bears it out."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

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


def judged(
    claims: Claims,
    identified: Identification,
    orders: Mapping[str, Order],
    rho_inf: float,
    critical: float | None,
    blur: float = 0.0,
) -> tuple[Judgement, ...]:
    """Every claim that is made, judged, and what was found of each topic that none speaks of.

    blur: by how much the noise may have moved the spectral radius.
    """
    found: list[Judgement] = []
    matches = identified.matches
    is_a = matches[0].text if matches else "none of the catalogue"
    orders_of_u = ", ".join(f"{motion}: {written(order[0])}" for motion, order in orders.items())
    radius = f"{rho_inf:.4g}"
    limit = "stable up to Omega = 10^4" if critical is None else f"unstable beyond Omega = {critical:.10g}"
    unsure = critical is not None and math.isnan(critical)
    limit = "stability not known, as runs fail" if unsure else limit

    def judge(claim: str, claimed: Any, what: str, verdict: Verdict, motions: Sequence[str] = ()) -> None:
        found.append(Judgement(claim, str(claimed), what, verdict, claims.source.get(claim, ("", "")), tuple(motions)))

    if claims.scheme is not None:
        claimed = claims.claimed_scheme()
        candidates = [*matches, *identified.undamped, *([identified.claimed] if identified.claimed else [])]
        same = [match for match in candidates if claimed is not None and is_claimed(match.scheme, claimed)]
        levels = (*WHOLE, "recursion") if matches and matches[0].what == "recursion" else WHOLE
        whole = any(x.what in levels and x.damping == "declared" for x in same if x not in identified.undamped)
        verdict: Verdict = "not judged" if claimed is None else "true" if whole else "partly" if same else "false"
        name = claims.scheme if claimed is None else stated(claimed)
        judge("scheme", name, is_a, verdict)
    if claims.order is not None:
        u = {motion: order[0] for motion, order in orders.items()}
        bad = [motion for motion, order in u.items() if order is not None and order < claims.order - 0.5]
        unknown = any(order is not None and math.isnan(order) for order in u.values())
        fails: Verdict = "false" if len(bad) == len(u) else "partly"
        verdict = fails if bad else "not judged" if unknown or not u else "true"
        may_fail = [motion for motion, order in u.items() if order is not None and not order >= claims.order - 0.5]
        judge("order", claims.order, orders_of_u, verdict, may_fail)
    if claims.rho_inf is not None:
        near = abs(rho_inf - claims.rho_inf) <= max(RADIUS, blur)
        judge("rho_inf", f"{claims.rho_inf:g}", radius, "not judged" if math.isnan(rho_inf) else _verdict(near))
    if claims.unconditional is not None:
        holds = claims.unconditional == (critical is None)
        judge("unconditional", claims.unconditional, limit, "not judged" if unsure else _verdict(holds))
    if claims.critical_Omega is not None:
        near = critical is not None and abs(critical - claims.critical_Omega) <= max(1e-3, blur) * claims.critical_Omega
        judge("critical_Omega", f"{claims.critical_Omega:g}", limit, "not judged" if unsure else _verdict(near))
    measured = {"scheme": is_a, "order": orders_of_u, "damping": f"rho_inf = {radius}", "stability": limit}
    for topic in unstated({one.claim for one in found} | claims.parameters.keys()):
        judge(topic, "", measured[topic], "not stated")
    return tuple(found)


def unstated(made: Collection[str]) -> list[str]:
    """The topics of which none of the claims that are made speaks."""
    return [topic for topic, names in TOPICS.items() if not any(name in made for name in names)]


RADIUS = 3e-3  # how far the spectral radius at Omega = 10^4 may be off its limit, for a double root too


def _verdict(holds: bool) -> Verdict:
    return "true" if holds else "false"
