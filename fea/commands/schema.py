"""`fea schema`."""

import sys


def schema() -> None:
    """Print the JSON Schema of a study, for editors and other programs."""
    from fea.output.json_file import json_text
    from fea.study.schema import study_schema

    sys.stdout.write(json_text(study_schema()))
