"""What several test files use: fixtures, and the settings with which hypothesis draws examples."""

import gc
import os
import random
import sys
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence, Set
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from compiled_apart import compile_apart
from hypothesis import HealthCheck, settings

# every run of the gate draws the same examples; `make verify` searches for new ones. The first draw of a process looks
# for constants in all modules of the project, and so takes long on a busy machine
COMMON = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow]}
settings.register_profile("gate", derandomize=True, **COMMON)
settings.register_profile("search", print_blob=True, **COMMON)
settings.load_profile("search" if os.environ.get("SUBSTEP_VERIFY") else "gate")

# of fifteen stages, or of three parameters: what takes tenths of a second for others of their kind takes seconds
DEAR = ("yoshida6", "gssss_u0", "gssss_v0")
# of a test that has more cases, `make verify` draws so many; all of them take a day
DRAWN = 24


def whole(config: pytest.Config) -> bool:
    """Whether this is a run of all tests, and neither of some files nor of some names."""
    if hasattr(config, "workerinput"):
        return config.workerinput["whole"]
    return config.args_source is pytest.Config.ArgsSource.TESTPATHS and not config.option.keyword


def whole_gate(config: pytest.Config) -> bool:
    """Whether this is a run of all tests, and not that of `make verify`."""
    return whole(config) and not os.environ.get("SUBSTEP_VERIFY")


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tell each of pytest's workers what the whole run is."""
    node.workerinput["whole"] = whole(node.config)


def pytest_report_header(config: pytest.Config) -> str:
    """Say which cases `make verify` has drawn, and how the same ones are drawn again."""
    if not whole(config) or whole_gate(config):
        return ""
    return f"SUBSTEP_DRAW={os.environ['SUBSTEP_DRAW']}: at most {DRAWN} cases of each test; SUBSTEP_DRAW=all runs all"


def pytest_configure() -> None:
    """Keep what compilation allocates out of this process, and what is printed on first use out of the user's cache.

    Modules are named by what they are printed from, so all workers, and the next run, share them. So they do bytecode,
    even where Python is told not to keep any: else each of some hundred processes would compile the same files again.
    """
    gc.disable()  # nothing that is imported and collected is garbage: see `pytest_collection_finish`
    compile_apart()
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ.setdefault("SUBSTEP_CACHE", str(Path(__file__).parents[1] / ".pytest_cache" / "modules"))
    os.environ.setdefault("SUBSTEP_DRAW", str(random.SystemRandom().randrange(10**6)))  # the workers inherit it


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile what all schemes share before the workers of a whole run begin, once for all of them."""
    config = session.config
    if whole(config) and not (hasattr(config, "workerinput") or config.option.collectonly):
        from compiled_ahead import compile_shared

        config.get_terminal_writer().line("kernels that all schemes share are compiled, or read from numba's cache")
        compile_shared()


def pytest_collection(session: pytest.Session) -> None:
    """In a whole run, read the test files in the second worker from the last to the first.

    pytest rewrites the assertions of each file, which takes longer than all else before the tests, and keeps the
    result: so each of two workers rewrites one half, and finds the other there. What cannot be imported is reported
    when it is collected.
    """
    if whole_gate(session.config) and os.environ.get("PYTEST_XDIST_WORKER") == "gw1":
        for path in sorted(Path(__file__).parent.glob("test_*.py"), reverse=True):
            with suppress(Exception, pytest.skip.Exception):
                import_module(path.stem)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Run long tests first: one begun last would keep a worker busy while the others are idle.

    pytest-xdist gives each worker a piece of the list, and each piece begins with its share of the long tests: else one
    worker would run these, and another nearly all the others, with the memory that they take.

    The gate runs a test over the catalogue's schemes for one scheme of every third kind, another test for others, so
    that every scheme meets many tests; a test marked `every_scheme` it runs for all. Where such a test has other
    parameters too, it runs each scheme with some of their values and all of these with some scheme, not each with
    each. A test marked `pairs` it runs for every scheme, on one scene: see `plain_kernels.gate_pairs`. Of one marked
    `matrix`, whose many cases take long, it runs every twelfth case, or as its argument says; one marked `thorough` it
    leaves to `make verify`. Of any other test of schemes it runs at least one case.

    `make verify` draws up to `DRAWN` cases of each test, others every time; a file run alone runs them all.
    """
    if whole_gate(config):
        from plain_kernels import gate_pairs, kinds

        cases: Counter[str] = Counter()
        left = set[str]()

        def runs(item: pytest.Item) -> bool:
            function, case = item.nodeid.partition("[")[0], cases[item.nodeid.partition("[")[0]]
            cases[function] += 1
            if item.get_closest_marker("thorough"):
                left.add(item.nodeid)
                return False
            if matrix := item.get_closest_marker("matrix"):
                return case % (matrix.args or (12,))[0] == 0
            if item.get_closest_marker("pairs") and isinstance(item, pytest.Function):
                return (item.callspec.params["scheme"], item.callspec.params["scene"]) in gate_pairs()
            return bool(item.get_closest_marker("every_scheme")) or in_gate(function, _schemes(item), kinds())

        chosen = [runs(item) for item in items]
        chosen = without_products([_scheme_and_others(item, kinds()) for item in items], chosen)
        _choose(config, items, with_one_of_each([item.nodeid for item in items], chosen, left))
    elif whole(config) and os.environ["SUBSTEP_DRAW"] != "all":
        drawn = draw([item.nodeid for item in items], os.environ["SUBSTEP_DRAW"])
        _choose(config, items, [item.nodeid in drawn for item in items])
    workers = getattr(config, "workerinput", {"workercount": 1})["workercount"]
    long = [item for item in items if item.get_closest_marker("long")]
    others = [item for item in items if not item.get_closest_marker("long")]
    share = -(-len(others) // workers)
    items[:] = [x for k in range(workers) for x in (*long[k::workers], *others[k * share : (k + 1) * share])]


def pytest_collection_finish() -> None:
    """Leave what has been imported and collected out of Python's collections of garbage, and begin these less often.

    Expressions of SymPy and types of numba are made by the million, and few of them are garbage. In a process that
    compiles, a collection of everything would besides copy all the memory that it shares with its parent.
    """
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)
    gc.enable()


