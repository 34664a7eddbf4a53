"""A program with an adapter, in a process of its own: its integrators as steppers."""

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from threading import Timer
from typing import Any

from substep.core.errors import unknown_name

from .claims import Claims
from .programs.adapter import Integrator, Load, Spring
from .stepper import Run, Stepper

ADAPTERS = Path(__file__).parent / "programs"
THIS = sys.executable
SUFFIX = "_adapter"
MEASURES = ("scheme", "order", "rho_inf", "unconditional", "critical_Omega")


def programs() -> tuple[str, ...]:
    """Names of the programs that have an adapter."""
    return tuple(sorted(path.stem.removesuffix(SUFFIX) for path in ADAPTERS.glob(f"*{SUFFIX}.py")))


@dataclass
class Program:
    """A running adapter; use it in a `with` statement, or `close` it.

    name: of an adapter, or the path of one of your own, a .py file. python: the command of the interpreter that has the
    program. longest: seconds that a run may take. integrators: name -> what it can do and claims. seconds: of CPU that
    its processes had taken when they answered last, their starts included.
    """

    name: str
    python: str = THIS
    longest: float = 600.0
    version: str = ""
    license: str = ""
    program: str = field(init=False)
    integrators: Mapping[str, Integrator] = field(default_factory=dict[str, Integrator], repr=False)
    seconds: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        self._script = ADAPTERS / f"{self.name}{SUFFIX}.py"
        if self.name.endswith(".py"):
            self._script = Path(self.name).absolute()
        if not self._script.is_file():
            raise unknown_name("a program with an adapter", self.name, programs())
        self._begin()
        described = self.asked({"do": "describe"})
        self.program, self.version, self.license = (described[key] for key in ("program", "version", "license"))
        self.integrators = {name: Integrator(**entry) for name, entry in described["integrators"].items()}

    def _begin(self) -> None:
        self._spent = 0.0
        paths = (str(ADAPTERS), os.environ.get("PYTHONPATH"))  # where an adapter of one's own finds `adapter`
        try:
            self._process = subprocess.Popen(
                [*shlex.split(self.python), str(self._script)],
                env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                encoding="utf-8",
            )
        except OSError as error:
            raise ValueError(
                f"expected the command of an interpreter, got {self.python!r}: {error}; give the one that has it"
            ) from error

    def asked(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """The answer to a request. Raises ValueError where the program raises, ends or takes too long.

        One that has ended is begun anew for the next request.
        """
        if self._process.poll() is not None:
            self.close()
            self._begin()
        pipe_in, pipe_out = self._process.stdin, self._process.stdout
        assert pipe_in is not None and pipe_out is not None
        watch = Timer(self.longest, self._process.kill)
        watch.start()
        try:
            pipe_in.write(json.dumps(request) + "\n")
            pipe_in.flush()
            line = pipe_out.readline()
        except BrokenPipeError:
            line = ""
        finally:
            watch.cancel()
        if not line:
            raise ValueError(
                f"expected an answer of the adapter {self.name} within {self.longest:g} s, got the end of its process "
                f"(exit code {self._process.wait()}); run `PYTHONPATH={ADAPTERS} {self.python} {self._script}` "
                "to see why, or give the interpreter that has the program"
            )
        answer: dict[str, Any] = json.loads(line)
        spent = answer.pop("seconds")
        self.seconds, self._spent = self.seconds + spent - self._spent, spent
        if "error" in answer:
            raise ValueError(f"expected a run of {self.name}, got {answer['error']}")
        return answer

    def stepper(self, integrator: str, arguments: Mapping[str, Any] | None = None) -> Stepper:
        """One of its integrators, with its own arguments unless others are given. Raises ValueError for others."""
        if integrator not in self.integrators:
            raise unknown_name(f"an integrator of {self.name}", integrator, self.integrators)
        can = self.integrators[integrator]
        given, known = dict(can.arguments) | dict(arguments or {}), can.arguments | can.defaults
        if unknown := [name for name in given if name not in known]:
            raise unknown_name(f"an argument of {integrator}", unknown[0], known)

        def runs(arguments: Mapping[str, Any]) -> Run:
            def run(
                omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load, a0: float | None = None,
                force: Spring | None = None, **states: Any,
            ) -> Any:  # fmt: skip
                if can.one_run:
                    self._process.kill()
                    self._process.wait()
                if force is not None:
                    states["force"] = asdict(force)
                answer = self.asked({
                    "do": "run", "integrator": integrator, "arguments": arguments, "omega": omega, "xi": xi, "dt": dt,
                    "n": n, "u0": u0, "v0": v0, "a0": a0, "load": asdict(load), **states,
                })  # fmt: skip
                load.called.extend(answer["called"])
                return answer["u"], answer["v"], answer["a"]

            return run

        def controlled(omega: float, xi: float, tol: float, t_end: float, u0: float, v0: float) -> Any:
            answer = self.asked({
                "do": "control", "integrator": integrator, "arguments": given, "omega": omega, "xi": xi, "tol": tol,
                "t_end": t_end, "u0": u0, "v0": v0,
            })  # fmt: skip
            return answer["t"], answer["u"], answer["v"], answer["errors"]

        own = controlled if can.adaptive else None
        written_out = runs({**given, **can.defaults, **given}) if can.defaults.keys() - given.keys() else None
        return Stepper(runs(given), can, f"{self.program} {integrator}", self.version, given, own, written_out)

    def claims(self, integrator: str) -> Claims:
        """What its manual claims of an integrator at its own arguments."""
        stated = self.integrators[integrator].claims
        values = {name: stated[name][0] for name in MEASURES if name in stated}
        parameters = {name: entry[0] for name, entry in stated.items() if name not in MEASURES}
        source = {name: (entry[1], entry[2]) for name, entry in stated.items()}
        return Claims(**values, parameters=parameters, source=source)

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.communicate()

    def __enter__(self) -> "Program":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
