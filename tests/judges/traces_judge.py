# requires: npTDMS==1.13.0 asammdf==8.8.28 pandas==3.1.1 numpy==2.4.6
"""One pressure trace as it is handed on: TDMS by npTDMS, MDF 4 by asammdf, tables of others."""

import csv

import asammdf
import nptdms
import numpy as np
import pandas as pd
from rows import Item, judge


def trace():
    """Angles, degrees, with firing TDC at 360°, and gauge pressures, bar: compression, flame, exhaust."""
    angles = np.arange(0, 720, 0.5)
    x = angles - 360
    rod = (1 - np.sqrt(1 - (0.3 * np.sin(np.radians(x))) ** 2)) / 0.3  # that is 3.3 crank radii long
    volume = 1 / 9 + (1 - np.cos(np.radians(x)) + rod) / 2
    base = 0.95 * ((1 / 9 + 1) / volume) ** 1.32
    flame = np.where(x < 180, 1 + 1.5 * (1 - np.exp(-5 * (np.clip(x + 10, 0, None) / 50) ** 3)), 0)
    closed = np.where(np.abs(x) <= 180, base * np.maximum(flame, 1), 0.95)
    exhaust = 1.06 + (closed[x == 180] - 1.06) * np.exp(-np.clip(x - 180, 0, None) / 15)
    return angles, np.where(x > 180, exhaust, closed) - 1.01325


def tdms(folder, angles, pressures):
    """A channel each of angle and pressure, as LabVIEW records them, and npTDMS' table of them."""
    with nptdms.TdmsWriter(folder / "trace.tdms") as file:
        for name, unit, values in (("Crank angle", "deg", angles), ("Cylinder pressure", "bar", pressures)):
            file.write_segment([nptdms.ChannelObject("Indicated", name, values, {"unit_string": unit})])
    group = nptdms.TdmsFile.read(folder / "trace.tdms")["Indicated"]
    frame = group.as_dataframe()
    frame.columns = [f"{name} [{group[name].properties['unit_string']}]" for name in frame]
    frame.to_csv(folder / "tdms.csv", index=False)


def mdf(folder, angles, pressures):
    """Both channels in an MDF 4 file over time at 3000 rpm, and asammdf's own CSV of it."""
    times = angles / (6 * 3000)
    signals = [
        asammdf.Signal(values, times, name=name, unit=unit)
        for name, unit, values in (("Crank angle", "deg", angles), ("Cylinder pressure", "bar", pressures))
    ]
    with asammdf.MDF(version="4.10") as file:
        file.append(signals)
        file.save(folder / "trace.mf4", overwrite=True)
    with asammdf.MDF(folder / "trace.mf4") as file:
        file.export("csv", folder / "mdf.csv", single_time_base=True, add_units=True, overwrite=True)
        frame = file.to_dataframe()
    frame.to_csv(folder / "mdf-pandas.csv")


def writes(folder, size):
    angles, pressures = trace()
    place = int(pressures.argmax())
    expected = {"peak_bar": float(pressures[place]), "peak_deg": float(angles[place])}
    pressures = pressures * size
    tdms(folder, angles, pressures)
    mdf(folder, angles, pressures)
    frame = pd.DataFrame({"Crank angle [deg]": angles, "Cylinder pressure [kPa]": 100 * pressures})
    frame.to_csv(folder / "german.csv", sep=";", decimal=",", index=False, encoding="utf-16")
    frame.to_csv(folder / "tabs.txt", sep="\t", index=False, float_format="%.5e")
    np.savetxt(folder / "numpy.dat", np.column_stack([angles, pressures]), header="angle_deg pressure_bar")
    with (folder / "excel.csv").open("w", encoding="utf-8-sig", newline="") as file:
        table = csv.writer(file, dialect="excel")
        table.writerows([["Test cell 4"], [], ["Crank angle", "Pressure"], ["°CA", "psi"]])
        table.writerows(zip(angles, 14.503773773 * pressures, strict=True))
    for file, tried in (
        ("tdms.csv", "TDMS through npTDMS and pandas"),
        ("mdf.csv", "MDF 4 through asammdf's CSV"),
        ("mdf-pandas.csv", "MDF 4 through asammdf and pandas, with its times"),
        ("german.csv", "pandas, semicolons and commas, UTF-16, kPa"),
        ("tabs.txt", "pandas, tabs, exponents, kPa"),
        ("numpy.dat", "NumPy, commented heading"),
        ("excel.csv", "Excel's dialect, title, units in a line of their own, psi"),
    ):
        yield Item(file, tried, expected, 2e-3)


judge(f"npTDMS {nptdms.__version__}, asammdf {asammdf.__version__}, pandas {pd.__version__}", None, writes)
