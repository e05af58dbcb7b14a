"""Parameter files with other values: the text as it stands, but for the entries that change."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.errors import StudyError
from pipeline.parameters import yaml_text


def rewritten(folder: Path, values: Mapping[str, Any], settings: Sequence[str], source: str) -> dict[str, bytes]:
    """Every parameter file of `folder` by its name, with the texts of `--set` and then `values` ("file.key") put in.

    What changed has its unit as before and `source` as its source. Raises `StudyError` for an entry of a table.
    """
    given = {}
    for setting in settings:
        name, _, value = setting.partition("=")
        given[name.strip()] = yaml_text.parse(value, name, with_lines=False).plain()
    files = {path.stem: path.read_text(encoding="utf-8").rstrip() + "\n" for path in sorted(folder.glob("*.yaml"))}
    for name, value in {**given, **values}.items():
        file, _, key = name.partition(".")
        entry = yaml_text.parse(files[file], f"{file}.yaml").value.get(key)
        if "." in key:
            raise StudyError(f"{name}: an entry of a table cannot be written; change it in its file instead")
        described = entry.plain() if entry is not None else None
        unit = {"unit": described["unit"]} if isinstance(described, dict) and "unit" in described else {}
        whole = isinstance(value, dict) and "value" in value  # an entry of its own, with an uncertainty
        parts = {**(value if whole else {"value": value}), **unit, "source": source}
        line = f"{key}: {{{', '.join(f'{part}: {json.dumps(said)}' for part, said in parts.items())}}}\n"
        # an entry goes on over lines that are indented or close it
        stands = re.search(rf"^{re.escape(key)}\s*:.*\n?(?:[ \t}}\]-].*\n?)*", files[file], re.MULTILINE)
        start, end = stands.span() if stands else (len(files[file]), len(files[file]))
        files[file] = files[file][:start] + line + files[file][end:]
    return {f"{name}.yaml": text.encode() for name, text in files.items()}
