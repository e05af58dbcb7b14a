"""Numba once it has compiled something: what it then has loaded takes a second, and serves all who are forked."""

import numba

numba.njit(lambda x: 2.0 * x)(1.0)
