"""A study reduced to its load cases, for what is solved many times or beside a run."""

from dataclasses import replace
from typing import Any

from fea.study.defect_table import DefectTable
from fea.study.option_tables import OutputTable
from fea.study.study import Study


def load_cases_alone(study: Study, **options: Any) -> Study:
    """Return the study without the crank cycle and what needs it, and with other keys of [analysis]."""
    analysis = replace(study.analysis, cycle=False, fretting=False, **options)
    beside: dict[str, Any] = {"duty": None, "scatter": None, "overload": None, "optimise": None}
    return replace(study, analysis=analysis, defect=DefectTable(), output=OutputTable(), **beside)
