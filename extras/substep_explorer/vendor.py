"""`make vendor`: fetch Chart.js, which draws the page's charts, from npm; check it, and keep it with its licence."""

import hashlib
import subprocess
import tarfile
import tempfile
from pathlib import Path

PACKAGE = "chart.js@4.6.1"
FOLDER = Path(__file__).parent / "vendored"
FILES = {"package/dist/chart.umd.min.js": "chart.umd.min.js", "package/LICENSE.md": "chart.LICENSE.md"}


def main() -> None:
    """Write the files and the sha256 of the library. npm compares the package with the digest of its registry."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["npm", "pack", PACKAGE, "--silent", "--pack-destination", folder]
        name = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()[-1]
        with tarfile.open(Path(folder) / name) as package:
            for member, own in FILES.items():
                file = package.extractfile(member)
                assert file is not None
                (FOLDER / own).write_bytes(file.read())
    library = FOLDER / "chart.umd.min.js"
    digest = hashlib.sha256(library.read_bytes()).hexdigest()
    (FOLDER / "SHA256").write_text(f"{digest}  {library.name}\n", encoding="utf-8")
    print(f"{PACKAGE}: {library.stat().st_size / 1000:.0f} kB, sha256 {digest}")


if __name__ == "__main__":
    main()
