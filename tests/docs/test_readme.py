"""The README's Python runs as it stands."""

import re
from pathlib import Path

import pytest

README = (Path(__file__).parent.parent.parent / "README.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("code", BLOCKS, ids=lambda code: code.splitlines()[-1])
def test_readme_code_runs(code):
    names = {"__name__": "readme"}
    exec(code, names)
    assert names["diagram"].num_input_ports() + names["diagram"].num_output_ports() > 0


def test_wiring_takes_fifteen_lines():
    lines = [x for x in BLOCKS[0].splitlines() if x.strip() and "import" not in x]
    assert len(lines) <= 15
