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


@dataclass(frozen=True)
class Integrator:
    """What a program can do with one of its integrators, and what its manual claims.

    arguments: names and values that are sent to `run`, in the order and under the names of the manual.
    sets_a0: whether an acceleration at t = 0 can be given; otherwise the program finds, or assumes, its own.
    outputs: those of "u", "v", "a" that it returns. late: by how many steps an output stands after the end of its step,
    such as {"v": -0.5} for velocities at half steps. load: "function" where it is called at instants that the program
    chooses, "samples" where the program is handed values at the ends of the steps, "none" where it takes none.
    damping: whether a damped oscillator can be run. nonlinear: whether `run` takes force=, a `Spring` in place of
    omega**2 u. adaptive: whether it chooses its steps by a tolerance, by `controlled` of `serve`. calls: of the program
    that make one step of the scheme. digits: decimal digits that its results can have.
    claims: name -> (value, quotation, place in the manual): "scheme", "order", "rho_inf", "unconditional",
    "critical_Omega" and the scheme's parameters.
    """

    arguments: dict[str, Any] = field(default_factory=dict[str, Any])
    sets_a0: bool = False
    outputs: str = "uva"
    late: dict[str, float] = field(default_factory=dict[str, float])
    load: str = "function"
    damping: bool = True
    nonlinear: bool = False
    adaptive: bool = False
    calls: int = 1
    digits: float = 15.0
    claims: dict[str, tuple[Any, str, str]] = field(default_factory=dict[str, tuple[Any, str, str]])


@dataclass
class Load:
    """A force per unit mass: amplitude times 1, t, or sin(omega t + phase); `called` keeps when it was asked for."""

    kind: str = "none"
    amplitude: float = 1.0
    omega: float = 0.0
    phase: float = 0.0
    called: list[float] = field(default_factory=list[float])

    def __call__(self, t: float) -> float:
        """The load at t."""
        t = float(t)
        self.called.append(t)
        return self.at(t)

    def at(self, t: float) -> float:
        """The load at t, without a record of the call."""
        if self.kind == "none":
            return 0.0
        if self.kind == "constant":
            return self.amplitude
        if self.kind == "ramp":
            return self.amplitude * t
        if self.kind == "harmonic":
            return self.amplitude * math.sin(self.omega * t + self.phase)
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
    """Answer requests until standard input ends.

    run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load) returns histories u, v, a, n + 1 numbers each from
    t = 0 on, for u'' + 2 xi omega u' + omega**2 u = load(t); None in place of one that the program does not return.
    a0 is None where the program is to find its own. force, given to an integrator that is `nonlinear` only, takes the
    place of omega**2 u.

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
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def _plain(numbers: Any) -> list[float]:
    return [float(x) for x in numbers]


def _answers() -> TextIO:
    """Standard output for answers alone: what the program prints, also from C, goes to standard error from now on."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return answers
