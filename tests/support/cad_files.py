"""Rods as CAD files of every format."""

import tempfile
import zipfile
from pathlib import Path

import gmsh

from fea.study.study import parse_study
from geometry.session import session
from geometry.solid import build
from geometry.surfaces import Mirror

CAD_ENDINGS = ("step", "igs", "brep", "FCStd")


def cad_file(rod, ending):
    """Bytes of the whole rod in the format of an ending."""
    with tempfile.TemporaryDirectory() as folder, session():
        build(rod, Mirror.NONE)
        path = Path(folder, f"rod.{'brep' if ending == 'FCStd' else ending}")
        gmsh.write(str(path))
        if ending != "FCStd":
            return path.read_bytes()
        archive = Path(folder, "rod.FCStd")
        with zipfile.ZipFile(archive, "w") as file:  # stored, so that damage reaches the shape
            file.writestr("Document.xml", freecad_document("rod.brp"))
            file.write(path, "rod.brp")
        return archive.read_bytes()


def drawn_study(folder, name, draw, size, more=""):
    """The study of a steel rod that is drawn into a STEP file of a folder and pulled with 20 kN."""
    with session():
        gmsh.model.add(name)
        draw(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.write(str(Path(folder, f"{name}.step")))
    text = f"""
[rod]
step = "{name}.step"
[material]
E_GPa = 207.0
nu = 0.3
density_kg_m3 = 7850.0
yield_MPa = 700.0
[forces]
pin_N = [20000.0, 0.0]
[mesh]
size_mm = {size}
{more}"""
    return parse_study(text, name, folder)


def freecad_document(shape, label="Rod"):
    """The description of a FreeCAD file with one body."""
    return f"""<?xml version='1.0' encoding='utf-8'?>
<Document><Objects Count="1"><ObjectDeps Name="Body" Count="0"/>
<Object type="PartDesign::Body" name="Body"/></Objects>
<ObjectData Count="1"><Object name="Body"><Properties>
<Property name="Label"><String value="{label}"/></Property>
<Property name="Shape"><Part file="{shape}"/></Property>
</Properties></Object></ObjectData></Document>"""
