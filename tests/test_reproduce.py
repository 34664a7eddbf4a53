"""`substep reproduce`: the light form and the full one, what they compile, print and leave on the page."""

import os
import time
from fractions import Fraction
from functools import partial
from multiprocessing import active_children
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from substep_thesis import claims, figures_5, found
from substep_thesis import reproduce as reproduction
from substep_thesis.catalogue_charts import CHARTS, stability_region, trade_off
from substep_thesis.claims import chapter_2, chapter_4
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app
from substep.core import stability
from substep.figures.charts import save
from substep.studies import failures
from substep.studies.precision import jobs as precision

runner = CliRunner()
SCREEN = 24  # lines


def light(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two figures and a claim in this process: what is tested is the frame around them."""
    two = tuple(partial(reproduction.figure_4, k, Fraction(1, 5)) for k in (1, 2))
    monkeypatch.setattr(reproduction, "jobs", lambda full: two)
    monkeypatch.setattr(reproduction, "parameter_sets", lambda: iter([("bathe", {})]))
    monkeypatch.setattr(reproduction, "cores", lambda: 1)
    monkeypatch.setattr(claims, "CLAIMS", claims.CLAIMS[:1])
    monkeypatch.setattr(found, "SENTENCES", (partial(found.Found, "figure_4_1", ("C2.1",), "Two figures are drawn."),))


def test_the_light_form_holds_the_thesis_and_the_full_one_the_rest() -> None:
    short, long = reproduction.jobs(False), reproduction.jobs(True)
    chapter_4 = [job.args[0] for job in short if isinstance(job, partial)]
    others = [job for job in short if not isinstance(job, partial)]
    assert chapter_4 == [1, 2, 3, 4, 5]
    assert set(figures_5.JOBS) < set(others)
    studies = [stability_region, trade_off, reproduction.certificates, reproduction.failure_map]
    assert [job for job in others if job not in figures_5.JOBS] == studies
    battery = {reproduction.failure_map}  # which draws this map too, perhaps at the same time
    assert set(long) >= {*others, *CHARTS, precision.operations, *figures_5.LONG_JOBS} - battery
    assert not battery & set(long)
    of_stages = [{stage.name for stage in reproduction.stages(full)} for full in (False, True)]
    assert of_stages[1] - of_stages[0] == {"where methods fail", "timing", "drawing times"}


def test_the_light_form_fits_its_budget_by_its_own_estimate() -> None:
    """4 CPU-minutes; what it takes is measured by `python -m benchmarks`."""
    assert sum(stage.jobs * stage.seconds for stage in reproduction.stages()) <= 240


def test_the_light_form_compiles_ahead_what_it_needs_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever judges and charts evaluate, apart from the two schemes that the first figures compile."""
    evaluated, used = stability._evaluated, set[str]()

    def noted(scheme: ss.Scheme, *arguments: object) -> object:
        used.add(scheme.info.module)
        return evaluated(scheme, *arguments)  # pyright: ignore

    monkeypatch.setattr(stability, "_evaluated", noted)
    for claim in (*chapter_2.CLAIMS, *chapter_4.CLAIMS):
        claims.judged(claim)
    stability_region(tmp_path)
    trade_off(tmp_path)
    found.low_modes()
    found.equal_cost()
    first = {ss.scheme(name).info.module for name in ("newmark_bdf2", "bathe")}
    ahead = {ss.scheme(name).info.module for names in reproduction.compiled_ahead(False) for name in names}
    assert used - first == ahead - first


def test_kernels_compiled_ahead_are_those_that_jobs_march(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compilation ahead of all jobs, which happens only on several cores."""
    marched: list[str] = []
    monkeypatch.setattr(reproduction, "march", lambda scene, *_: marched.append(scene.name))
    reproduction._compile(True, ["newmark_bdf2"])
    assert set(marched) == {case.make().name for case in (*reproduction.CASES, *failures.CASES)}
    marched.clear()
    reproduction._compile(True, ["bathe"])  # not in the quick battery
    assert set(marched) == {case.make().name for case in reproduction.CASES}
    marched.clear()
    reproduction._compile(False, ["bathe"])
    assert not marched


def test_no_module_is_compiled_by_two_processes() -> None:
    groups = reproduction.sharing(ss.schemes())
    modules = [{ss.scheme(name).kernels.__name__ for name in names} for names in groups]
    assert all(len(found) == 1 for found in modules)
    assert len(set.union(*modules)) == len(groups)
    assert sorted(name for names in groups for name in names) == sorted(ss.schemes())


def test_modules_that_find_eigenvalues_are_compiled_first_by_one_process_each() -> None:
    """Those for many eigenvalues, which take longest, begin."""
    shared = [ss.scheme(names[0]).kernels.EIGENVALUES for names in reproduction.sharing(ss.schemes())]
    first = shared[: len(set(shared))]
    assert len(set(first)) == len(first)
    assert [name.endswith("_twice") for name in first] == sorted(
        (name.endswith("_twice") for name in first), reverse=True
    )


@pytest.mark.long
def test_reproduce_draws_every_panel_and_writes_its_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Chapter 5, the map of failures, the ledger and the sentences have tests of their own.

    The gate makes a piece of them; `make verify` makes all.
    """
    numbers = range(1, 6)
    if not os.environ.get("SUBSTEP_VERIFY"):
        jobs, numbers = reproduction.jobs, (1, 5)
        few = lambda full: tuple(job for job in jobs(full) if not isinstance(job, partial) or job.args[0] in numbers)  # noqa: E731
        monkeypatch.setattr(reproduction, "jobs", few)
        monkeypatch.setattr(figures_5, "JOBS", figures_5.JOBS[:1])
        monkeypatch.setattr(claims, "CLAIMS", claims.CLAIMS[:1])
        monkeypatch.setattr(found, "SENTENCES", (found.stability,))
        monkeypatch.setattr(reproduction, "failure_map", lambda folder: None)
        monkeypatch.setattr(reproduction, "cores", lambda: 1)  # nothing is compiled ahead
    monkeypatch.setenv("COLUMNS", "80")
    result = runner.invoke(app, ["reproduce", "--folder", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert all(f"{stage}: done after" in result.output for stage in ("drawing", "judging"))  # as many as announced
    assert len(result.output.splitlines()) <= SCREEN + 6  # what is printed while it works
    for number in numbers:
        for suffix in ("png", "svg"):
            assert (tmp_path / f"figure_4_{number}.{suffix}").stat().st_size > 10_000
        for panel in ("a_spectral_radius", "b_amplitude_error", "c_period_error"):
            header, *rows = (tmp_path / f"figure_4_{number}{panel}.csv").read_text().splitlines()
            assert header.startswith("h/T,beta=0.25 gamma=0.5,")
            assert header.endswith(",bathe")
            assert len(rows) in (501, 201)
            assert all(len(row.split(",")) == 7 for row in rows)
    for chart in ("trade_off_equal_cost", "stability_region", "figure_5_2"):
        assert (tmp_path / f"{chart}.png").stat().st_size > 10_000
    catalogue = (tmp_path / "catalogue.csv").read_text().splitlines()
    assert len(catalogue) == 1 + len(ss.schemes())
    assert 'fox_goodwin,"2, 2, 2",9.89898,sqrt(6),sqrt(6),no,no,U0-V1,2.44949,"2, 2, 2",4,yes,no,yes' in catalogue
    page = (tmp_path / "index.html").read_text()
    assert all(f'src="{name}.png"' in page for name in ("figure_4_1", "stability_region", "figure_5_2"))
    assert "stable at every step, by exact proof" in page[: page.index('id="section-1"')]
    assert "refresh" not in page
    assert "## C2.1: true" in (tmp_path / "claims.md").read_text()
    proofs = (tmp_path / "chapter_4_certificates.csv").read_text().splitlines()
    assert len(proofs) == 27
    assert all(row.split(",")[4] == "stable for every Omega > 0" for row in proofs[1:])
    options = "--gamma-t 4/5 --beta 49/100 --gamma 9/10"
    assert (
        proofs[-1] == f"newmark_bdf2,4/5,49/100,9/10,stable for every Omega > 0,substep certify newmark_bdf2 {options}"
    )
    table = (tmp_path / "chapter_4_properties.csv").read_text().splitlines()
    assert len(table) == 27
    assert table[1] == "bathe,,,,0,2,3,1/288,2,1/24"
    assert table[-1] == "newmark_bdf2,4/5,49/100,9/10,20/49,1,1,2/15,2,293/4500"


def test_the_page_grows_from_the_first_figure_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    light(monkeypatch)
    monkeypatch.setattr(reproduction, "GROWS", 0.0)
    seen: list[str] = []

    def step(stage: str) -> None:
        page = tmp_path / "index.html"
        seen.append(page.read_text() if page.exists() else "")

    results = reproduction.reproduce(tmp_path, step)
    assert "1 of 2 figures and tables are drawn" in seen[1]
    assert 'src="figure_4_1.png"' in seen[1]
    assert 'http-equiv="refresh"' in seen[1]
    page = (tmp_path / "index.html").read_text()
    assert "refresh" not in page
    assert "Two figures are drawn." in page
    assert [j.id for j in results.claims] == ["C2.1"]


@pytest.mark.parametrize("full", [False, True])
def test_an_interrupted_run_keeps_figures_tables_ledger_and_page(
    full: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the full form while times are measured, when all else is there; in the light one at the second figure."""

    def stop(folder: Path) -> None:
        raise KeyboardInterrupt

    light(monkeypatch)
    monkeypatch.setattr(failures, "joined", lambda folder, parts: [])
    monkeypatch.setattr(failures, "count", lambda: 0)
    monkeypatch.setattr(precision, "jobs", lambda full: (stop,))
    if not full:
        monkeypatch.setattr(
            reproduction, "jobs", lambda full: (partial(reproduction.figure_4, 1, Fraction(1, 5)), stop)
        )
    arguments = ["reproduce", "--folder", str(tmp_path), *(["--full"] if full else [])]
    assert runner.invoke(app, arguments).exit_code == 130
    page = (tmp_path / "index.html").read_text()
    assert "figure_4_1.png" in page
    assert all((name in page) == full for name in ("catalogue.csv", claims.CLAIMS[0].id, "Two figures are drawn."))
    assert "refresh" not in page  # nothing more will come


VERDICTS = ("true", "partly", "false")


@pytest.fixture
def as_many_as_there_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> reproduction.Results:
    """Results of the size of the real ones, in place of the work."""
    judged = [
        claims.Judgement(c.id, c.text, VERDICTS[k % 3], "evidence", c.command) for k, c in enumerate(claims.CLAIMS)
    ]
    said = [found.Found(f"figure_4_{k}", (), " ".join(["word"] * 38)) for k in range(1, 6)]  # 189 letters
    results = reproduction.Results(judged, said, [])
    (tmp_path / "results").mkdir()
    for k in range(2):
        save(
            Figure(figsize=(1, 1)),
            tmp_path / "results" / f"figure_4_{k}",
            ("Chapter 4", "Where methods fail")[k],
            "A caption.",
        )
    monkeypatch.setattr(reproduction, "reproduce", lambda folder, step, full: results)
    monkeypatch.setenv("COLUMNS", "80")
    return results


@pytest.mark.usefixtures("as_many_as_there_are")
def test_it_ends_in_one_screenful(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was drawn, what was judged, what differs, where the page is; before, it printed 1600 lines."""
    monkeypatch.chdir(tmp_path)
    result = runner.invoke(app, ["reproduce"])
    assert result.exit_code == 0, result.output
    lines = result.output.splitlines()
    assert len(lines) <= SCREEN + 3
    assert max(map(len, lines)) <= 80
    said = " ".join(result.output.split())
    assert "drawn 2 figures: Chapter 4 1, Where methods fail 1" in said
    assert f"judged {len(claims.CLAIMS)} claims of the thesis: 13 true, 13 partly, 13 false" in said
    for k, verdict in enumerate(VERDICTS[1:], start=1):
        assert f"{verdict} {' '.join(claim.id for claim in claims.CLAIMS[k::3])}" in said
    assert said.count("word " * 37 + "word") == 5
    assert f"page {Path('results') / 'index.html'}" in said
    assert "CRootOf" not in said


@pytest.mark.usefixtures("as_many_as_there_are")
@pytest.mark.parametrize("full", [False, True])
def test_it_says_before_how_long_it_takes(full: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduction, "stages", lambda full: (
        reproduction.Stage("drawing", 10, 30.0 if full else 12.0), reproduction.Stage("timing", 3, 60.0, alone=True),
    ))  # fmt: skip
    monkeypatch.setattr("substep.core.threads.cores", lambda: 2)
    first = runner.invoke(app, ["reproduce", "--folder", str(tmp_path), *(["--full"] if full else [])]).output
    wanted = "about 6 min, 8 min of CPU" if full else "about 4 min, 5 min of CPU"  # 3 + 5/2, 3 + 5; 3 + 1, 3 + 2
    assert first.startswith(wanted)


def test_processes_of_reproduce_end_at_once_when_it_is_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduction, "cores", lambda: 2)
    others, begun = active_children(), time.perf_counter()

    def interrupted() -> None:
        with reproduction._workers() as each:
            next(each(time.sleep, [0.0, 60.0, 60.0, 60.0]))
            assert len(active_children()) == len(others) + 2
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert active_children() == others
    assert time.perf_counter() - begun < 30.0  # the processes' start, on a busy machine
