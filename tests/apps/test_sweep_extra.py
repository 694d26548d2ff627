import pytest

from fea.__main__ import exit_code
from fea.apps.sweep import sweep_file as extra


def test_the_line_to_type_is_said_where_a_library_is_missing(monkeypatch):
    monkeypatch.setattr(extra, "find_spec", lambda name: None if name == "pyarrow" else name)
    with pytest.raises(ImportError, match=r"needs pyarrow, .*pip install pyarrow") as caught:
        extra.require_extra()
    assert exit_code(caught.value) == 7
