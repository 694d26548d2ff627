"""Read the tetrahedra of a file, through meshio or, for Abaqus and CalculiX, from the deck itself."""

import io
import re
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from mesh.errors import MeshError
from mesh.files.formats import FORMATS
from mesh.files.inp_file import read_inp
from mesh.files.msh_file import is_msh, read_msh
from mesh.files.stl_file import read_stl
from mesh.files.tet_file import TetFile, tet_file


def read_tets(path: Path) -> TetFile:
    """Read the tetrahedra of a mesh file; its suffix is one of `FORMATS`.

    Raises
    ------
    MeshError
        The file is damaged, or holds no mesh that is supported; the message names it.
    OSError
        It cannot be read.
    ImportError
        A library that the format needs is not installed.
    """
    name = FORMATS[path.suffix.lower()]
    try:
        reader = _OWN.get(name)
        return _through_meshio(path, name) if reader is None else reader(path)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error
    except ImportError as error:
        missing = error.name or "a library"
        raise ImportError(f"{path} cannot be read without {missing}. Type: pip install {missing}") from error
    except (OSError, MemoryError) as error:
        if isinstance(error, OSError) and error.errno is None:  # h5py's, for files that are not HDF5
            raise _damaged(path, name, error) from error
        raise
    except Exception as error:  # what meshio and its parsers raise is not documented
        raise _damaged(path, name, error) from error


# Readers of our own.
_OWN = {"abaqus": read_inp, "stl": read_stl}


def _damaged(path: Path, name: str, error: Exception) -> MeshError:
    reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    return MeshError(
        f"{path} could not be read as a file of the format {name} ({reason}). It may be damaged or cut off: "
        "write it again, or choose another format"
    )


def _through_meshio(path: Path, name: str) -> TetFile:
    read = import_module(f"meshio.{name}").read
    try:
        found = read(_bulk_data(path) if name == "nastran" else str(path))
    except Exception:
        if name != "gmsh" or not is_msh(path):
            raise
        return read_msh(path)  # files in which some entities alone have physical groups
    if name == "nastran":
        _require_one_frame(found)
    first = 1
    blocks = []
    for block in found.cells:
        blocks.append((block.type, np.asarray(block.data), np.arange(first, first + len(block.data))))
        first += len(block.data)
    return tet_file(np.asarray(found.points), blocks)


def _bulk_data(path: Path) -> io.StringIO:
    """Nastran's bulk data as meshio insists on it: marked continuation lines, between two other lines."""
    text = path.read_text(encoding="utf-8", errors="replace")
    if "\nCTETRA*" in text:
        raise MeshError(
            "its CTETRA entries are in large fields, which are not supported. Write them in small ones"
        )
    text = re.sub(r"(?m)^(?: {8}|(?=,))(?=.*\S)", lambda blank: "+".ljust(len(blank[0])), text)
    begin = "" if "BEGIN BULK" in text else "BEGIN BULK\n"
    end = "" if "\nENDDATA" in text else "\nENDDATA\n"
    return io.StringIO(begin + text + end)


def _require_one_frame(found: Any) -> None:
    """Refuse nodes in coordinate systems of their own, which meshio ignores."""
    frames = found.point_data.get("nastran:ref", ())
    if np.any(np.asarray(frames) != 0):
        raise MeshError("its GRID entries use coordinate systems (field CP). Write them in the basic system")
