"""The page's scripts and styles: lines that a reader sees whole, and imports that go one way."""

import graphlib
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WEB = ROOT / "app" / "web"
IMPORT = re.compile(
    r"""(?:^(?:import|export)\b[^;"']*|\bimport\()\s*["'](\.[^"']+\.js)["']""", re.M
)
COMMENT = re.compile(r"/\*.*?\*/", re.S)


def test_no_line_of_scripts_styles_and_pages_is_longer_than_120():
    long = [
        f"{path.relative_to(ROOT)}:{number}"
        for folder in (WEB, ROOT / "tests" / "web")
        for path in folder.rglob("*")
        if path.suffix in (".js", ".ts", ".css", ".html")
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if len(line) > 120
    ]
    assert long == []


def imports():
    """Return each script of the page with the scripts that it imports, at once or later."""
    return {
        path: {
            (path.parent / name).resolve()
            for name in IMPORT.findall(COMMENT.sub("", path.read_text(encoding="utf-8")))
        }
        for path in WEB.rglob("*.js")
    }


def circle(graph):
    """Return the nodes of a circle in a graph as text; "" if there is none."""
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return " -> ".join(map(str, error.args[1]))
    return ""


def test_no_script_and_no_folder_imports_itself_by_way_of_others():
    scripts = imports()
    folders = {}
    for path, others in scripts.items():
        folders.setdefault(path.parent.name, set()).update(other.parent.name for other in others)
    for name, others in folders.items():
        others.discard(name)
    assert len(scripts) > 90 and sum(map(len, scripts.values())) > 400
    assert (circle(scripts), circle(folders)) == ("", "")
