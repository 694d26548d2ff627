"""Connecting-rod stress analysis: solves, judges, tells.

``from fea import run`` does in Python what ``fea run`` does in the shell. ``to_skfem``, ``basis`` and
``stiffness_coo`` give a mesh and its stiffness to scikit-fem.
"""

from pathlib import Path
from typing import Any

_SCIKIT_FEM = ("basis", "stiffness_coo", "to_skfem")
__all__ = ["basis", "run", "stiffness_coo", "to_skfem"]


def __getattr__(name: str) -> Any:
    if name in _SCIKIT_FEM:
        from fea.solid import scikit_fem

        return getattr(scikit_fem, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def run(study: str | Path = "leon-2001", **flags: Any) -> dict[str, Any] | list[dict[str, Any]]:
    """Analyse a study and leave its run on disk.

    Parameters
    ----------
    study
        A shipped study or the path of a TOML file.
    **flags
        Those of ``fea run`` by their Python names: ``rpm`` (a number, a list or text), ``size``,
        ``element``, ``support``, ``symmetry``, ``pressure``, ``solver``, ``min_safety``,
        ``assembly``, ``screenshot``, ``cycle``, ``animate``, ``out``.

    Returns
    -------
    dict or list of dict
        What `summary.json` holds; a list for several speeds.

    Raises
    ------
    geometry.invalid.InvalidValue
        A value breaks a rule.
    """
    from fea.runs import run_study
    from fea.study.flags import python_flags
    from fea.study.study import load_study

    reports = run_study(python_flags(flags).applied(load_study(study)))
    summaries = [report.summary for report in reports]
    return summaries[0] if len(summaries) == 1 else summaries
