"""Join the input and output of a test record from two MAT files into one log.

Usage: ``python join.py uval_multisine.mat yval_multisine.mat test.npz``.
"""

import sys

import numpy as np
import scipy.io


def main() -> int:
    if len(sys.argv) != 4:
        print((__doc__ or "").strip(), file=sys.stderr)
        return 2
    columns = {}
    for name, path in zip("uy", sys.argv[1:3], strict=True):
        arrays = [one for key, one in scipy.io.loadmat(path).items() if not key.startswith("__")]
        columns[name] = arrays[0].ravel()
    np.savez(sys.argv[3], **columns)
    return 0


if __name__ == "__main__":
    sys.exit(main())
