#!/bin/bash
# asammdf 8.8.28, channels of different rates and lengths in one MDF 4 file (engine and vehicle logs).
# to_dataframe() puts all channels on the union of their times. Outside a channel's own recording it holds the first or
# last sample instead of leaving the gap empty: a load signal that ended is logged as constant to the end of the lap, and
# one that began late as its first value from the start. resample() does the same, with pandas' dtypes unchanged.
# Seen: speed recorded from 5.00 to 5.75 s reads 30 rpm at 5.85 and 5.95; pressure recorded from 5.05 s reads 100 at 5.00.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q asammdf==8.8.28 pandas==3.1.1 numpy==2.4.6 2>/dev/null
cd "$folder"
venv/bin/python - <<'PYTHON'
import numpy as np
from asammdf import MDF, Signal

log = MDF()
log.append([Signal(np.array([0.0, 10, 20, 30]), np.arange(4) * 0.25 + 5, name="speed", unit="rpm")])
log.append([Signal(100.0 + np.arange(10), np.arange(10) * 0.1 + 5.05, name="pressure", unit="bar")])
log.save("log.mf4", overwrite=True)
log = MDF("log.mf4")
table = log.to_dataframe(time_from_zero=False)
print(table)
regular = log.resample(0.1).to_dataframe(time_from_zero=False)
assert not table.isna().to_numpy().any(), "gaps are left empty"
assert table["pressure"].iloc[0] == 100.0 and abs(table.index[0] - 5.0) < 1e-9
assert (table["speed"][table.index > 5.76] == 30.0).all() and (table.index > 5.76).sum() == 2
assert not regular.isna().to_numpy().any() and regular["speed"].iloc[-1] == 30.0
PYTHON
