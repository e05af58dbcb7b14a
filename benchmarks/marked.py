"""A table's place in a page of the documentation: between its marks, which a benchmark fills anew."""

from pathlib import Path


def put(page: Path, name: str, text: str) -> None:
    """Replace what stands between <!-- name --> and <!-- end of name -->. Raises ValueError where the marks are not."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, found, rest = page.read_text(encoding="utf-8").partition(begin)
    _, closed, after = rest.partition(end)
    if not found or not closed:
        raise ValueError(f"{page.name}: has no place {begin} ... {end}")
    page.write_text(f"{before}{begin}\n{text.strip()}\n{end}{after}", encoding="utf-8")
