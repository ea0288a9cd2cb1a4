"""A reader of your own: lines of ``name=value`` pairs, one a sample, as many a firmware prints them.

``bristle log drive.log --reader key_value_log.py`` reads ``t_ms=12 pos=0.1834 iq=-0.42`` and the like.
"""

import numpy as np

from bristle.logs.formats import LogFormat


def recognises(head, suffix):
    first = head.split(b"\n", 1)[0].split()
    return len(first) > 1 and all(b"=" in pair for pair in first)


def read(data, request):
    rows = [dict(pair.split("=") for pair in line.split()) for line in data.decode().splitlines() if line]
    units = {"t_ms": "t [ms]", "pos": "position [mm]", "iq": "current [A]"}
    return {units.get(name, name): np.array([float(row[name]) for row in rows]) for name in rows[0]}


FORMAT = LogFormat("key_value_log", "lines of name=value", recognises, read=read)
