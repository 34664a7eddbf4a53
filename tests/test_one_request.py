"""What is asked of steps and of the end is refused in the same words of scenes, structures and modes alike."""

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from small_frame import frame

import substep as ss

NAN = float("nan")
RHO = ss.scheme("generalized_alpha", rho_inf=0.5)
BAD_ENDS = {-1.0: "t_end > 0, got -1.0", 0.0: "t_end > 0, got 0.0", NAN: "t_end to be finite, got nan"}
BAD_STEPS = {0.0: "dt > 0, got 0.0", -0.1: "dt > 0, got -0.1", NAN: "dt to be finite, got nan"}


def subjects() -> dict[str, Any]:
    bent = ss.structure([[1.0]], internal_force=lambda u: u + u**3, tangent=lambda u: [1.0 + 3.0 * u * u], u0=1.0)
    return {
        "scene": ss.scene("linear_oscillator", omega=2.0),
        "structure": frame(),
        "nonlinear": bent,
        "modes": frame().modes(2),
    }


def calls(kind: str) -> list[Callable[..., Any]]:
    """The ways in which a subject is marched or swept."""
    subject = subjects()[kind]
    found: list[Callable[..., Any]] = [lambda **x: ss.march(subject, "bathe", **x)]
    if kind != "modes":
        found.append(lambda **x: ss.sweep(subject, "bathe", **x))
    if kind != "scene":
        found.append(lambda **x: subject.march("bathe", **x))
    return found


@pytest.mark.parametrize("kind", subjects())
def test_steps_and_the_end_of_a_run(kind: str) -> None:
    for call in calls(kind):
        for t_end, message in BAD_ENDS.items():
            with pytest.raises(ValueError, match=f"^expected {re.escape(message)}"):
                call(dt=0.1, t_end=t_end)
        for dt, message in BAD_STEPS.items():
            with pytest.raises(ValueError, match=f"^expected {re.escape(message)}"):
                call(dt=dt, t_end=1.0)
        with pytest.raises(ValueError, match=r"^expected t_end to be a multiple of dt = 0.3, got 1"):
            call(dt=0.3, t_end=1.0)


@pytest.mark.parametrize("kind", ["structure", "modes"])
def test_the_end_of_a_choice(kind: str) -> None:
    for t_end, message in BAD_ENDS.items():
        with pytest.raises(ValueError, match=f"^expected {re.escape(message)}"):
            ss.choose(subjects()[kind], 1e-2, t_end=t_end, quantity=0)


@pytest.mark.parametrize("kind", ["scene", "structure", "nonlinear"])
def test_axes_of_a_sweep(kind: str) -> None:
    subject = subjects()[kind]
    for asked, message in (
        ({"dt": [0.1, 0.0]}, r"dt in \(0.0, inf\), got 0.0"),
        ({"dt": [0.1, -0.1]}, r"dt in \(0.0, inf\), got -0.1"),
        ({"dt": [0.1, NAN]}, "dt to be finite, got nan at index"),
        ({"dt": 0.1, "grid": [0.5]}, "grid with tol only, got it with dt"),
        ({"dt": 0.1, "rtol": 1e-3}, "rtol with tol only, got it with dt"),
        ({"dt": 0.1, "keep": "all"}, "keep, one of: final, peak, history; got 'all'"),
        ({"dt": 0.1, "rho_inf": [0.5], "scheme_rho_inf": [0.8]}, "rho_inf of the scheme once, got rho_inf and"),
        ({"dt": 0.1, "rho": [0.5]}, "a parameter of generalized_alpha, .* got 'rho'"),
        ({"dt": 0.1, "rho_inf": [0.5, NAN]}, "rho_inf to be finite, got nan"),
        ({"dt": 0.1, "rho_inf": [0.5, 2.0]}, r"rho_inf of generalized_alpha in \[0.*, 1.*\], got 2"),
    ):
        with pytest.raises(ValueError, match=f"^expected .*{message}"):
            ss.sweep(subject, "generalized_alpha", t_end=1.0, **asked)
    changed = RHO.__class__(RHO.info, {**RHO.parameters, "beta": np.array(0.3)}, RHO.given)
    with pytest.raises(ValueError, match="a scheme as ss.scheme makes it, beta = .*, got 0.3; make it anew"):
        ss.sweep(subject, changed, dt=0.1, t_end=1.0)


@pytest.mark.usefixtures("plain_in_gate")
@pytest.mark.parametrize("kind", ["scene", "structure", "nonlinear"])
def test_an_axis_stands_in_place_of_what_a_handle_was_given(kind: str) -> None:
    """A family's argument replaces all that it made; the prefix names the same."""
    subject = subjects()[kind]
    for name in ("rho_inf", "scheme_rho_inf"):
        found = ss.sweep(subject, RHO, dt=0.1, t_end=1.0, **{name: [0.2, 0.9]})
        assert found.u.dims[0] == name
        for k, rho in enumerate((0.2, 0.9)):
            r = ss.march(subject, ss.scheme("generalized_alpha", rho_inf=rho), 0.1, 1.0)
            assert np.allclose(found.u[k], r.u[-1], rtol=0, atol=1e-12)
    kept = ss.sweep(subject, RHO, dt=[0.1], t_end=1.0)
    assert np.allclose(kept.u[0], ss.march(subject, RHO, 0.1, 1.0).u[-1], rtol=0, atol=1e-12)