def _choose(config: pytest.Config, items: list[pytest.Item], chosen: Sequence[bool]) -> None:
    config.hook.pytest_deselected(items=[item for item, run in zip(items, chosen, strict=True) if not run])
    items[:] = [item for item, run in zip(items, chosen, strict=True) if run]


def with_one_of_each(cases: Sequence[str], chosen: Sequence[bool], left: Set[str]) -> list[bool]:
    """The choice, with one more case of each test of which none is chosen, but of those in `left`."""
    met = {case.partition("[")[0] for case, run in zip(cases, chosen, strict=True) if run}
    first = dict[str, str]()
    for case in cases:
        if case not in left and (test := case.partition("[")[0]) not in met:
            first.setdefault(test, case)
    more = set(first.values())
    return [run or case in more for case, run in zip(cases, chosen, strict=True)]


def without_products(cases: Sequence[tuple[str, str, str] | None], chosen: Sequence[bool]) -> list[bool]:
    """The choice, of which each test has each scheme, and all else that it is run for, but not each with each.

    cases: test, scheme, and what else the case is of; None for those that are left as they are.
    """
    found, left = list(chosen), defaultdict[str, list[int]](list)
    for k, (case, run) in enumerate(zip(cases, chosen, strict=True)):
        if case and run:
            left[case[0]].append(k)
            found[k] = False
    for of_test in left.values():
        labels = {k: set(enumerate((cases[k] or ())[1:])) for k in of_test}
        missing = set[tuple[int, str]]().union(*labels.values())
        while missing:
            best = max(of_test, key=lambda k: len(labels[k] & missing))
            found[best], missing = True, missing - labels[best]
    return found


def draw(cases: Sequence[str], seed: str) -> set[str]:
    """Up to `DRAWN` cases of each test, the same ones for the same seed and test."""
    of_test = defaultdict[str, list[str]](list)
    for case in cases:
        of_test[case.partition("[")[0]].append(case)
    return {
        case
        for test, all_of_it in of_test.items()
        for case in random.Random(f"{seed} {test}").sample(all_of_it, min(DRAWN, len(all_of_it)))
    }


def _schemes(item: pytest.Item) -> list[str]:
    """What the test's parameters may name as schemes."""
    values = item.callspec.params.values() if isinstance(item, pytest.Function) and hasattr(item, "callspec") else ()
    return [name for name in (getattr(value, "name", value) for value in values) if isinstance(name, str)]


def _scheme_and_others(item: pytest.Item, kinds: Mapping[str, object]) -> tuple[str, str, str] | None:
    """Test, scheme and what else a case is of, by its name; None where no scheme is named, or the choice is marked."""
    if any(map(item.get_closest_marker, ("matrix", "pairs"))) or not isinstance(item, pytest.Function):
        return None
    scheme = next((name for name in _schemes(item) if name in kinds), None)
    return (item.nodeid.partition("[")[0], scheme, item.callspec.id.replace(scheme, "", 1)) if scheme else None


