"""The explorer's page: what its scripts compute, by Node alone, against kernels, steps by hand and certificates.

What a browser makes of the page is in test_explorer_browser.py.
"""

import json
import math
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from by_hand import SCENES
from declared import BY_NAME, NAMES, UNDAMPED
from nonlinear_oracle import history
from substep_derive import certify
from substep_explorer import page as explorer
from substep_kernels.facts import CATALOGUE
from sympy import oo, sympify
from test_emit import check_stability
from test_page import Reader
from test_pairs import PARAMETERS
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app

OMEGA, XI, STEPS = (1e-3, 0.1, 0.5, 1.3, 3.0, 10.0), (0.0, 0.05), 25
MARCHED = ("linear_oscillator", "simple_pendulum", "elastic_pendulum")
# parameters at which each boundary decides: several eigenvalues, numbers of several fields, eigenvalues kept on the
# circle, and pairs of them that meet at one Omega
DECIDED = (
    ("gholampour", {"delta": "0.02", "alpha_g": "0.28"}, "0"),
    ("gholampour", {"delta": "0.02", "alpha_g": "0.28"}, "0.1"),
    ("generalized_alpha", {"alpha_m": "-0.98", "alpha_f": "0.07", "beta": "0.27", "gamma": "0.4"}, "0.1"),
    ("wbz_alpha", {"alpha_B": "0.08"}, "0.1"),
    ("hht_alpha", {"alpha": "-0.5"}, "0"),
    ("wilson_theta", {"theta": "1.2"}, "0.02"),
    ("newmark", {"beta": "0.2", "gamma": "0.5"}, "0.1"),
    ("newmark", {"beta": "0.2", "gamma": "0.4"}, "0"),
    ("generalized_alpha", {"rho_inf": "0.3"}, "0"),
    ("oalts", {"rho_inf": "1"}, "0"),
    ("bdf3", {}, "0.05"),
    ("bdf3", {}, "0.1"),
    ("bdf4", {}, "0.07"),
    ("park", {}, "0.3"),
    ("rho_inf_bathe", {"rho_inf": "0.3"}, "0.05"),
    ("rho_inf_bathe", {"rho_inf": "1"}, "0"),
    ("four_substep", {"rho_inf": "0.83"}, "0.05"),
    ("three_substep_third_order", {"gamma": "0.42"}, "0.1"),
    ("crouzeix4", {"gamma": "1.1"}, "0.02"),
    ("butcher6", {}, "0.3"),
    ("suzuki", {}, "0"),
    ("suzuki", {"weight": "0.4"}, "0"),
    ("gssss_v0", {"rho_1": "0.9", "rho_3": "0.2"}, "0.05"),
    ("bdf_alpha", {"alpha": "-0.4"}, "0.1"),
    ("zhai", {"psi": "0.4"}, "0.02"),
    ("adams_moulton4", {}, "0.05"),
)
SYNONYMS = sorted({one.split(": ")[0] for s in BY_NAME.values() for one in s.synonyms})
ASKED = (*NAMES, *SYNONYMS, "Crank\u2013Nicolson", "Verlet", "GeneralizedAlpha", "Wilson's method", "Bathe & Baig")
ROUNDING = 1e-12  # of the largest value, as in test_pairs


def marches() -> list[dict[str, Any]]:
    """The scenes with the parameters, and steps, that they have by hand."""
    found = []
    for name in MARCHED:
        scene, hand = ss.scene(name, **SCENES[name].parameters), SCENES[name]
        parameters = {key: float(value) for key, value in scene.parameters.items()}
        found.append({"scene": name, "parameters": parameters, "h": hand.dt, "n": STEPS})
    return found


def requests() -> list[dict[str, Any]]:
    """Of every scheme at its defaults, and at other parameters with marches."""
    return [
        {
            **{"name": name, "given": {key: repr(x) for key, x in given.items()}, "Omega": OMEGA, "xi": XI},
            **{"damping_ratio": "0", "marches": own},
        }
        for name in NAMES
        for given, own in (({}, []), (PARAMETERS.get(name, {}), marches()))
    ]


