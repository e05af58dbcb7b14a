"""results/proof.json: a proof of the study's design, and whether it was made or checked here.

A file can say anything. That a proof was made here is known by its digest, which is kept where the user's agreements
are: not among the results, which can come from elsewhere as a whole.
"""

from __future__ import annotations

import json

from pipeline import trust
from pipeline.cache import disk
from pipeline.graph import CLAIMS, PROOF
from pipeline.study import Study

UNCHECKED = "a proof file says so, not checked here"
#: What a page says of any proof.
MEANS = f"results/{PROOF}: exists, is alone in a ball, stable or not, as a theorem."


def keep(study: Study, content: bytes) -> None:
    """Put a proof beside the results, as one that was made or checked here."""
    disk.write(study.results / PROOF, content)
    trust.vouch(study.root, disk.digest(content))


def said(study: Study) -> dict[str, str]:
    """Claim -> what a proof says of it, if it is of the very parameters that the claims' results were made with.

    A study without a stage of claims has none. The proof's keys are names of parameter files, with values, and `says`.
    """
    content = disk.read(study.results / PROOF, disk.MEMO)
    maker = [stage.name for stage in study.graph.stages.values() if CLAIMS in stage.outs]
    entry = study.store.current(*maker) if maker else None
    if content is None or entry is None:
        return {}
    try:
        plain, used = json.loads(content), entry.ingredients["parameters"]
        of = [used[file][key] == value for file in used if file in plain for key, value in plain[file].items()]
        says = {str(claim): str(words) for claim, words in plain["says"].items()} if of and all(of) else {}
    except (ValueError, KeyError, TypeError, AttributeError):
        return {}
    here = trust.vouched(study.root, disk.digest(content))
    return {claim: words if here else UNCHECKED for claim, words in says.items()}
