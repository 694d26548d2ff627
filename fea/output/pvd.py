"""A collection of result files that ParaView plays as a series."""

from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

from fea.output.text import write_text

_HEAD = (
    '<?xml version="1.0"?>\n'
    '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
    "  <Collection>\n"
)
_FOOT = "  </Collection>\n</VTKFile>\n"


def write_pvd(path: Path, times: Mapping[str, float]) -> None:
    """Write a collection of files beside it.

    Parameters
    ----------
    path
        The file to write.
    times
        Where each file stands in the series, by its name: crank angles in degrees, or numbers.

    Raises
    ------
    StorageError
        The file could not be written.
    """
    ordered = sorted(times.items(), key=lambda item: item[1])
    rows = (_row(name, time) for name, time in ordered)
    write_text(path, _HEAD + "".join(rows) + _FOOT)


def _row(name: str, time: float) -> str:
    shown, file = quoteattr(Path(name).stem), quoteattr(name)
    return f'    <DataSet timestep="{time:.10g}" part="0" name={shown} file={file}/>\n'
