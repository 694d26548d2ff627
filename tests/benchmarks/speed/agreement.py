"""How far the answer of a program is from the reference on the same mesh.

    python agreement.py REFERENCE.npz ANSWER.npz|ANSWER.frd

prints the largest differences over the largest value, as JSON: of the displacement after both are rid of
their rigid motion (the restraints differ, the reactions vanish); of the von Mises stress at the Gauss
points (`gauss`), of the nodal mean of extrapolated Gauss values (`mean`), or of our recovered nodal stress
(`recovered`), whichever both form.
"""

import json
import sys
from pathlib import Path

import numpy as np
from worker import von_mises

from fea.solid.stress import matrices
from fea.solid.supports import rigid_modes


def without_rigid_motion(displacement: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The part of a displacement that no small rigid motion explains (least squares)."""
    basis, _ = np.linalg.qr(rigid_modes(points).reshape(-1, 6))
    flat = displacement.ravel()
    return (flat - basis @ (basis.T @ flat)).reshape(-1, 3)


def read_frd(path: Path) -> dict[str, np.ndarray]:
    """Displacement (n, 3) and stress (n, 6) of CalculiX's result file, node by node."""
    blocks: dict[str, list[str]] = {}
    name = ""
    with path.open(encoding="ascii") as file:
        for line in file:
            if line.startswith(" -4"):
                name = line[5:13].strip()
                blocks[name] = []
            elif line.startswith(" -3"):
                name = ""
            elif name and line.startswith(" -1"):
                blocks[name].append(line)
    return {key: np.array([_numbers(line) for line in lines]) for key, lines in blocks.items()}


def _numbers(line: str) -> list[float]:
    values = line[13:].rstrip("\n")
    return [float(values[i : i + 12]) for i in range(0, len(values), 12)]


def same_order(gauss: np.ndarray, places: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Values at Gauss points (n, k) at `places`, in the order of the places `wanted`."""
    distance = np.linalg.norm(wanted[:, :, None] - places[:, None], axis=-1)
    nearest = distance.argmin(axis=2)
    if np.take_along_axis(distance, nearest[..., None], axis=2).max() > 1e-6:
        raise ValueError("the Gauss points are not at the same places")
    return np.take_along_axis(gauss, nearest, axis=1)


def compare(reference: dict[str, np.ndarray], answer: dict[str, np.ndarray]) -> dict[str, float]:
    """Largest differences over the largest value of the reference."""
    points = reference["points"]
    wanted = without_rigid_motion(reference["displacement"], points)
    found = without_rigid_motion(answer["displacement"], points)
    differences = {"displacement": relative(found, wanted)}
    if "gauss" in answer and "gauss" in reference:
        differences["gauss"] = relative(
            same_order(answer["gauss"], answer["places"], reference["places"]), reference["gauss"]
        )
    for kind in ("mean", "recovered"):
        if kind in answer and kind in reference:
            differences[kind] = relative(answer[kind], reference[kind])
    return differences


def relative(found: np.ndarray, wanted: np.ndarray) -> float:
    """Largest difference over the largest value."""
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def read(path: Path) -> dict[str, np.ndarray]:
    """The answer of one of our workers, or of CalculiX."""
    if path.suffix == ".frd":
        found = read_frd(path)
        return {"displacement": found["DISP"], "mean": von_mises(matrices(found["STRESS"]))}
    with np.load(path) as data:
        return dict(data)


if __name__ == "__main__":
    reference, answer = (read(Path(name)) for name in sys.argv[1:])
    sys.stdout.write(json.dumps(compare(reference, answer)))
