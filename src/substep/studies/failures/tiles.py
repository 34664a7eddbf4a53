"""Maps of failures in tiles: a page that asks a server for them at any depth, or a folder that holds a pyramid.

A tile is a call of `tile` in JavaScript with its runs in it, so that a page reads it from a server and from a folder
alike. Tile i, j of level z is the i-th from the left and the j-th from below of 2^z by 2^z; its pixels are every second
one, along both sides, of four tiles of the next level, never a mixture of outcomes.
"""

import base64
import json
import re
import zlib
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from threading import Lock
from typing import Any
from urllib.parse import unquote

import numpy as np
from matplotlib.colors import to_hex, to_rgba_array
from matplotlib.image import imsave
from numpy.typing import NDArray

from ...core.device import Device
from ...core.errors import unknown_name
from ...core.schemes import Array, Scheme
from .maps import MOST_STEPS, SPAN
from .outcomes import COLOUR_OF_WORD, WORDS
from .plane import LANES, PLANES, QUANTITIES, failure_map

SIDE = 256  # runs along each side of a tile
DEEPEST = 40  # level at which the steps h of neighbours are a hundred roundings of doubles apart
KEPT = 1024  # tiles that a server keeps, of some 20 kB each and 300 kB at most
RATIO = 1e4  # a decade of E/E0 in a tile, as integers of 16 bits: 65535 stands for 3.6e6 and more
COARSE = 4  # of how many runs along each side a tile has one that is asked for while nothing is known of its place
TILE = re.compile(r"/tile/([^/]+)/([^/]+)/(\d{1,2})/(\d{1,15})/(\d{1,15})(\.coarse)?\.js")


def tile(
    scheme: Scheme, plane: str, level: int, column: int, row: int, *, every: int = 1, device: Device = "cpu"
) -> tuple[Array, Array]:
    """Outcome and largest E/E0 (256, 256) of the runs of a tile of a plane of `PLANES`, rows from below.

    every: of how many along each side one is run, so that there are fewer.
    Raises ValueError for a plane, a level or a place that is none.
    """
    if plane not in PLANES:
        raise unknown_name("plane", plane, PLANES)
    if not 0 <= level <= DEEPEST:
        raise ValueError(f"expected a level from 0 to {DEEPEST}, where neighbouring doubles run out, got {level}")
    if not (0 <= column < 1 << level and 0 <= row < 1 << level):
        raise ValueError(f"expected a place from 0 to {(1 << level) - 1} on level {level}, got {column}, {row}")
    columns, rows = (range(SIDE * i, SIDE * (i + 1), every) for i in (column, row))
    return _part(scheme, plane, SIDE << level, device, columns=columns, rows=rows)


def _part(scheme: Scheme, plane: str, side: int, device: Device, **part: range) -> tuple[Array, Array]:
    """Outcome and largest E/E0 of part of a square map."""
    given = {name: q.limits if name in PLANES[plane] else q.usual for name, q in QUANTITIES.items()}
    found = failure_map(scheme, **given, pixels=(side, side), device=device, **part)
    return found.outcome.values, found.max_ratio.values


def _coded(ratio: Array) -> NDArray[np.uint16]:
    """The largest E/E0 as tiles have it."""
    return np.clip(np.rint(RATIO * np.log10(np.nan_to_num(ratio, nan=np.inf))), 0, 65535).astype("<u2")


def _script(name: str, word: Array, code: Array) -> bytes:
    """A tile as JavaScript."""
    packed = zlib.compress(word.astype(np.uint8).tobytes() + code.tobytes())
    return f'tile("{name}", "{base64.b64encode(packed).decode()}")\n'.encode()


def keys(labels: Iterable[str]) -> dict[str, str]:
    """By label of a scheme, such as newmark:beta=1/4, the name that stands for it in addresses and folders."""
    return {label: re.sub(r"[^\w.=-]", "_", label) for label in labels}


def page(labels: Iterable[str], planes: Iterable[str], deepest: int, served: bool) -> str:
    """The text of the page, which shows these schemes and planes down to the level `deepest`."""
    about = {
        "schemes": keys(labels), "planes": {name: PLANES[name] for name in planes}, "deepest": deepest, "side": SIDE,
        "served": served, "words": WORDS, "colours": [to_hex(colour) for colour in COLOUR_OF_WORD], "decade": RATIO,
        "quantities": {name: x._asdict() for name, x in QUANTITIES.items()}, "t_end": SPAN, "most_steps": MOST_STEPS,
    }  # fmt: skip
    text = files(__package__).joinpath("tiles.html").read_text(encoding="utf-8")
    return text.replace("{{ about }}", json.dumps(about, ensure_ascii=False).replace("<", "\\u003c"))


