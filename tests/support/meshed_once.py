"""Rods that are meshed once: hundreds of tests mesh a few rods, to test something else."""

import hashlib
import os
import pickle
from contextlib import contextmanager, suppress

import pytest

from fea.rod.discretise import _Drawing
from fea.study.study import Study


@contextmanager
def meshed_once(folder):
    """Within this block, and in copies of this process, read from a folder what was meshed before.

    Equal requests of equal studies give equal meshes, each of objects of its own. Rods from files are always
    read and meshed.
    """
    original = _Drawing.meshed

    def meshed(drawing, request, clock):
        study = getattr(drawing.materials, "__self__", None)
        if drawing.rod.cad is not None or not isinstance(study, Study):
            return original(drawing, request, clock)
        asked = (
            drawing.rod,
            drawing.assembly,
            drawing.repair,
            request,
            request.per_touched_bore,
            study.material,
            study.part_material,
        )
        file = folder / hashlib.sha256(pickle.dumps(asked)).hexdigest()
        if file.exists():
            with clock("geometry"), clock("mesh"):
                found = pickle.loads(file.read_bytes())  # noqa: S301 - written below
            drawing.repair = found.meshing.repair
        else:
            found = original(drawing, request, clock)
            whole = file.with_suffix(f".{os.getpid()}")
            with suppress(OSError):  # the disk is full, or is to seem so
                whole.write_bytes(pickle.dumps(found))
                whole.replace(file)
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_Drawing, "meshed", meshed)
        yield
