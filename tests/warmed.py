"""What is done once for all who are forked: it takes a second, and is loaded after all the rest."""

import gc
import sys
from pathlib import Path

import pipeline
from pipeline.report.page import template

if "numba" in sys.modules:
    import numba

    numba.njit(lambda x: 2.0 * x)(1.0)
for page in sorted(Path(pipeline.__file__).parent.glob("*/page.html")):
    template(page)
gc.freeze()  # nothing that is loaded by now is looked through for garbage again