def in_gate(function: str, named: Sequence[str], kinds: Mapping[str, object]) -> bool:
    """Whether the gate runs the test for what its parameters name: one scheme of every third kind, or anything else.

    kinds: of each scheme; which kinds, and which scheme stands for its kind, follow from the test's name. Those that
    are `DEAR` do so in few tests, besides those that run for every scheme.
    """
    schemes = [name for name in named if name in kinds]
    if not schemes:
        return True
    alike = [name for name in kinds if kinds[name] == kinds[schemes[0]]]
    number, every = zlib.crc32(function.encode()), list(dict.fromkeys(kinds.values()))
    if (number // 2**16 + every.index(kinds[schemes[0]])) % 3:
        return False
    chosen = alike[number % len(alike)]
    if chosen in DEAR and number // len(alike) % 8:
        others = [name for name in alike if name not in DEAR]
        chosen = others[number % len(others)]
    return schemes[0] == chosen


@pytest.fixture
def uncompiled(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """`march` and `march_lanes` take kernels as plain Python; an overflow there is a status, not a warning."""
    from plain_kernels import plain, plain_adaptive

    from substep.core import threads
    from substep.marching import adaptive, scene_lanes

    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: plain(scheme.info.source, scene.info.source))
    monkeypatch.setattr(adaptive, "_kernels", plain_adaptive)
    monkeypatch.setattr(threads, "cores", lambda: 1)  # threads do not inherit np.errstate
    with np.errstate(all="ignore"):
        yield


@pytest.fixture
def few_members(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the gate audits do not look for every other scheme that does the same, nine tenths of their time.

    But in tests marked `members`, in `make verify` and in a file run alone.
    """
    from substep_audit import instrument

    if whole_gate(request.config) and not request.node.get_closest_marker("members"):
        monkeypatch.setattr(instrument, "with_all_members", lambda found, *_: found)


@pytest.fixture
def plain_functions(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Functions of shared modules and of committed ones, such as a scheme's amplification matrix, as plain Python."""
    from plain_kernels import committed, itself, text_of, uncompiled

    from substep.core import eigenvalues, kernel_modules
    from substep.derived import modules

    printed = modules.eigenvalues_module
    monkeypatch.setattr(modules, "eigenvalues_module", lambda name: uncompiled(text_of(printed(name))))

    monkeypatch.setattr(kernel_modules, "committed", committed)
    monkeypatch.setattr(eigenvalues, "committed", committed)
    monkeypatch.setattr(eigenvalues, "address", itself)
    monkeypatch.setattr(eigenvalues, "addresses", tuple)
    eigenvalues._called.cache_clear()
    yield
    eigenvalues._called.cache_clear()


@pytest.fixture
def plain_marches(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The marches of oscillators, committed and printed, as plain Python; an overflow there is no warning."""
    from plain_kernels import committed, text_of, uncompiled

    from substep.core import threads
    from substep.derived import modules
    from substep.marching import linear

    printed = modules.march_module
    monkeypatch.setattr(linear, "committed", committed)
    monkeypatch.setattr(modules, "march_module", lambda *shape: uncompiled(text_of(printed(*shape))))
    monkeypatch.setattr(linear, "_kernels", linear._kernels.__wrapped__)
    monkeypatch.setattr(threads, "cores", lambda: 1)  # threads do not inherit np.errstate
    with np.errstate(all="ignore"):
        yield


@pytest.fixture
def plain_in_gate(request: pytest.FixtureRequest) -> None:
    """Pairs and marches of oscillators as plain Python in the gate, where others of their kind are compiled.

    For tests of few steps, of which compiling took most of the time. `make verify` compiles them all.
    """
    if not os.environ.get("SUBSTEP_VERIFY"):
        request.getfixturevalue("uncompiled")
        request.getfixturevalue("plain_marches")


@pytest.fixture
def plain_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pairs of a declared scheme and any scene as plain Python functions."""
    from plain_kernels import text_of
    from plain_kernels import uncompiled as plain

    from substep.core import threads
    from substep.marching import scene_lanes

    pairs = scene_lanes.pair_kernels
    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: plain(text_of(pairs(scene, scheme))))
    monkeypatch.setattr(threads, "cores", lambda: 1)


@pytest.fixture
def plain_adaptive(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Kernels that choose their steps as plain Python; an overflow there is a rejection, not a warning."""
    from plain_kernels import plain_adaptive as kernels

    from substep.core import threads
    from substep.marching import adaptive

    monkeypatch.setattr(adaptive, "_kernels", kernels)
    monkeypatch.setattr(threads, "cores", lambda: 1)  # threads do not inherit np.errstate
    with np.errstate(all="ignore"):
        yield


@pytest.fixture
def plainly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pairs of catalogue schemes and any scene as plain Python functions, made once for each pair."""
    from law_scenes import kernels

    from substep.core import threads
    from substep.marching import scene_lanes

    monkeypatch.setattr(scene_lanes, "pair_kernels", lambda scene, scheme: kernels(scheme.name, scene.info.source))
    monkeypatch.setattr(threads, "cores", lambda: 1)


@pytest.fixture(scope="module")
def child() -> Iterator[Executor]:
    """A process in which OpenSees keeps its one model; a test without OpenSees is skipped."""
    if not find_spec("openseespy"):
        pytest.skip("openseespy, of the extra bench, is not installed")
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        yield pool
