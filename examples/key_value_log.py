"""A reader of your own: lines of ``name=value`` pairs, one line for each sample, as printed by many firmwares.

``bristle log drive.log --reader key_value_log.py`` reads lines such as ``t_ms=12 pos=0.1834 iq=-0.42``. Check it with
``bristle check key_value_log.py``.
"""

import numpy as np

from bristle.logs.formats import LogFormat


def recognises(head, suffix):
    first = head.split(b"\n", 1)[0].split()
    return len(first) > 1 and all(pair.count(b"=") == 1 for pair in first)


def read(data, request):
    lines = data.decode().split("\n")[:-1]  # the text after the last line end is an incomplete row
    rows = [dict(pair.split("=") for pair in line.split()) for line in lines if line]
    units = {"t_ms": "t [ms]", "pos": "position [mm]", "iq": "current [A]"}
    return {units.get(name, name): np.array([float(row[name]) for row in rows]) for name in rows[0]}


EXAMPLE = "".join(f"t_ms={k} pos={0.01 * k * k:.4f} iq={-0.42 + 0.05 * k:.3f}\n" for k in range(8))
FORMAT = LogFormat(
    "key_value_log", "lines of name=value", recognises, read=read, example=EXAMPLE.encode()
)
