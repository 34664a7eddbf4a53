"""The explorer in a real browser: `make test-browser`, which fetches playwright-core and says what else it needs.

What the page computes is compared as in test_explorer.py, where Node alone runs its scripts.
"""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from substep_explorer import page as explorer
from test_explorer import NAMES, check_functions, check_marches, requests

import substep as ss

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the browser shows, if $SUBSTEP_BROWSER says where playwright-core is; $SUBSTEP_PICTURES keeps pictures."""
    node, browser = shutil.which("node"), next(filter(None, map(shutil.which, BROWSERS)), None)
    library = Path(os.environ.get("SUBSTEP_BROWSER", "nowhere")) / "node_modules" / "playwright-core"
    if node is None or browser is None or not library.exists():
        pytest.skip("needs node, Chromium and playwright-core: run make test-browser")
    folder = tmp_path_factory.mktemp("browser")
    pictures = Path(os.environ.get("SUBSTEP_PICTURES", folder))
    page = explorer.write(folder / "page.html")
    program = Path(__file__).with_name("explorer_browser.js")
    (folder / "requests.json").write_text(json.dumps(requests()), encoding="utf-8")
    command = [node, program, library.resolve(), browser, page, pictures, folder / "profile", folder / "requests.json"]
    done = subprocess.run([str(x) for x in command], capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_nothing_is_logged_and_nothing_is_fetched(seen: dict[str, Any]) -> None:
    assert seen["said"] == []
    assert all(url.startswith(("file://", "about:blank", "data:", "blob:")) for url in seen["asked"])


@pytest.mark.usefixtures("plain_functions")
@pytest.mark.parametrize("scheme", NAMES)
def test_the_browser_computes_the_kernels_and_the_papers_steps(scheme: str, seen: dict[str, Any]) -> None:
    check_functions(scheme, seen)
    check_marches(scheme, seen)


@pytest.mark.parametrize("scheme", NAMES)
def test_every_slider_of_every_scheme_moves(scheme: str, seen: dict[str, Any]) -> None:
    found = seen["schemes"][scheme]
    info = ss.scheme(scheme).info
    assert found["moved"] == len(info.parameters) + len(info.families)
    # a slider's end is refused, with the reason, where another parameter would leave its interval by it
    assert all(re.fullmatch(r"|\w+ = \S+: \w+ would be \S+, which is not in .*", text) for text in found["messages"])
    assert ("" in found["messages"]) == bool(found["moved"])
    decided = ("for every Ω > 0", "for 0 < Ω < ", "unstable for small Ω")
    assert found["stable"].startswith(
        decided if scheme != "yoshida6" else "not decided in the page: its numbers are of"
    )
    assert set(found["drawn"]) == {"radius", "damping", "period", "plane", "march"}
    assert all(count[0] > 0 for count in found["drawn"].values())
    expected = float(ss.scheme(scheme).spectral_radius(2 * np.pi * 0.1))
    assert float(found["values"]) == pytest.approx(expected, rel=1e-7)  # as many digits as are shown


def test_a_scheme_is_found_by_its_synonyms(seen: dict[str, Any]) -> None:
    sought, several = seen["sought"], "may be central_difference_lagged, central_difference; the first is shown"
    assert sought["Crank\u2013Nicolson"][:3] == ["average_acceleration", {}, ""]
    assert "Also called trapezoidal, " in sought["Crank\u2013Nicolson"][3]
    assert sought["leapfrog"][:3] == ["central_difference_lagged", {}, f"'leapfrog' {several}"]
    assert sought["symplectic Euler"][:3] == ["tchamwa_wielgosz", {"phi": "1"}, ""]
    assert "gauss3" in sought["Gauss"][2]
    assert sought["no such scheme"][0] == sought["Gauss"][0]
    assert "got 'no such scheme', which no scheme has" in sought["no such scheme"][2]
    assert seen["names"] == len(NAMES) + sum(len(BY_NAME[name].synonyms) for name in NAMES)


def test_a_view_is_cited_by_its_address(seen: dict[str, Any]) -> None:
    cited, s = seen["cited"], ss.scheme("newmark", beta=0.3, gamma=0.6)
    for part in ("a=newmark", "a.beta=0.3", "b=park", "xi=0.02", "scene.EA=1e6", "quantity=energy"):
        assert part in cited["hash"]
    ratios, radii = np.array(cited["radius"]).T
    assert np.abs(radii - s.spectral_radius(2 * np.pi * ratios, 0.02)).max() <= 1e-12
    rows = {name: values for name, *values in cited["rows"]}
    radius, damping, period = s.stability(2 * np.pi * 0.05, 0.02)
    for name, value in (("Spectral radius ρ", radius), ("Numerical damping", damping), ("Period error", period)):
        assert float(rows[name][0]) == pytest.approx(float(value), rel=1e-5)
    assert rows["Stable"] == ["for every Ω > 0, proved", "for every Ω > 0, proved"]


def test_every_motion_is_marched(seen: dict[str, Any]) -> None:
    for scene in ("linear_oscillator", "simple_pendulum", "elastic_pendulum"):
        assert {"displacement", "velocity", "acceleration", "energy"} <= set(seen["scenes"][scene])
        assert all(" steps, ends at " in text for text in seen["scenes"][scene].values())
    assert "strain" in seen["scenes"]["elastic_pendulum"]


def test_keys_move_sliders_and_wrong_input_is_named(seen: dict[str, Any]) -> None:
    xi, ratio, address = seen["keyboard"]
    assert float(xi) == pytest.approx(0.05)
    assert float(ratio) == pytest.approx(0.112)
    assert f"ratio={ratio}" in address
    assert "b.beta=0.3" in address
    message, invalid, kept = seen["wrong"]
    assert "expected a number from" in message
    assert "got 'abc'" in message
    assert invalid == "true"
    assert kept == ratio


def test_tab_reaches_every_control_in_the_order_of_the_page(seen: dict[str, Any]) -> None:
    assert seen["reached"] == seen["stops"]
    assert {"a", "b", "b.beta", "b.beta-range", "xi", "ratio", "scene", "quantity", "periods"} <= set(seen["reached"])


def test_everything_has_a_name_a_table_and_a_dark_form(seen: dict[str, Any]) -> None:
    assert seen["unnamed"] == []
    assert seen["tables"] == 5
    assert seen["dark"] == ["rgb(23, 25, 28)", "#ddd"]
    assert seen["overflow"] <= 0


def test_paper_is_light_and_shows_charts_whole_and_the_address(seen: dict[str, Any]) -> None:
    paper = seen["paper"]
    assert (paper["background"], paper["controls"], paper["address"]) == ("rgb(255, 255, 255)", 0, True)
    assert paper["wider"] <= 0
