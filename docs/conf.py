"""How Sphinx makes a site of these pages: `make site`, or the workflow `site`."""

from pathlib import Path

import tomllib

project = "bipedstudy"
author = "bipedstudy authors"
release = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]["version"]
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
root_doc = "index"
html_theme = "furo"
html_title = f"bipedstudy {release}"
myst_heading_anchors = 4  # pages name headings as #words
myst_enable_extensions = ["dollarmath"]
suppress_warnings = ["myst.header"]  # claims begin at the third level
