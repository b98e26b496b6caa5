"""Which small errors do the tests miss? Change one operator or number at a time, and run them.

    python -m benchmarks.mutants [--areas head,training] [--count 20] [--minutes 15] [--seed 0]
    [--again LOG]

A mutant is one change of one line: + for -, * for /, < for <=, `and` for `or`, n + 1 for n, a sign
left out. `--count` of them are drawn for each area, a folder of omnivat/ (head, measure/gaps); its
tests, the folder of the same name in tests/unit/ and a few beside it, run against each in a copy of
the tree until one fails, slow tests last. A mutant that no test notices survives and is listed.
`--minutes` of processor time end the run early, after equally many mutants of each area. `--again
LOG`, the output of an earlier run, tries its survivors alone: after new tests, and only while the
area's code is the same.

torch, scipy and scikit-learn are imported once; the tests of each mutant run in a fork of that
process.
"""

import argparse
import ast
import copy
import os
import random
import re
import resource
import shutil
import sys
import tempfile
from importlib import import_module
from itertools import chain, zip_longest
from pathlib import Path
from typing import NamedTuple

import pytest

STATED = "tests/unit/documents/test_stated_values.py"
AREAS = "fractional,head,measure/gaps,training,maps/projection"
BESIDES = {
    "fractional": ("tests/properties/test_fractional.py",),
    "head": ("tests/unit/cli/test_profile_command.py",),
    "measure": ("tests/properties/test_gaps.py",),
    "measure/gaps": ("tests/properties/test_gaps.py",),
}
SHARED = (
    "torch",
    "scipy.stats",
    "scipy.ndimage",
    "scipy.optimize",
    "sklearn.linear_model",
    "PIL.Image",
)
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
LIMIT = 600  # processor seconds for the tests of one mutant; a test that hangs has noticed it


class Mutant(NamedTuple):
    """One change: where, the expression before and after, and its place in a walk of the file."""

    area: str
    file: str
    line: int
    before: str
    after: str
    place: int

    def __str__(self) -> str:
        return f"{self.area} {self.file}:{self.line} {self.before} -> {self.after}"


def mutants(root: Path, area: str, count: int | None, seed: int) -> list[Mutant]:
    """Return `count` mutants of an area's modules, drawn from all of them; None: all."""
    every = []
    for file in sorted((root / "omnivat" / area).rglob("*.py")):
        for index, node in enumerate(ast.walk(ast.parse(file.read_text(encoding="utf-8")))):
            changed = copy.deepcopy(node)
            if isinstance(changed, ast.expr) and _change(changed):
                where = str(file.relative_to(root)), node.lineno  # type: ignore[attr-defined]
                every.append(Mutant(area, *where, ast.unparse(node), ast.unparse(changed), index))
    return every if count is None else random.Random(seed).sample(every, min(count, len(every)))


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


def tests_of(area: str) -> tuple[str, ...]:
    """Return the tests of an area: files and folders."""
    return (STATED, f"tests/unit/{area}", *BESIDES.get(area, ()))


def survives(root: Path, mutant: Mutant) -> bool:
    """Return True if all tests of its area pass with the mutant in the copy at `root`."""
    file = root / mutant.file
    kept = file.read_text(encoding="utf-8")
    tree = ast.parse(kept)
    _change(list(ast.walk(tree))[mutant.place])
    file.write_text(ast.unparse(tree), encoding="utf-8")
    try:
        return all(passes(root, tests_of(mutant.area), which) for which in ("not slow", "slow"))
    finally:
        file.write_text(kept, encoding="utf-8")


def passes(root: Path, tests: tuple[str, ...], which: str) -> bool:
    """Run tests in the copy at `root`, in a fork, until one fails; return True if none does."""
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1] == 0
    try:
        resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))
        os.chdir(root)
        sys.path.insert(0, str(root))
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, 1)
        os.dup2(silence, 2)
        code = pytest.main(["-q", "-x", "-m", which, "-p", "no:cacheprovider", *tests])
        os._exit(0 if code in (0, pytest.ExitCode.NO_TESTS_COLLECTED) else 1)
    finally:
        os._exit(1)


def spent() -> float:
    """Return the processor seconds of all tests so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def table(results: list[tuple[Mutant, bool]]) -> str:
    """Return the report: a row for each area, and every survivor."""
    lines = ["# Mutants", "", "| area | mutants | noticed |", "| --- | --- | --- |"]
    for area in dict.fromkeys(mutant.area for mutant, _ in results):
        own = [alive for mutant, alive in results if mutant.area == area]
        lines.append(f"| {area} | {len(own)} | {len(own) - sum(own)} |")
    lines += ["", "Survivors:", ""]
    for m, alive in results:
        if alive:
            lines.append(f"- `{m.file}:{m.line}`: `{m.before}` became `{m.after}`")
    return "\n".join(lines) + "\n"


def survivors(log: Path, mutants: list[Mutant]) -> list[Mutant]:
    """Return those mutants that survived in the output of an earlier run; lines may have moved."""
    found = []
    for file, line, change in re.findall(r" (\S+):(\d+) (.+): SURVIVES", log.read_text("utf-8")):
        same = [m for m in mutants if (m.file, f"{m.before} -> {m.after}") == (file, change)]
        if same:
            found.append(min(same, key=lambda m: abs(m.line - int(line))))
    return found


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--areas", default=AREAS, help="separated by commas")
    parser.add_argument("--count", type=int, default=20, help="mutants of each area")
    parser.add_argument("--minutes", type=float, default=600.0, help="of processor time")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--again", type=Path, metavar="LOG", help="try its survivors alone")
    options = parser.parse_args()
    here = Path(__file__).resolve().parents[1]
    results: list[tuple[Mutant, bool]] = []
    os.environ["CI"] = "1"  # Hypothesis draws the same examples for each mutant
    for name in SHARED:
        import_module(name)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "tree"
        shutil.copytree(here, root, ignore=shutil.ignore_patterns(".git", "examples", "docs"))
        for name in ("examples", "docs"):
            (root / name).symlink_to(here / name)
        areas, again = options.areas.split(","), options.again
        for area in areas:
            if not passes(root, tests_of(area), "not slow"):
                raise SystemExit(f"The tests of '{area}' fail without any mutant; mend them first.")
        start = spent()
        drawn = [mutants(root, a, None if again else options.count, options.seed) for a in areas]
        if again:
            drawn = [survivors(again, every) for every in drawn]
        for mutant in filter(None, chain.from_iterable(zip_longest(*drawn))):
            if spent() - start > 60 * options.minutes:
                break
            results.append((mutant, survives(root, mutant)))
            print(f"{mutant}: {'SURVIVES' if results[-1][1] else 'noticed'}", flush=True)
    print(table(results))


if __name__ == "__main__":
    main()
