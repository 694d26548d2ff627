"""A model of `fea studio` that solves nothing: a box whose figures are those of its design, and known."""

import time
from dataclasses import replace

import numpy as np

from fea.apps.studio.figures import Label, ShownFactor, StudioFigures, StudioFrame
from fea.apps.studio.operating_point import OperatingPoint, SliderRange, dimensions
from fea.judge.safety_factor import SafetyFactor

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (-0.2, 0.2) for z in (-0.1, 0.1)])
FACES = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
], np.int32)  # fmt: skip


def peak(design, operation):
    """The only stress of a design, MPa: any change of it changes this."""
    return 100.0 + 7 * design.get("web_thickness_mm", 5.0) + 1e-3 * operation.rpm


def box(study, design, operation, label, **more):
    """A frame of a design."""
    value = peak(design, operation)
    factor = 700 / value
    at = (100.0, 10.0, 5.0)
    own = ShownFactor(SafetyFactor.of_stress(factor, 4.0), "the web", at)
    figures = StudioFigures(
        mass_kg=0.1 * design.get("web_thickness_mm", 5.0),
        cases=(replace(own, name="tension", peak_MPa=value),),
        governing="tension",
        yielding=own,
        fatigue=None
        if label is Label.INTERPOLATED
        else ShownFactor(SafetyFactor.of_stress(0.8 * factor, 4.0), "the web", at),
        buckling=ShownFactor(SafetyFactor(3 * factor), "the shank"),
    )
    length = study.rod.dimensions.length
    points = (CORNERS * [length, length, length]).astype(np.float32)
    values = np.full(8, value, np.float32)
    return StudioFrame(
        operation=operation, label=label, figures=figures, points=points, values=values,
        pins="prescribed", **more,
    )  # fmt: skip


class LiveRod:
    """Answers as `fea.apps.studio.live_rod.LiveRod`."""

    def __init__(self, study):
        self.study, self.base, self.triangles = study, 0, FACES
        self.dimensions, self.base_design = dimensions(study), {}
        self.operation = OperatingPoint.of(study)

    def ranges(self, design):
        found = {each.key: SliderRange(0.5 * each.value, 1.5 * each.value) for each in self.dimensions}
        web = SliderRange(3.0, 6.0, "the web is too thin", "the web is too thick", 4.0, 5.5)
        return found | {"web_thickness_mm": web}

    def touch(self, name, design, operation):
        for share in (0.5, 1.0):
            time.sleep(0.01)
            yield share

    def frame(self, design, operation, fields="von_mises"):
        return box(self.study, design, operation, Label.INTERPOLATED)

    def exact(self, design, operation, fields="von_mises"):
        time.sleep(0.05)
        yield box(self.study, design, operation, Label.EXACT)


def fresh(study):
    """Answers as `fea.apps.studio.live_rod.fresh`."""
    time.sleep(0.1)
    design = {"web_thickness_mm": study.rod.dimensions.web_thickness}
    return box(study, design, OperatingPoint.of(study), Label.CONVERGED, triangles=FACES)
