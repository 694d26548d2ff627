"""León 2001, table 7: measured gas pressure and its force on the piston."""

import numpy as np

from fea.study.traces import shipped_trace
from fea.units import BAR, DEG, RPM
from fea.verify.reproduce.leon_engine import AREA_USED, SOURCE, SPEEDS, engine
from fea.verify.reproduce.printed import column, degrees, values
from fea.verify.reproduce.row import Slip
from fea.verify.reproduce.table import Column, Table, table


def gas() -> Table:
    """Table 7: measured pressure, and its force."""
    name = "leon2001_table7_gas"
    columns = []
    for rpm in SPEEDS:
        pressure, force = column(name, f"p_{rpm}rpm_bar"), column(name, f"F_{rpm}rpm_N")
        trace = shipped_trace(SOURCE).pressure(degrees(pressure) * DEG, np.array(rpm * RPM))
        open_end = {
            key: Slip("the measured values at 0° and 720° differ; here that at 0° is used", cell.value)
            for key, cell in ((c.key, c) for c in pressure)
            if float(key) >= 720
        }
        speed = f"{rpm} rpm"
        columns += [
            Column(
                quantity="gas pressure",
                unit="bar",
                cells=pressure,
                as_published=trace / BAR,
                corrected=trace / BAR,
                speed=speed,
                slips=open_end,
            ),
            Column(
                quantity="gas force",
                unit="N",
                cells=force,
                as_published=AREA_USED * values(pressure) * BAR,
                corrected=trace * engine().piston_area,
                cause="piston area 5944 mm² (a bore of 87 mm) instead of 4536 mm² (76 mm)",
                speed=speed,
            ),
        ]
    return table(
        SOURCE,
        "7",
        "measured gas pressure and its force",
        columns,
        [
            "Two litres with 94 mm stroke need a bore of 82.3 mm; 76 mm gives 1.71 and 87 mm 2.24 litres.",
        ],
    )
