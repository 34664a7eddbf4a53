"""Maps of failures against single marches; tiles of all levels; the server, the folder, the page."""

import base64
import json
import math
import re
import threading
import urllib.error
import urllib.request
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.core.arrays import Array
from substep.studies.failures import WORDS, failure_map, tiles

SCHEME = "newmark_bdf2"  # whose kernel on the pendulum is committed
OF_STATUS = {"newton_failed": "Newton failed", "non_finite": "blew up", "energy_bound": "blew up"}


def single(h: float, v0: float, EA: float) -> tuple[str, float]:
    """The word for one march, and its largest E/E0, as the page of results defines them."""
    pendulum = ss.scene("elastic_pendulum", EA=EA, v0=v0, a0=(-19.6 * (v0 / 7.72) ** 2, 0.0))
    n = min(math.floor(10.0 / h + 1e-9), 500)
    r = ss.march(pendulum, SCHEME, h, n * h, energy_bound=1e3 * pendulum.E0)
    ratio = float(r.energy.max() / pendulum.E0)
    return OF_STATUS.get(r.status, "gains energy" if ratio > 1.01 else "survived"), ratio


@pytest.mark.parametrize(
    ("ranges", "steps"),
    [
        ({"h": (0.3, 1.0), "EA": (1e4, 1e12)}, (10, 8)),
        ({"h": (0.05, 1.0), "v0": (1.0, 100.0), "EA": 1e8}, (8, 6)),
        ({"h": 0.4, "v0": (1.0, 100.0), "EA": (1e4, 1e12)}, (6, 6)),
    ],
)
def test_each_pixel_is_one_march(ranges: dict[str, Any], steps: tuple[int, int]) -> None:
    found = failure_map(SCHEME, **ranges, pixels=steps, lanes=7)
    y, x = found.outcome.dims
    words = np.array(WORDS)[found.outcome.values]
    assert len(set(words.ravel())) > 1  # so that there is a border, both of whose sides are compared
    for (j, i), word in np.ndenumerate(words):
        at = {"v0": 7.72, **ranges, x: float(found[x][i]), y: float(found[y][j])}
        expected, ratio = single(**at)
        assert word == expected, at
        if word in ("survived", "gains energy"):  # how a run fails is chaos: the last bit decides when
            assert float(found.max_ratio[j, i]) == pytest.approx(ratio, rel=1e-6)
    first, last = ranges[x]
    np.testing.assert_allclose(found[x], np.geomspace(first, last, steps[0] + 1)[:-1], rtol=1e-14)
    assert found[x].units == {"h": "s", "v0": "m/s"}[x]


def test_some_pixels_are_those_of_the_whole_map() -> None:
    ranges: dict[str, Any] = {"h": (0.3, 1.0), "EA": (1e6, 1e12)}
    whole = failure_map(SCHEME, **ranges, pixels=(24, 16))
    some = failure_map(SCHEME, **ranges, pixels=(24, 16), columns=range(1, 24, 2), rows=range(8, 16))
    assert some.outcome.equals(whole.outcome[8:, 1::2])
    assert some.max_ratio.equals(whole.max_ratio[8:, 1::2])
    assert failure_map(SCHEME, **ranges, pixels=(12, 8)).outcome.equals(whole.outcome[::2, ::2])


def test_a_run_ends_at_its_time_or_after_its_steps() -> None:
    given: dict[str, Any] = {"h": 0.05, "v0": (1.0, 100.0), "EA": (1e6, 1e12), "pixels": (8, 8)}
    gaining = ss.scheme(SCHEME, gamma_t=0.3, beta=0.25, gamma=0.5)  # little in each step
    by_steps, by_time = failure_map(gaining, **given, most_steps=40), failure_map(gaining, **given, t_end=2.0)
    assert by_steps.max_ratio.equals(by_time.max_ratio)
    assert not by_time.max_ratio.equals(failure_map(gaining, **given).max_ratio)


def test_neighbours_on_the_deepest_level_are_different_doubles() -> None:
    side = tiles.SIDE << tiles.DEEPEST
    last = range(side - 9, side)
    ranges = {name: tiles.QUANTITIES[name].limits for name in ("h", "EA")}
    found = failure_map(SCHEME, **ranges, pixels=(side, side), columns=last, rows=last)
    for name in ranges:
        assert (np.diff(found[name].values) > 50 * np.spacing(found[name].values[1:])).all()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"h": 0.1}, "got ranges for none"),
        ({"h": (0.1, 1.0), "v0": (1.0, 2.0), "EA": (1.0, 2.0)}, "got ranges for h, v0, EA"),
        ({"h": (1.0, 0.1), "EA": (1e4, 1e6)}, "expected h as a range"),
        ({"h": (0.1, 1.0, 2.0), "EA": (1e4, 1e6)}, "expected h as a range"),
        ({"h": (0.1, 1.0), "EA": (-1.0, 1e6)}, "expected EA > 0"),
        ({"h": (0.1, 1.0), "EA": (1e4, 1e6), "v0": 0.0}, "expected v0 > 0"),
        ({"h": (0.1, 1.0), "EA": (1e4, 1e6), "pixels": (4, 0)}, "pixels along EA"),
        ({"h": (0.1, 1.0), "EA": (1e4, 1e6), "columns": range(250, 260)}, "256 pixels along h"),
        ({"h": (0.1, 1.0), "EA": (1e4, 1e6), "most_steps": 0}, "counts above 0"),
        ({"h": (0.1, 1.0), "EA": (1e4, 1e6), "device": "gpu"}, "device"),
    ],
)
def test_what_is_no_map_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        failure_map(SCHEME, **wrong)