@pytest.fixture(scope="module")
def computed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the page's scripts compute for every scheme, away from its defaults: one process for all of them."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node, which is not installed here")
    folder = tmp_path_factory.mktemp("explorer")
    decided = [
        {"name": name, "given": given, "Omega": [], "xi": [], "damping_ratio": xi, "marches": []}
        for name, given, xi in DECIDED
    ]
    (folder / "requests.json").write_text(json.dumps(requests() + decided), encoding="utf-8")
    (folder / "asked.json").write_text(json.dumps(ASKED), encoding="utf-8")
    scripts = "\n".join(explorer.source(name) for name in (explorer.SCHEMES, *explorer.OWN))
    (folder / "scripts.js").write_text(scripts, encoding="utf-8")
    program = Path(__file__).with_name("explorer_values.js")
    command = [node, *map(str, (program, *(folder / name for name in ("scripts.js", "requests.json", "asked.json"))))]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=100)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def of(computed: dict[str, Any], scheme: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """What was found of a scheme at its defaults, and at other parameters."""
    first, second, *_ = (found for found in computed["results"] if found["name"] == scheme)
    return first, second


def check_functions(scheme: str, computed: dict[str, Any]) -> None:
    """Parameters, matrices and stability functions against the kernels."""
    for found, given in zip(of(computed, scheme), ({}, PARAMETERS.get(scheme, {})), strict=True):
        s = ss.scheme(scheme, **given)
        assert found["values"] == pytest.approx({k: float(x) for k, x in s.parameters.items()}, rel=1e-15)
        points = iter(found["points"])
        for Omega in OMEGA:
            for xi in XI:
                point = next(points)
                check_stability(s, Omega, xi, np.array([float(x) for x in point["numbers"]]))
                if scheme not in UNDAMPED or xi == 0.0:
                    expected = s.amplification(Omega, xi)
                    assert np.abs(point["matrix"] - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())


def check_marches(scheme: str, computed: dict[str, Any]) -> None:
    """The first periods of motions against steps by hand."""
    found = of(computed, scheme)[1]
    for name, march in zip(MARCHED, found["marches"], strict=True):
        hand = SCENES[name]
        if scheme in UNDAMPED and hand.system.damping.any():
            assert "expected a motion without damping" in march["failed"]
            continue
        assert march["failed"] == ""
        start = hand.a0 if hand.a0 is not None else unloaded(hand)
        system = without_load(hand)
        expected = history(scheme, found["values"], system, hand.dt, STEPS, hand.u0, hand.v0, start)
        rows = np.array(march["rows"])
        for k in range(3):
            scale = np.abs(expected[k]).max()
            assert np.abs(rows[:, k] - expected[k]).max() <= ROUNDING * scale, (name, "uva"[k])


@pytest.mark.usefixtures("plain_functions")
@pytest.mark.parametrize("scheme", NAMES)
def test_stability_functions_are_the_kernels(scheme: str, computed: dict[str, Any]) -> None:
    check_functions(scheme, computed)


@pytest.mark.parametrize("scheme", NAMES)
def test_marches_are_the_papers_steps(scheme: str, computed: dict[str, Any]) -> None:
    check_marches(scheme, computed)


def without_load(hand: Any) -> Any:
    """The system by hand, its load left out: the page marches free motions."""
    return replace(hand.system, load=lambda t: 0.0)


def unloaded(hand: Any) -> np.ndarray:
    """The consistent acceleration at the start of a free motion."""
    return without_load(hand).acceleration(hand.u0, hand.v0, 0.0)


@pytest.mark.parametrize("scheme", NAMES)
def test_the_verdict_is_the_certificates(scheme: str, computed: dict[str, Any]) -> None:
    first, row, constant = of(computed, scheme)[0], CATALOGUE[scheme], BY_NAME[scheme].constant
    found = first["certificate"]
    if constant is not None and constant.number.polynomial.degree() > 8:
        assert found == f"its numbers are of degree {constant.number.polynomial.degree()}, which takes seconds"
    elif found == "Infinity" or first["only_at_points"]:
        assert row["critical_Omega"] == "none"
        expected = {"gauss2": 2 * math.sqrt(3), "gauss3": math.sqrt(10), "lobatto_iiia3": 2 * math.sqrt(3)}
        assert float(found) == pytest.approx(expected.get(scheme, math.inf), rel=1e-14)  # where the step is -I
    else:
        assert float(found) == pytest.approx(float(sympify(row["critical_Omega"])), rel=1e-14)


@pytest.mark.filterwarnings("ignore:.* is not A-stable at")
@pytest.mark.parametrize("k", range(len(DECIDED)))
def test_the_verdict_is_the_certificates_at_other_parameters(k: int, computed: dict[str, Any]) -> None:
    name, given, xi = DECIDED[k]
    found = computed["results"][2 * len(NAMES) + k]["certificate"]
    certificate = certify(name, xi=xi, **given)
    limit = certificate.critical_Omega
    expected = math.inf if certificate.stable else float(0 if limit is None else sympify(str(limit)))
    assert float(found) == pytest.approx(expected, rel=1e-14)
    points = [low for low, high, *_ in certificate.multiple if low == high]
    every_other = bool(points) and len(certificate.intervals) == len(points) + 1 and certificate.intervals[-1][1] == oo
    assert computed["results"][2 * len(NAMES) + k]["only_at_points"] == every_other
    values = {key: float(x) for key, x in ss.scheme(name, **{k: float(x) for k, x in given.items()}).parameters.items()}
    assert computed["results"][2 * len(NAMES) + k]["values"] == pytest.approx(values, rel=1e-14)


def test_a_name_or_synonym_finds_what_the_package_finds(computed: dict[str, Any]) -> None:
    for asked, found in zip(ASKED, computed["found"], strict=True):
        names = [one["scheme"] for one in found["named"]]
        try:
            assert names == [ss.scheme(asked).name]
        except ValueError as error:  # of several, or of parameters: the error has the names
            values = {f"{key}={text}" for one in found["named"] for key, text in one["given"].items()}
            assert names, asked
            assert all(part in str(error) for part in {*names, *values}), asked
    (part,) = (found for asked, found in zip(ASKED, computed["found"], strict=True) if asked == "Bathe & Baig")
    assert part == {"named": [{"scheme": "bathe", "given": {}}], "others": []}
    assert {one["scheme"] for one in computed["found_in"][0]["others"]} >= {"houbolt", "wbz_alpha"}  # by references
    assert computed["found_in"][1:] == [{"named": [], "others": []}] * 2


def test_numbers_of_a_field_are_exact(computed: dict[str, Any]) -> None:
    assert computed["signs"] == [0, -1, 1, 0]  # 665857/470832 exceeds the square root of 2 by 1.6e-12
    assert computed["rational"] == [True, ["1", "2"], None, None]
    assert computed["roots"] == pytest.approx([math.sqrt(2), math.sqrt(3)], rel=1e-15)


def test_pairs_that_stay_on_the_circle_are_told_from_those_that_meet(computed: dict[str, Any]) -> None:
    assert computed["lost"] == ["2", "in doubt at 1", "in doubt at 1", "in doubt at 2"]


def test_an_address_holds_the_state_and_what_says_nothing_is_named(computed: dict[str, Any]) -> None:
    assert computed["again"]
    assert computed["refused"] == []
    assert computed["initial"]
    names = [text.split(" = ")[0] for text in computed["wrong"]]
    (outside,), (both,), (leading_outside,) = computed["impossible"]
    assert outside == "a.rho_inf = 0.25"
    assert both == "parameters of b, since gamma decides rho_inf: give one of the two"
    assert leading_outside.startswith("parameters of b, since rho_inf would be 1.02")
    assert sorted(names) == sorted(["a", "a.beta", "b.beta", "xi", "ratio", "scene", "scene.EA", "quantity", "what"])


def test_the_page_stands_alone_and_is_small(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["explorer", "--out", str(tmp_path / "page.html")])
    assert result.exit_code == 0, result.output
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert len(text.encode()) < 2_000_000
    markup = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)
    reader = Reader(markup.replace("<input", "<img"))  # a tag without an end, as the reader knows another
    assert reader.links == []
    assert reader.images == []
    assert len(set(reader.ids)) == len(reader.ids)
    own = "\n".join(explorer.source(name) for name in (explorer.SCHEMES, *explorer.OWN, "view.js"))
    assert "fetch(" not in own
    assert "import(" not in own
    assert text == explorer.page()


def test_a_library_that_is_not_the_one_checked_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    shutil.copytree(Path(explorer.__file__).parent, tmp_path / "explorer")
    library = tmp_path / "explorer" / explorer.CHARTS
    library.write_text(library.read_text(encoding="utf-8") + " ", encoding="utf-8")
    monkeypatch.setattr(explorer, "files", lambda package: tmp_path / "explorer")
    with pytest.raises(ValueError, match="run make vendor"):
        explorer.source(explorer.CHARTS)