def write(
    folder: Path,
    schemes: Mapping[str, Scheme],
    plane: str,
    pixels: int,
    device: Device,
    advance: Callable[[int], object] = lambda runs: None,
) -> None:
    """The page, and of each scheme a map of pixels x pixels runs as tiles of all levels and as one PNG.

    schemes: by label. advance: called with the number of runs made since. Raises ValueError for pixels other than 256
    times a power of two.
    """
    level = (pixels // SIDE).bit_length() - 1
    if level < 0 or pixels != SIDE << level:
        raise ValueError(f"expected pixels as {SIDE} times a power of two, such as 4096, got {pixels}")
    band = max(SIDE, LANES // pixels)
    folder.mkdir(parents=True, exist_ok=True)  # an error before millions of runs
    for label, key in keys(schemes).items():
        word, code = np.empty((pixels, pixels), np.uint8), np.empty((pixels, pixels), "<u2")
        for first in range(0, pixels, band):
            some = range(first, min(first + band, pixels))
            word[first : some.stop], ratio = _part(schemes[label], plane, pixels, device, rows=some)
            code[first : some.stop] = _coded(ratio)
            advance(len(some) * pixels)
        for z in range(level + 1):
            picked = (slice(None, None, 1 << (level - z)),) * 2
            for i, j in np.ndindex(1 << z, 1 << z):
                own = slice(SIDE * j, SIDE * (j + 1)), slice(SIDE * i, SIDE * (i + 1))
                name = f"{key}/{plane}/{z}/{i}/{j}"
                path = folder / "tile" / f"{name}.js"
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(_script(name, word[picked][own], code[picked][own]))
        colours = (255 * to_rgba_array(COLOUR_OF_WORD)).astype(np.uint8)
        imsave(folder / f"{key}_{plane}.png", colours[word[::-1]])
    (folder / "index.html").write_text(page(schemes, [plane], level, served=False), encoding="utf-8", newline="\n")


def server(schemes: Mapping[str, Scheme], device: Device, port: int = 0) -> ThreadingHTTPServer:
    """A server of the page and its tiles on this machine alone, not yet serving; port 0 stands for a free one.

    schemes: by label, that shown first in front. It answers / and /tile/SCHEME/PLANE/LEVEL/COLUMN/ROW.js, or
    ROW.coarse.js for every fourth run along both sides, and 400 or 404 with what was expected. Tiles are run one at a
    time, since one takes all cores, and the latest are kept. Raises ValueError for a port that is not free.
    """
    by_key = {key: schemes[label] for label, key in keys(schemes).items()}
    text, busy = page(schemes, PLANES, DEEPEST, served=True).encode(), Lock()

    @lru_cache(KEPT)
    def script(key: str, plane: str, *place: int, coarse: str) -> bytes:
        with busy:
            word, ratio = tile(by_key[key], plane, *place, every=COARSE if coarse else 1, device=device)
        return _script("/".join(map(str, (key, plane, *place))) + coarse, word, _coded(ratio))

    def answer(path: str) -> tuple[int, str, bytes]:
        if path == "/":
            return 200, "text/html", text
        asked = TILE.fullmatch(path)
        if asked is None:
            return 404, "text/plain", b"expected / or /tile/SCHEME/PLANE/LEVEL/COLUMN/ROW.js"
        key, plane, *place, coarse = asked.groups(default="")
        try:
            if key not in by_key:
                raise unknown_name("scheme", key, by_key)
            return 200, "text/javascript", script(key, plane, *map(int, place), coarse=coarse)
        except ValueError as error:
            return 400, "text/plain", str(error).encode()

    class Handler(BaseHTTPRequestHandler):
        """Answers a browser."""

        def do_GET(self) -> None:
            """Send what is asked for, unless the browser has left meanwhile."""
            code, kind, body = answer(unquote(self.path.partition("?")[0]))
            try:
                self.send_response(code)
                self.send_header("Content-Type", f"{kind}; charset=utf-8")
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)
            except ConnectionError:
                self.close_connection = True

        def log_message(self, format: str, *args: Any) -> None:
            """Say nothing of requests."""

    try:
        return ThreadingHTTPServer(("127.0.0.1", port), Handler)
    except (OSError, OverflowError) as error:
        raise ValueError(f"expected a free port, got {port}: {error}; take 0, which finds one") from error
