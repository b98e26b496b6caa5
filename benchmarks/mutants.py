"""Which small errors do the tests miss? Change one operator or number at a time, and run them.

    python -m benchmarks.mutants [--areas losses,gaps] [--count 20] [--seed 0] [--out docs/benchmarks/mutants]

A mutant is one change of one line: + for -, * for /, < for <=, `and` for `or`, n + 1 for n, a sign
left out. `--count` of them are drawn for each area; the area's tests run against each in a copy of the
tree until one fails. A mutant that no test notices survives and is listed. Hours for all areas.
"""

import argparse
import ast
import copy
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

AREAS = {
    "fractional": ("tests/properties/test_fractional.py", "tests/unit/fractional"),
    "model": ("tests/unit/model",),
    "losses": ("tests/unit/losses", "tests/unit/model/test_reference.py"),
    "gaps": ("tests/unit/gaps", "tests/properties/test_gaps.py"),
    "train": ("tests/unit/test_train.py", "tests/unit/test_train_resume.py"),
    "projection": ("tests/unit/projection",),
}
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
LIMIT = 900  # seconds for the tests of one mutant; a test that hangs has noticed it


class Mutant(NamedTuple):
    """One change: where, the line's statement before and after, and the file's new text."""

    file: str
    line: int
    before: str
    after: str
    text: str


def mutants(root: Path, area: str, count: int, seed: int) -> Iterator[Mutant]:
    """Yield `count` mutants of an area's modules, drawn from all of them."""
    trees = {
        file: ast.parse(file.read_text(encoding="utf-8"))
        for file in sorted((root / "omnivat" / area).rglob("*.py"))
    }
    every = [
        (file, index)
        for file, tree in trees.items()
        for index, node in enumerate(ast.walk(tree))
        if _change(copy.deepcopy(node) if isinstance(node, ast.expr) else node)
    ]
    for file, index in random.Random(seed).sample(every, min(count, len(every))):
        tree = copy.deepcopy(trees[file])
        node: ast.expr = list(ast.walk(tree))[index]  # type: ignore[assignment]
        before, _ = ast.unparse(node), _change(node)
        name = str(file.relative_to(root))
        yield Mutant(name, node.lineno, before, ast.unparse(node), ast.unparse(tree))


def _change(node: ast.AST) -> bool:
    """Change one expression in place; False if there is nothing to change."""
    if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in SWAPS:
        node.op = SWAPS[type(node.op)]()  # type: ignore[assignment]
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPS:
        node.ops[0] = SWAPS[type(node.ops[0])]()  # type: ignore[call-overload]
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        node.op = ast.UAdd()
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
        node.value = node.value + 1  # type: ignore[operator]
    else:
        return False
    return True


def survives(root: Path, mutant: Mutant, tests: tuple[str, ...]) -> bool:
    """Return True if all tests pass with the mutant in the copy at `root`."""
    file = root / mutant.file
    kept = file.read_text(encoding="utf-8")
    file.write_text(mutant.text, encoding="utf-8")
    try:
        return passes(root, tests)
    finally:
        file.write_text(kept, encoding="utf-8")


def passes(root: Path, tests: tuple[str, ...]) -> bool:
    """Run tests in the copy at `root` until one fails; return True if none does."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-m", "not slow", *tests]
    try:
        done = subprocess.run(command, cwd=root, capture_output=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def table(results: list[tuple[str, Mutant, bool]]) -> str:
    """Return the report: a row for each area, and every survivor."""
    lines = ["# Mutants", "", "| area | mutants | noticed |", "| --- | --- | --- |"]
    for area in dict.fromkeys(area for area, _, _ in results):
        own = [alive for name, _, alive in results if name == area]
        lines.append(f"| {area} | {len(own)} | {len(own) - sum(own)} |")
    lines += ["", "Survivors:", ""]
    for _, m, alive in results:
        if alive:
            lines.append(f"- `{m.file}:{m.line}`: `{m.before}` became `{m.after}`")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--areas", default=",".join(AREAS), help="separated by commas")
    parser.add_argument("--count", type=int, default=20, help="mutants of each area")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, help="file name without ending; default: print only")
    options = parser.parse_args()
    here = Path(__file__).resolve().parents[1]
    results: list[tuple[str, Mutant, bool]] = []
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "tree"
        shutil.copytree(here, root, ignore=shutil.ignore_patterns(".git", "examples", "docs"))
        for name in ("examples", "docs"):
            (root / name).symlink_to(here / name)
        for area in options.areas.split(","):
            if not passes(root, AREAS[area]):
                raise SystemExit(f"The tests of '{area}' fail without any mutant; mend them first.")
            for mutant in mutants(root, area, options.count, options.seed):
                alive = survives(root, mutant, AREAS[area])
                results.append((area, mutant, alive))
                state = "SURVIVES" if alive else "noticed"
                print(
                    f"{area} {mutant.file}:{mutant.line} {mutant.before} -> {mutant.after}: {state}",
                    flush=True,
                )
    print(table(results))
    if options.out:
        options.out.with_suffix(".md").write_text(table(results), encoding="utf-8")


if __name__ == "__main__":
    main()