def runs_of(script: str) -> tuple[str, Array, Array]:
    """Name, outcome and largest E/E0 of a tile, as the page reads it."""
    match = re.fullmatch(r'tile\("(.*)", "(.*)"\)\n', script)
    assert match is not None
    data = zlib.decompress(base64.b64decode(match[2]))
    side = math.isqrt(len(data) // 3)
    word = np.frombuffer(data, np.uint8, side**2).reshape(side, side)
    return match[1], word, 10.0 ** (np.frombuffer(data, "<u2", side**2, side**2).reshape(side, side) / tiles.RATIO)


@pytest.fixture
def served(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    monkeypatch.setattr(tiles, "SIDE", 16)
    own = {SCHEME: ss.scheme(SCHEME), f"{SCHEME}:gamma=.6": ss.scheme(SCHEME, gamma=0.6)}
    with tiles.server(own, "cpu") as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


def get(url: str) -> tuple[int, str]:
    try:
        with urllib.request.urlopen(url, timeout=30) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read().decode()


def test_a_server_sends_page_and_tiles_and_refuses_others(served: str) -> None:
    with pytest.raises(ValueError, match="expected a free port, got 65536"):
        tiles.server({}, "cpu", 65536)
    code, page = get(served)
    assert code == 200
    assert SCHEME in page
    assert get(f"{served}/tile/{SCHEME}/h-EA/3/6/0.js") == get(f"{served}/tile/{SCHEME}/h-EA/3/6/0.js?again")
    name, word, ratio = runs_of(get(f"{served}/tile/{SCHEME}/h-EA/3/6/0.js")[1])
    assert name == f"{SCHEME}/h-EA/3/6/0"
    found = failure_map(
        SCHEME, h=(1e-3, 1.0), EA=(1e4, 1e12), pixels=(128, 128), columns=range(96, 112), rows=range(16)
    )
    assert len(np.unique(word)) > 1
    np.testing.assert_array_equal(word, found.outcome)
    coarse = runs_of(get(f"{served}/tile/{SCHEME}/h-EA/3/6/0.coarse.js")[1])
    assert coarse[0] == f"{name}.coarse"
    np.testing.assert_array_equal(coarse[1], word[::4, ::4])
    np.testing.assert_allclose(ratio, np.minimum(found.max_ratio, 10**6.5535), rtol=2e-4)
    assert runs_of(get(f"{served}/tile/{SCHEME}_gamma%3D.6/h-EA/3/6/0.js")[1])[0] == f"{SCHEME}_gamma=.6/h-EA/3/6/0"
    for path, expected, message in (
        ("/tile/newmork/h-EA/0/0/0.js", 400, "got 'newmork'; did you mean 'newmark_bdf2'?"),
        (f"/tile/{SCHEME}/h-h/0/0/0.js", 400, "expected plane"),
        (f"/tile/{SCHEME}/h-EA/41/0/0.js", 400, "expected a level from 0 to 40"),
        (f"/tile/{SCHEME}/h-EA/1/2/0.js", 400, "expected a place from 0 to 1 on level 1, got 2, 0"),
        (f"/tile/{SCHEME}/h-EA/1/-1/0.js", 404, "expected / or /tile/"),
        ("/../pyproject.toml", 404, "expected / or /tile/"),
    ):
        code, text = get(served + path)
        assert (code, message in text) == (expected, True), text


def test_a_folder_holds_all_levels_and_one_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tiles, "SIDE", 16)
    monkeypatch.setattr(tiles, "LANES", 1)  # so that bands are as narrow as they get
    label = f"{SCHEME}:beta=1/4,gamma=.5"
    line = ["failure-map", label, "--out", str(tmp_path / "new"), "--pixels", "64", "--plane", "h-v0"]
    result = CliRunner().invoke(app, line)
    assert result.exit_code == 0, result.output
    levels: dict[int, Array] = {}
    for z in range(3):
        levels[z] = np.full((16 << z, 16 << z), 9)
        for i, j in np.ndindex(1 << z, 1 << z):
            path = tmp_path / "new" / "tile" / f"{SCHEME}_beta=1_4_gamma=.5" / "h-v0" / str(z) / str(i) / f"{j}.js"
            name, word, _ = runs_of(path.read_text(encoding="utf-8"))
            assert name == f"{SCHEME}_beta=1_4_gamma=.5/h-v0/{z}/{i}/{j}"
            levels[z][16 * j : 16 * j + 16, 16 * i : 16 * i + 16] = word
    own = ss.scheme(SCHEME, beta=0.25, gamma=0.5)
    expected = failure_map(own, h=(1e-3, 1.0), v0=(0.1, 100.0), pixels=(64, 64)).outcome
    assert len(np.unique(expected)) > 1
    for z, found in levels.items():
        np.testing.assert_array_equal(found, expected[:: 4 >> z, :: 4 >> z])
    picture = imread(tmp_path / "new" / f"{SCHEME}_beta=1_4_gamma=.5_h-v0.png")
    _, of_picture = np.unique(picture.reshape(-1, 4), axis=0, return_inverse=True)
    _, of_map = np.unique(expected.values[::-1], return_inverse=True)
    assert len(set(zip(of_picture.ravel(), of_map.ravel(), strict=True))) == len(np.unique(expected))
    assert CliRunner().invoke(app, [*line[:-4], "--pixels", "4000"]).exit_code == 2


def test_the_page_needs_nothing_from_the_network() -> None:
    text = tiles.page(["bathe", "a</script>"], ["h-EA"], 4, served=False)
    assert not re.search(r"https?:|//\w+\.|@import|url\(|integrity=|<link (?!rel=\"icon\" href=\"data:,\")", text)
    assert text.count("</script>") == 1
    about = re.search(r"^const A = (.*);$", text, re.MULTILINE)
    assert about is not None
    assert list(json.loads(about[1])["schemes"]) == ["bathe", "a</script>"]
