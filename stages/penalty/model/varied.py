"""A penalty walker whose own numbers vary: each of the last variations of a state goes along with a change of them.

What carries such changes is compiled only for a walker that asks for them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stages.penalty.model.walker import Walker


class VariedPenalty(NamedTuple):
    """`plain` walker; `along` (n, numbers of `plain` before the law), their changes for the last n variations.

    `laws` (n, numbers of the law): these numbers, with their changes as imaginary parts (`contact.STEP`); `of_law` (n,)
    whether they change at all. `delays` (columns,): by how much every variation delays the events so far.
    """

    plain: Walker
    along: np.ndarray
    laws: np.ndarray
    of_law: np.ndarray
    delays: np.ndarray
