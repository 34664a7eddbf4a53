"""What every adapter of a program shares: how it describes its integrators, the loads, and the loop that serves runs.

An adapter is a script of its own beside this file. It runs in the interpreter that has the program and imports the
standard library, NumPy and the program only; it reads requests from standard input and writes answers to standard
output, one JSON object a line. What the program itself prints goes to standard error.
"""

import json
import math
import os
import sys
import traceback
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any, TextIO

LOADS = {  # how a program is given its load: `Integrator.load`, and what that means
    "function": "called by the program",
    "each step": "set before each step",
    "samples": "handed over as samples at the ends of steps",
    "series": "a series of the program's own",
    "none": "none can be given",
}


@dataclass(frozen=True)
class Integrator:
    """What a program can do with one of its integrators, and what its manual claims.

    arguments: names and values that are sent to `run`, in the order and under the names of the manual. defaults: of
    arguments that are left out of those, the values that the manual gives them; the audit runs both, and compares.
    sets: those of "u", "v", "a" that can be given at t = 0. Without an acceleration the program finds, or assumes, its
    own; motion from a u or v that cannot be given is u0 + v0 t and a motion that starts from the rest.
    history: how many states before t = 0 it has to be given; startup: how many first steps another scheme makes.
    outputs: those of "u", "v", "a" that it returns. late: by how many steps an output stands after the end of its step,
    such as {"v": -0.5} for velocities at half steps: what is late by whole steps is moved to where it stands, and what is
    late by half a step compared by the mean of two neighbours. calls: of the program that make one step of
    the scheme. load: one of `LOADS`; the instants of calls are known for "function" and "each step" only.
    damping: whether a damped oscillator can be run. nonlinear: whether `run` takes force=, a `Spring` in place of
    omega**2 u. adaptive: whether it chooses its steps by a tolerance, by `controlled` of `serve`.
    digits: decimal digits that its results can have. absolute: the tolerance at which its iterations end, where it is
    one of displacements or forces themselves: starts and loads are made so large that it hides no digits; 0 where it is
    relative, or there is none.
    one_run: whether a process can make one run only. seconds: that a call takes, where it is long: what needs many
    steps is then left out.
    claims: name -> (value, quotation, place in the manual): "scheme", "order", "rho_inf", "unconditional",
    "critical_Omega" and the scheme's parameters.

    Raises ValueError for values that are none of these.
    """

    arguments: dict[str, Any] = field(default_factory=dict[str, Any])
    defaults: dict[str, Any] = field(default_factory=dict[str, Any])
    sets: str = "uv"
    history: int = 0
    startup: int = 0
    outputs: str = "uva"
    late: dict[str, float] = field(default_factory=dict[str, float])
    calls: int = 1
    load: str = "function"
    damping: bool = True
    nonlinear: bool = False
    adaptive: bool = False
    digits: float = 15.0
    absolute: float = 0.0
    one_run: bool = False
    seconds: float = 0.0
    claims: dict[str, tuple[Any, str, str]] = field(default_factory=dict[str, tuple[Any, str, str]])

    def __post_init__(self) -> None:
        if self.load not in LOADS:
            raise ValueError(f"expected a load that is one of {', '.join(LOADS)}, got {self.load!r}")
        for name, given in (("sets", self.sets), ("outputs", self.outputs), ("late", "".join(self.late))):
            if set(given) - set("uva"):
                raise ValueError(f"expected {name} of the letters u, v and a, got {given!r}")
        if "u" not in self.outputs or "u" in self.late:
            raise ValueError("expected displacements at the ends of the steps among the outputs, got none; read them")
        if self.from_rest and (self.nonlinear or self.load == "none"):
            raise ValueError(
                f"expected an integrator that sets u and v, got sets={self.sets!r}; without these its motion is found "
                "by superposition, for which it must be linear and take a load"
            )

    @property
    def from_rest(self) -> bool:
        """Whether u or v cannot be given at t = 0."""
        return not {"u", "v"} <= set(self.sets)


