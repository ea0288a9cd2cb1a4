r"""Random numbers that are a function of a seed and a count: the same bits on every target, and no hidden state.

A counter-based generator needs no state that a run would have to carry, and a run can be repeated, cut short or split
without its numbers changing. The seed and the count are mixed by rounds of multiplication and shift on 32 bits
(constants below :math:`2^{31}`, so that no product leaves 63 bits and every language gives the same one).

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
    """Return 32 bits in which every one of the 32 given has a part; a bijection."""
    bits = ((bits ^ (bits >> 16)) * ODD_1) & MASK
    bits = ((bits ^ (bits >> 15)) * ODD_2) & MASK
    bits = ((bits ^ (bits >> 15)) * ODD_1) & MASK
    return bits ^ (bits >> 16)


@kernel
def uniform(seed, count):
    """Return a number of the open interval from 0 to 1, for a seed and a count that are not negative integers."""
    low = mixed((mixed(seed & MASK) + (count & MASK) * GOLDEN) & MASK)
    high = mixed((low + (count >> 32) + seed * ODD_2) & MASK)
    return (high + 0.5) / 4294967296.0


@kernel
def normal(seed, count):
    """Return a number of the standard normal distribution, for a seed and a count (the method of Box and Muller)."""
    radius = math.sqrt(-2.0 * log(uniform(seed, 2 * count)))
    return radius * cos(2.0 * math.pi * uniform(seed, 2 * count + 1))
