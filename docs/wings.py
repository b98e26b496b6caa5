"""Draw the wings of the library from its imports: `python docs/wings.py` writes docs/wings.svg.

Rows are the layers that `pyproject.toml` declares; a line means "imports". A line that follows
from two others is left out.
"""

import ast
import tomllib
from html import escape
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PURPOSE = {
    "cli": "commands",
    "notebook": "Explore in a cell",
    "study": "experiments and tables",
    "figures": "pictures to take away",
    "training": "from pairs to a head",
    "maps": "what the page draws",
    "measure": "what a head is worth",
    "head": "the model and its file",
    "encoders": "pictures to vectors",
    "data": "pairs and files",
    "fractional": "the transform",
    "kit": "small tools",
}
WIDTH, ROW, BOX, TALL = 720, 62, 170, 38


def layers() -> list[list[str]]:
    """Return the wings by layer, top first."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    contracts = tomllib.loads(text)["tool"]["importlinter"]["contracts"]
    return [row.split(" | ") for row in contracts[0]["layers"]]


def imported() -> dict[str, set[str]]:
    """Return which wings each wing imports."""
    arrows: dict[str, set[str]] = {}
    for path in (ROOT / "omnivat").rglob("*.py"):
        wing = path.relative_to(ROOT / "omnivat").parts[0].removesuffix(".py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("omnivat."):
                other = str(node.module).split(".")[1]
                arrows.setdefault(wing, set()).update({other} - {wing})
    return arrows


def reduced(arrows: dict[str, set[str]]) -> dict[str, set[str]]:
    """Return the arrows that do not follow from others."""

    def below(wing: str) -> set[str]:
        direct = arrows.get(wing, set())
        return direct.union(*(below(other) for other in direct))

    return {
        wing: {o for o in others if not any(o in below(via) for via in others - {o})}
        for wing, others in arrows.items()
    }


def picture() -> str:
    """Return the SVG; the first row is turned, so that lines cross less."""
    rows = [row[::-1] if level == 0 else row for level, row in enumerate(layers())]
    place = {
        wing: (WIDTH * (k + 1) / (len(row) + 1), 14 + ROW * level)
        for level, row in enumerate(rows)
        for k, wing in enumerate(row)
    }
    lines: list[str] = []
    boxes: list[str] = []
    for wing, others in sorted(reduced(imported()).items()):
        for other in sorted(others):
            if wing in place:
                (x, y), (u, v) = place[wing], place[other]
                level, to = round((y - 14) / ROW), round((v - 14) / ROW)
                if to == level + 1:
                    bend = 0.5 * (y + TALL + v)
                    way = f"M{x:.0f} {y + TALL} C{x:.0f} {bend:.0f} {u:.0f} {bend:.0f} {u:.0f} {v}"
                else:  # past other wings: around them
                    middle = x == u == WIDTH / 2
                    side = 1 if max(x, u) > WIDTH / 2 or (middle and to % 2) else -1
                    x, u = x + side * BOX / 2, u + side * BOX / 2
                    y, v = y + TALL / 2, v + TALL / 2
                    bend = (max(x, u) + 60 if side > 0 else min(x, u) - 60) + 10 * side * (
                        to - level
                    )
                    way = f"M{x:.0f} {y:.0f} C{bend:.0f} {y:.0f} {bend:.0f} {v:.0f} {u:.0f} {v:.0f}"
                lines.append(f'<path d="{way}" fill="none" stroke="#8a94a6" stroke-width="1.4"/>')
    for wing, (x, y) in place.items():
        boxes.append(
            f'<rect x="{x - BOX / 2:.0f}" y="{y}" width="{BOX}" height="{TALL}" rx="8" '
            'fill="#eef2f8" stroke="#4a5a78"/>'
            f'<text x="{x:.0f}" y="{y + 16}" font-weight="600">{escape(wing)}</text>'
            f'<text x="{x:.0f}" y="{y + 31}" font-size="11">{escape(PURPOSE[wing])}</text>'
        )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {ROW * len(rows)}" '
        'font-family="system-ui, sans-serif" font-size="14" text-anchor="middle" fill="#1b2433">'
        + f'<rect width="{WIDTH}" height="{ROW * len(rows)}" fill="#fff"/>'
        + "\n".join(["", *lines, *boxes, "</svg>", ""])
    )


if __name__ == "__main__":
    (ROOT / "docs" / "wings.svg").write_text(picture(), encoding="utf-8")
