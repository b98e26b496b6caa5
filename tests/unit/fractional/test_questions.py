"""The code in the questions of docs/fractional.md runs, in order, and its assertions hold."""

import re
from pathlib import Path

DOCUMENT = Path(__file__).parents[3] / "docs" / "fractional.md"


def test_every_block_of_the_questions_runs_and_holds():
    text = DOCUMENT.read_text(encoding="utf-8")
    questions = text[text.index("## Questions") :]
    blocks = re.findall(r"```python\n(.*?)```", questions, re.DOTALL)
    assert len(blocks) == questions.count("?**") == 5
    names = {}
    for block in blocks:
        exec(compile(block, str(DOCUMENT), "exec"), names)
