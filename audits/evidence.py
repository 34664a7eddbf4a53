"""The reports of audits, one compressed file a program: see them with `python -m audits.evidence PROGRAM`."""

import gzip
import json
import sys
from pathlib import Path
from typing import Any

REPORTS = Path(__file__).parent / "reports"


def read(program: str) -> dict[str, Any]:
    """What was found of a program; raises FileNotFoundError for one that was not audited."""
    return json.loads(gzip.decompress((REPORTS / f"{program}.json.gz").read_bytes()))


def write(program: str, found: dict[str, Any]) -> None:
    """Keep what was found of a program; the same bytes for the same findings."""
    REPORTS.mkdir(exist_ok=True)
    text = json.dumps(found, indent=1, allow_nan=False) + "\n"
    (REPORTS / f"{program}.json.gz").write_bytes(gzip.compress(text.encode(), mtime=0))


def audited() -> list[str]:
    """The programs whose reports are kept, by name."""
    return sorted(path.name.removesuffix(".json.gz") for path in REPORTS.glob("*.json.gz"))


if __name__ == "__main__":
    print(json.dumps(read(sys.argv[1]), indent=1))