@dataclass
class Load:
    """A force per unit mass: amplitude times 1, t, or sin(omega t + phase), and offset + slope t besides.

    `called` keeps when it was asked for. There are an offset and a slope for integrators only that start from rest.
    """

    kind: str = "none"
    amplitude: float = 1.0
    omega: float = 0.0
    phase: float = 0.0
    offset: float = 0.0
    slope: float = 0.0
    called: list[float] = field(default_factory=list[float])

    def __call__(self, t: float) -> float:
        """The load at t."""
        t = float(t)
        self.called.append(t)
        return self.at(t)

    def at(self, t: float) -> float:
        """The load at t, without a record of the call."""
        line = self.offset + self.slope * t
        if self.kind == "none":
            return line
        if self.kind == "constant":
            return self.amplitude + line
        if self.kind == "ramp":
            return self.amplitude * t + line
        if self.kind == "harmonic":
            return self.amplitude * math.sin(self.omega * t + self.phase) + line
        raise ValueError(f"expected a load that is none, constant, ramp or harmonic, got {self.kind!r}")


@dataclass(frozen=True)
class Spring:
    """An internal force per unit mass, stiffness u + cubic u^3; u is a number or an array."""

    stiffness: float
    cubic: float

    def __call__(self, u: Any, v: Any = None) -> Any:
        """The force at u; the velocity plays no part."""
        return (self.stiffness + self.cubic * u * u) * u

    def slope(self, u: Any) -> Any:
        """Its derivative."""
        return self.stiffness + 3.0 * self.cubic * u * u

    def potential(self, u: Any) -> Any:
        """Of which it is the slope."""
        return (0.5 * self.stiffness + 0.25 * self.cubic * u * u) * u * u


Run = Callable[..., tuple[Any, Any, Any]]
Controlled = Callable[..., tuple[Any, Any, Any, Any]]


def serve(
    program: str,
    version: str,
    license: str,
    integrators: dict[str, Integrator],
    run: Run,
    controlled: Controlled | None = None,
) -> None:
    """Answer requests until standard input ends, each with the CPU seconds that this process has taken so far.

    run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load) returns histories u, v, a, n + 1 numbers each from
    t = 0 on, for u'' + 2 xi omega u' + omega**2 u = load(t); None in place of one that the program does not return.
    a0 is None where the program is to find its own. force, given to an integrator that is `nonlinear` only, takes the
    place of omega**2 u. before, given to one with a `history` only, are u, v, a at t = -dt, -2 dt, ..., so many rows.

    controlled(integrator, arguments, omega, xi, tol, t_end, u0, v0), of integrators that are `adaptive`, returns the
    times at which the program's own steps end, the start included, u and v there, and the estimated errors of u and of
    v in each step, or None.
    """
    answers = _answers()
    for line in sys.stdin:
        request = json.loads(line)
        try:
            do = request.pop("do")
            if do == "describe":
                answer: dict[str, Any] = {
                    "program": program,
                    "version": version,
                    "license": license,
                    "integrators": {name: asdict(integrator) for name, integrator in integrators.items()},
                }
            elif do == "control" and controlled is not None:
                t, u, v, errors = controlled(**request)
                answer = {"t": _plain(t), "u": _plain(u), "v": _plain(v)}
                answer["errors"] = None if errors is None else [_plain(x) for x in errors]
            else:
                load = Load(**request.pop("load"))
                if "force" in request:
                    request["force"] = Spring(**request["force"])
                histories = run(**request, load=load)
                answer = {"called": load.called}
                answer |= {k: None if y is None else _plain(y) for k, y in zip("uva", histories, strict=True)}
        except Exception as error:
            traceback.print_exc()
            answer = {"error": f"{type(error).__name__}: {error}"}
        answer["seconds"] = sum(os.times()[:4])  # with those of programs that it ran and has waited for
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def _plain(numbers: Any) -> list[float]:
    return [float(x) for x in numbers]


def _answers() -> TextIO:
    """Standard output for answers alone: what the program prints, also from C, goes to standard error from now on."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return answers
