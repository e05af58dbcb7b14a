"""What is done once for all who are forked: it takes a second, and is loaded after all the rest."""

import gc
from pathlib import Path

import numba

import pipeline
from pipeline.report.page import template

numba.njit(lambda x: 2.0 * x)(1.0)
for page in sorted(Path(pipeline.__file__).parent.glob("*/page.html")):
    template(page)
gc.freeze()  # nothing that is loaded by now is looked through for garbage again
