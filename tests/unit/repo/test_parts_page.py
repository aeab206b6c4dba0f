"""The page of parts by themselves prints what it promises, from the public face alone."""

import contextlib
import io
import re

import pytest
from repository import ROOT

PAGE = (ROOT / "docs" / "parts.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_parts_page_runs_and_prints_documented_numbers():
    """Each number is another program's, or a closed form's, in the tests of its room."""
    said, names = io.StringIO(), {}
    with contextlib.redirect_stdout(said):
        for block in re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL):
            exec(block, names)
    printed = said.getvalue()
    assert "caught at half, 2 of 2" in printed
    assert "[[62.5], [49.4]] km/h" in printed  # 17.354 and 13.728 m/s
    assert "[0, 15]" in printed
    assert "250.0" in printed  # 100 (1 + 0.3/0.2)
    assert "[3299. 3387.] [7155. 7280.]" in printed
