"""The lines that docs/publish.md gives for a hosted Space fit the repository."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).resolve().parents[2]


def test_the_front_matter_names_this_app_and_versions_that_the_project_supports():
    text = (ROOT / "docs/publish.md").read_text(encoding="utf-8")
    block = re.search(r"```yaml\n---\n([^`]*?sdk: gradio.*?)---\n```", text, re.DOTALL)
    assert block is not None
    lines = (line.split(": ") for line in block[1].splitlines())
    given = {name: value.strip('"') for name, value in lines}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed = {one.name: one.specifier for one in map(Requirement, project["dependencies"])}
    assert given["sdk"] == "gradio"
    assert given["sdk_version"] in needed["gradio"]
    assert given["python_version"] in SpecifierSet(project["requires-python"])
    assert (ROOT / given["app_file"]).is_file()
