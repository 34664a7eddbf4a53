"""No files import each other in a circle; what a function imports counts, and what only types need."""

from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[1]


EXTRAS = sorted(path.name for path in (ROOT / "extras").glob("substep_*"))


@pytest.mark.parametrize("packages", [["substep", "substep_derive", *EXTRAS], ["benchmarks"]], ids=len)
def test_files_import_each_other_in_no_circle(packages: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT)
    graph = grimp.build_graph(*packages, cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    TopologicalSorter(imports).prepare()  # raises CycleError, which names the circle
