r"""Random numbers as a function of a seed and a count: the same bits on every target, without hidden state.

A counter-based generator needs no state in a run, and a run can be repeated, shortened or split without a change of its
numbers. Rounds of multiplication and shift on 32 bits mix the seed and the count. The constants are below
:math:`2^{31}`, so all products fit into 63 bits and are the same in every language.

References
----------
.. [1] J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as 1, 2, 3", Proc. Int.
   Conf. for High Performance Computing, 2011. doi:10.1145/2063384.2063405
"""

import math

from bristle.core.kernel import kernel
from bristle.core.mathematics import cos, log

SEED_MAX = 2**31 - 1  # largest seed
MASK = 2**32 - 1
ODD_1, ODD_2, GOLDEN = 0x7FEB352D, 0x21F0AAAD, 0x1E3779B9


@kernel
def mixed(bits):
    """Mix 32 bits, so that each output bit depends on all input bits; a bijection."""
    bits = ((bits ^ (bits >> 16)) * ODD_1) & MASK
    bits = ((bits ^ (bits >> 15)) * ODD_2) & MASK
    bits = ((bits ^ (bits >> 15)) * ODD_1) & MASK
    return bits ^ (bits >> 16)


@kernel
def uniform(seed, count):
    """Return a uniform random number in the open interval (0, 1), for a non-negative integral seed and count."""
    low = mixed((mixed(seed & MASK) + (count & MASK) * GOLDEN) & MASK)
    high = mixed((low + (count >> 32) + seed * ODD_2) & MASK)
    return (high + 0.5) / 4294967296.0


@kernel
def normal(seed, count):
    """Return a standard normal random number for a seed and a count (method of Box and Muller)."""
    radius = math.sqrt(-2.0 * log(uniform(seed, 2 * count)))
    return radius * cos(2.0 * math.pi * uniform(seed, 2 * count + 1))
