"""Computes the study, computes all of it anew, and compares every artefact, figure and the report (without its times).

Run: python -m benchmarks.twice [file for the hashes]. Ends with 1 and the names of what differs. The nightly workflow
calls this; a run takes twice as long as `bipedstudy run-all` does from nothing.
"""

import hashlib
import subprocess
import sys
import tempfile
from pathlib import Path

_NOT_RESULTS = (".cache", "log", "log.jsonl", "sweeps", "differences", "report.html")


def hashes(results: Path) -> dict[str, str]:
    """SHA-256 of every file in a results folder that follows from the study alone, and of the report without times."""
    found = {
        path.relative_to(results).as_posix(): path.read_bytes()
        for path in sorted(results.rglob("*"))
        if path.is_file() and path.relative_to(results).parts[0] not in _NOT_RESULTS
    }
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder, "report.html")
        _bipedstudy("report", "--no-times", "--into", str(page))
        found["report.html (without times)"] = page.read_bytes()
    return {name: hashlib.sha256(content).hexdigest() for name, content in found.items()}


def main() -> None:
    """Run the study of the working folder twice and print the hashes, or what differs."""
    results = Path("results")
    _bipedstudy("run-all")
    first = hashes(results)
    _bipedstudy("run-all", "--force")
    second = hashes(results)
    lines = [f"{sha}  {name}" for name, sha in first.items()]
    print("\n".join(lines))
    if sys.argv[1:]:
        Path(sys.argv[1]).write_text("\n".join(lines) + "\n", encoding="utf-8")
    differ = [name for name in sorted({*first, *second}) if first.get(name) != second.get(name)]
    if differ:
        sys.exit(f"{len(differ)} of {len(first)} files differ: {', '.join(differ)}")
    print(f"{len(first)} files, all equal")


def _bipedstudy(*words: str) -> None:
    done = subprocess.run([sys.executable, "-m", "pipeline.cli", *words], stdout=sys.stderr)
    if done.returncode:
        sys.exit(done.returncode)


if __name__ == "__main__":
    main()
