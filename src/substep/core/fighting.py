"""Why the balance of a step has no solution: contacts without room, friction that presses harder, a mass that ends."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any, Protocol, cast

import numpy as np

from .arrays import Array
from .rows import Rows
from .scenes import Scene

TOUCHES = 1e-8  # of the scene's length, and of the velocity: what is nearer is in contact, what is slower sticks
SINGULAR = 1e-10  # of the product of its diagonal: a smaller minor of several contacts is 0, as of dependent ones
ENDS = 0.05  # of the mass at the start, which is then about to end
GROWN = 10.0  # of the energy at the start: a run that ends beyond all bounds has blown up where there is more
BEFORE = 4  # rows before that, in which the mass is looked at
MOST = 8  # contacts that are looked at together


class _Scheme(Protocol):
    """A scheme, as far as it is asked where its reactions act: see `substep.core.schemes.Scheme`."""

    @property
    def kind(self) -> str | None: ...


class _Run(Rows, Protocol):
    """A response of a scene, as far as it is asked where it has ended."""

    @property
    def scheme(self) -> "_Scheme": ...
    @property
    def memories(self) -> Array | None: ...
    @property
    def energy(self) -> Any: ...


@dataclass(frozen=True)
class Acting:
    """The contacts that touch in a step, and all frictions: of each its name, and of contacts the coordinates.

    mobility (d + f, d + f): the accelerations of gaps and of what slides under unit forces along them. shares (f, d):
    by how much limits of frictions grow with pressures. rates (f,): of what slides, 0 where it sticks. without_room:
    what is said of contacts that cannot all be open, if there are any.
    """

    contacts: Sequence[str]
    frictions: Sequence[str]
    coordinates: Sequence[str]
    mobility: Array
    shares: Array
    rates: Array
    without_room: str = ""


def reason(of: Acting) -> str:
    """Why the reactions have no solution, in words, and the cure; what acts, where that is not known; else nothing."""
    if found := known(of):
        return found
    rubbing = [name for name, share in zip(of.frictions, of.shares, strict=True) if share.any() or not of.contacts]
    if not of.contacts and not rubbing:
        return ""
    acting = [*(f"contact '{x}'" for x in of.contacts), *(f"friction '{x}'" for x in rubbing)]
    return f"the branches of {listed(acting)} were not found; take steps of another length"


def known(of: Acting) -> str:
    """Why the reactions have no solution, in words, and the cure, where that is known; else nothing."""
    return of.without_room or pressed_harder(of) or dependent(of)


def dependent(of: Acting) -> str:
    """That contacts, or frictions, repeat each other or constraints: no motion says what each bears; else nothing."""
    d = len(of.contacts)
    for what, names, some in (
        ("contact", of.contacts, slice(0, d)), ("friction", of.frictions, slice(d, len(of.mobility)))
    ):  # fmt: skip
        A = of.mobility[some, some]
        sizes = np.sqrt(np.diag(A))
        if held := [name for name, size in zip(names, sizes, strict=True) if size == 0.0]:
            return (
                f"{what} '{held[0]}' acts where constraints leave no motion, so that its force is not determined; "
                "leave it out"
            )
        values, vectors = np.linalg.eigh(A / np.outer(sizes, sizes))
        if len(A) and values[0] <= SINGULAR:
            which = [f"{what} '{names[k]}'" for k in np.flatnonzero(np.abs(vectors[:, 0]) > 1e-6).tolist()]
            return (
                f"{listed(which)} repeat each other, so that their forces are not determined; leave one out, or give "
                "one a penalty in place of a rigid stop"
            )
    return ""


def pressed_harder(of: Acting) -> str:
    """That friction presses contacts harder than their pressures relieve them, as on Painlevé's rod; else nothing.

    Gaps accelerate by A p, A = G M^-1 (G - mu s T)^T, s the way in which frictions slide. Whatever else acts, that has
    one solution if all principal minors of A are positive (a P-matrix: Pang & Trinkle, Math. Program. 73 (1996) 199).
    """
    d, ways = len(of.contacts), [(s,) if s else (-1.0, 1.0) for s in np.sign(of.rates).tolist()]
    scale = np.sqrt(np.diag(of.mobility)[:d])
    for s in product(*ways) if len(ways) <= MOST else ():
        sliding = of.mobility[:d, d:] @ (np.array(s)[:, None] * of.shares)
        A = of.mobility[:d, :d] - sliding
        for count in range(1, min(d, MOST) + 1):
            for some in combinations(range(d), count):
                at = np.ix_(some, some)
                minor = float(np.linalg.det((A / np.outer(scale, scale))[at]))
                if not minor <= (0.0 if count == 1 else -SINGULAR):
                    continue
                rows = zip(of.frictions, of.shares, strict=True)
                pressing = listed([f"friction '{x}'" for x, row in rows if row[list(some)].any()])
                pressed = listed([f"contact '{of.contacts[k]}' (of {of.coordinates[k]})" for k in some])
                value = f"{float(A[at][0, 0]):.3g}" if count == 1 else f"a matrix with the minor {minor:.3g}"
                return (
                    f"{pressing} presses {pressed} harder than sliding relieves it, "
                    f"so that G M^-1 (G - mu T)^T is {value}, expected to be positive (Painlevé's paradox); take a "
                    "smaller coefficient of friction, or a spring in place of the contact"
                )
    return ""


def listed(names: Sequence[str]) -> str:
    """Names in a sentence."""
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else "".join(names)


def reacts_until(scheme: _Scheme, t: float, end: float) -> float:
    """The time, s, at which reactions of a step from t to end hold something: of explicit schemes a step later."""
    return end + (end - t) if scheme.kind == "explicit" else end


def of_scene(r: _Run, row: int, end: float) -> Acting | None:
    """What acts in the step of a scene from a row to the time `end`, s; None without contacts and frictions."""
    scene, info = r.scene, r.scene.info
    c, d, f = len(info.multipliers), len(info.contacts), len(info.frictions)
    if not d + f:
        return None
    at = slice(row, row + 1 or None)
    t, u, v = r.t[at], np.asarray(r.u)[at], np.asarray(r.v)[at]
    end = reacts_until(r.scheme, float(t[0]), end)
    h = end - float(t[0])
    now, rates, _ = (x[0] for x in scene.drift(t, u, v))
    a = scene.acceleration(t, u, v, *r.memory_of_rows(at))
    free = np.array([end]), u + h * v + 0.5 * h * h * a, v + h * a  # where the step would end without the reactions
    ahead, speeds = (x[0] for x in scene.drift(*free)[:2])
    G, length = np.array(scene.directions(t, u)[0], dtype=float), float(scene.length)
    G[c : c + d] *= -1.0
    across = np.linalg.norm(G, axis=1)
    touches = np.flatnonzero((np.minimum(-now, -ahead) <= TOUCHES * across * length)[c : c + d])
    rows = np.concatenate([G[c : c + d][touches], G[c + d :]])
    slides = np.where(np.abs(rates) > TOUCHES * across * float(np.abs(v).max()), rates, 0.0)[c + d :]
    shares = scene.limits(t, u)[0, :, 1:] if f else np.zeros((0, d))
    names = [name for name, _ in scene.coordinates]
    M = mass(r, row)
    alone, mobility = (rows @ _compliance(M, held) @ rows.T for held in (G[:0], G[:c]))
    stuck = np.diag(mobility) <= SINGULAR * np.diag(alone)  # by constraints
    mobility[stuck], mobility[:, stuck] = 0.0, 0.0
    return Acting(
        [info.contacts[k] for k in touches],
        info.frictions,
        [", ".join(x for x, g in zip(names, G[c + k], strict=True) if g) for k in touches],
        mobility,
        shares[:, touches],
        slides,
        _without_room(scene, G, float(np.abs(v).max()), (-ahead, -speeds), touches.tolist()),
    )


def mass(r: _Run, row: int) -> Array:
    """The mass matrix (n, n) of a scene at a row: the second derivatives of its energy by velocities."""
    n = r.u.shape[-1]
    one = np.eye(n) * max(1.0, float(np.abs(r.v[row]).max()))
    pairs = np.array([x + y for x in one for y in one] + list(one) + [np.zeros(n)])
    t, u = np.full(len(pairs), r.t[row]), np.tile(r.u[row], (len(pairs), 1))
    memory = () if r.memories is None else (np.tile(r.memories[row], (len(pairs), 1)),)
    energy = r.scene.energy(t, u, pairs, *memory)
    single = energy[n * n : -1]
    return (energy[: n * n].reshape(n, n) - single[:, None] - single + energy[-1]) / one[0, 0] ** 2


def _compliance(M: Array, held: Array) -> Array:
    """The accelerations (n, n) under unit forces, of a mass that constraints hold along rows (c, n)."""
    n, c = len(M), len(held)
    whole = np.block([[M, held.T], [held, np.zeros((c, c))]])
    return np.asarray(np.linalg.pinv(whole), dtype=np.float64)[:n, :n]


def _without_room(scene: Scene, G: Array, speed: float, ahead: tuple[Array, Array], touches: Sequence[int]) -> str:
    """That contacts leave no room at the end of a step: that no motion keeps all their gaps, or rates, from below 0.

    speed: the largest velocity. ahead: gaps, and their rates, without reactions. Contacts with a restitution hold the
    rates, where they touch.
    """
    info, c, length = scene.info, len(scene.info.multipliers), float(scene.length)
    held = [k for k, name in enumerate(info.contacts) if name in info.held_gaps]
    bouncing = [k for k in touches if k not in held]
    gaps = held, ahead[0], length, "their gaps cannot all be more than 0"
    rates = bouncing, ahead[1], -speed, "the rates of their gaps cannot all be 0 or more"
    for some, values, least, cannot in (gaps, rates):
        weights = _opposed(G, values, c, some, TOUCHES * least) if len(some) > 1 else []
        if weights:
            names = [f"contact '{info.contacts[k]}'" for k in weights]
            moved = zip(scene.coordinates, G[[c + k for k in weights]].T, strict=True)
            along = ", ".join(name for (name, _), g in moved if g.any())
            return (
                f"{listed(names)} leave no room in {along}: {cannot} there; declare contacts that can be open "
                "together, or end the run before"
            )
    return ""


def _opposed(G: Array, values: Array, c: int, some: Sequence[int], least: float) -> list[int]:
    """The contacts of a positive combination of values that no motion changes, and that is below `least`; or none.

    By Farkas' lemma there is one where the values cannot all be positive, beside the first c rows that are held.
    """
    from scipy.optimize import linprog  # noqa: PLC0415  # pyright: ignore

    if not np.isfinite(values).all():
        return []
    at = [*range(c), *(c + k for k in some)]
    across = np.linalg.norm(G[at], axis=1)
    rows, ones = G[at].T / across, np.array([[0.0] * c + [1.0] * len(some)])
    right = np.append(np.zeros(len(rows)), 1.0)
    bounds = [(None, None)] * c + [(0.0, None)] * len(some)
    solve = cast("Callable[..., Any]", linprog)
    found = solve(values[at] / across, A_eq=np.concatenate([rows, ones]), b_eq=right, bounds=bounds)
    if found.status or found.fun > least:
        return []
    return [k for k, weight in zip(some, found.x[c:], strict=True) if weight > 1e-6]


def ending(r: _Run, *, blown_up: bool) -> str:
    """That the mass of a scene without constraints has almost ended in a direction, by its coordinate; else nothing.

    It is looked at in the last row, or where a run has blown up, in the last rows before its energy did.
    """
    if r.scene.info.multipliers or not len(r.u):
        return ""
    first = mass(r, 0)
    scale = np.sqrt(np.diag(first))
    last = len(r.u) - 1
    if blown_up:
        beyond = ~(np.abs(r.energy) <= GROWN * float(np.abs(r.energy[0])))
        last = max(int(np.argmax(beyond)) - 1, 0) if beyond.any() else last
    rows = range(max(last - BEFORE, 0) if blown_up else last, last + 1)
    parts = [np.linalg.eigh(mass(r, row) / np.outer(scale, scale)) for row in rows]
    k = int(np.argmin([x.eigenvalues[0] for x in parts]))
    values, vectors = parts[k]
    if not values[0] < ENDS:
        return ""
    name = r.scene.coordinates[int(np.argmax(np.abs(vectors[:, 0])))][0]
    return (
        f"the mass of '{name}' has fallen to {values[0]:.2g} of that at the start at t = {r.t[rows[k]]:.6g} s, and is "
        "about to be singular; choose coordinates in which it is not"
    )
