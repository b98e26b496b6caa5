"""Fuzz the readers of other people's files, guided by the lines that a case reaches.

A case is a good file with some damage. It is read in a process with limits on memory and time.
A case that reaches a line of the project for the first time is damaged further. The result of a
reader is a value or one sentence of the project; anything else is a finding, and is read once more
untraced, with the readers' own limited processes, before it counts.
"""

import shutil
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from hashlib import blake2b
from importlib import import_module
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from traceback import extract_tb
from types import CodeType, FrameType
from typing import Any

from benchmarks._fuzz_mutations import Case, mutated
from benchmarks._fuzz_readers import Reader
from benchmarks._markdown import table
from omnivat.kit.errors import DataError, OmniVatError
from omnivat.kit.limited import Limited

MEMORY, SECONDS, WAIT = 4_000_000_000, 15, 300.0  # of the process; a case may take less:
MOST_MB, MOST_S = 500, 10.0
TABLE, OVER = "benchmarks._fuzz_readers:READERS", "over the limits"
PROJECT = str(Path(__file__).parents[1] / "omnivat")
Lines = set[tuple[CodeType, int]]
_here: dict[str, Any] = {}  # what a process keeps between cases


@dataclass(slots=True)
class Found:
    """What the cases of one reader gave."""

    reached: set[str] = field(default_factory=set)
    kept: int = 0  # cases that reached a new line
    results: Counter[tuple[str, str]] = field(default_factory=Counter)  # of mutation and outcome
    most_mb: float = 0.0
    most_s: float = 0.0
    findings: dict[str, tuple[str, Case]] = field(default_factory=dict)  # by their kind
    raw: Counter[str] = field(default_factory=Counter)  # of the same kinds

    @property
    def cases(self) -> int:
        """How many cases were read."""
        return sum(self.results.values())


def fuzz(
    name: str, seed: int, more: Callable[[int], bool], process: Limited, table: str = TABLE
) -> Found:
    """Read cases of one reader while `more` of their number holds; return what they gave.

    table  "module:NAME" of the readers
    """
    chance, found = Random(f"{seed} {name}"), Found()
    corpus = seeds_of(_named(table)[name])

    def told_of(case: Case, *, traced: bool) -> dict[str, Any]:
        return _read(process, case, table=table, reader=name, traced=traced)

    fresh: list[Case] = []
    for number, case in enumerate(corpus):
        outcome = told_of(case, traced=True)
        if outcome["kind"] != "result":
            raise ValueError(f"good case {number} of {name} is not read: {outcome}")
        found.reached.update(outcome["lines"])
    while more(found.cases):
        base = chance.choice(fresh if fresh and chance.random() < 0.5 else corpus)
        ways = set()
        for _ in range(chance.choice((1, 1, 1, 2, 4))):
            way, base = mutated(base, chance.choice(corpus), chance)
            ways.add(way)
        way = ways.pop() if len(ways) == 1 else "several"
        outcome = told_of(base, traced=True)
        if (new := {*outcome["lines"]} - found.reached) or _bad(outcome):
            outcome = told_of(base, traced=False) if _bad(outcome) else outcome
            found.reached |= new
            found.kept += bool(new)
            fresh += [base] if new else []
        if why := _bad(outcome):
            kind = f"{why}: {outcome['where']}"
            found.findings.setdefault(kind, (outcome["text"], base))
            found.raw[kind] += 1
        found.results[way, "finding" if why else outcome["kind"]] += 1
        found.most_mb = max(found.most_mb, outcome["mb"])
        found.most_s = max(found.most_s, outcome["seconds"])
    return found


def seeds_of(reader: Reader) -> list[Case]:
    """Return a reader's good cases."""
    with TemporaryDirectory() as folder:
        made = reader.seeds(Path(folder))
    return [case if isinstance(case, dict) else {name: case} for name, case in made.items()]


def _bad(outcome: dict[str, Any]) -> str:
    """Return why an outcome is a finding; "" for a result or one sentence within the limits."""
    if outcome["kind"] not in ("result", "sentence"):
        return str(outcome["kind"])
    over = [f"{outcome['mb']:.0f} MB"] * (outcome["mb"] > MOST_MB)
    return ", ".join(over + ["time"] * (outcome["seconds"] > MOST_S))


def _read(process: Limited, case: Case, **words: Any) -> dict[str, Any]:
    sizes = [[file, len(content)] for file, content in case.items()]
    began = time.monotonic()
    try:
        return process(b"".join(case.values()), OVER, sizes=sizes, **words)[0]
    except DataError as error:
        outcome = {"kind": "over", "text": str(error), "where": "", "lines": [], "mb": 0.0}
        return outcome | {"seconds": time.monotonic() - began}


def _named(name: str) -> Any:
    module, _, own = name.partition(":")
    return getattr(import_module(module), own)


def limited() -> Limited:
    """Return the process that reads cases."""
    return Limited(f"{__name__}:tried", memory=MEMORY, seconds=SECONDS, wait=WAIT)


def tried(
    content: bytes, *, table: str, reader: str, sizes: list[tuple[str, int]], traced: bool
) -> tuple[dict[str, Any], bytes]:
    """Read one case in this process; return its outcome and cost, and the lines reached."""
    if not _here:
        _here.update(home=TemporaryDirectory(prefix="omnivat-fuzz-"), each=Limited.each)
    setattr(Limited, "each", _in_this_process if traced else _here["each"])  # noqa: B010
    work = Path(_here["home"].name) / "work"
    shutil.rmtree(work, ignore_errors=True)
    at = 0
    for name, size in sizes:
        file = work / "case" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content[at : at + size])
        at += size
    before, lines = _peak_mb(), set[tuple[CodeType, int]]()
    began, cpu = time.monotonic(), time.process_time()
    outcome = _outcome(_named(table)[reader].read, work / "case", lines if traced else None)
    took = min(time.monotonic() - began, time.process_time() - cpu + 1)  # others use the machine
    outcome |= {"seconds": took, "mb": max(0.0, _peak_mb(reset=False) - before)}
    outside = {file.name for file in work.parent.iterdir()} - {"work"}
    if outside | ({file.name for file in work.iterdir()} - {"case", "out"}):
        outcome |= {"kind": "outside", "text": f"it left {outside} outside of its folder"}
    outcome["lines"] = [f"{Path(code.co_filename).name}:{line}" for code, line in lines]
    return outcome, b""


def _outcome(read: Callable[[Path], object], folder: Path, lines: Lines | None) -> dict[str, Any]:
    if lines is not None:
        sys.settrace(_tracer(lines))
    try:
        read(folder)
        return {"kind": "result", "text": "", "where": ""}
    except OmniVatError as error:
        sys.settrace(None)
        text = str(error)
        good = text.endswith((".", "?")) and len(text.splitlines()) == 1 and "Traceback" not in text
        return {"kind": "sentence" if good else "no sentence"} | _place(error, text)
    except BaseException as error:  # each of them is a finding
        sys.settrace(None)
        return {"kind": type(error).__name__} | _place(error, f"{error!r:.300}")
    finally:
        sys.settrace(None)


def _place(error: BaseException, text: str) -> dict[str, str]:
    """Return the text, and the last line of the project that raised it."""
    own = [frame for frame in extract_tb(error.__traceback__) if frame.filename.startswith(PROJECT)]
    last = own[-1] if own else None
    return {"text": text, "where": f"{Path(last.filename).name}:{last.lineno}" if last else ""}


def _tracer(lines: Lines) -> Callable[[FrameType, str, Any], Any]:
    def local(frame: FrameType, event: str, _: Any) -> Any:
        if event == "line":
            lines.add((frame.f_code, frame.f_lineno))
        return local

    def entered(frame: FrameType, _: str, __: Any) -> Any:
        return local if frame.f_code.co_filename.startswith(PROJECT) else None

    return entered


def _in_this_process(
    self: Limited, content: bytes, over: str, fault: object = None, **words: Any
) -> Any:
    """Do what a limited process does, where the lines can be seen."""
    result = _named(self.function)(content, **words)
    for value, found in [result] if isinstance(result, tuple) else result:
        if value is not None:
            yield value, found


def _peak_mb(*, reset: bool = True) -> float:
    """Return the largest memory of this process since the last reset; 0 where that is unknown."""
    try:
        if reset:
            Path("/proc/self/clear_refs").write_text("5")
        status = Path("/proc/self/status").read_text()
    except OSError:
        return 0.0
    return int(status.partition("VmHWM:")[2].split()[0]) / 1000


def report(names: Iterable[str], seed: int, minutes: float, keep: Path | None) -> int:
    """Fuzz each reader for some minutes; print the table, and keep the files of findings."""
    process, worst, everything = limited(), 0, {}
    for name in names:
        until = time.monotonic() + 60 * minutes
        everything[name] = found = fuzz(name, seed, partial(_before, until), process)
        for kind, (text, case) in found.findings.items():
            worst += 1
            print(f"{name}: {kind} ({found.raw[kind]} times): {text}")
            place = keep and keep / f"{name}-{blake2b(kind.encode(), digest_size=4).hexdigest()}"
            for file, content in (case if place else {}).items():
                target = place / file  # type: ignore[operator]
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
    process.close()
    print(table_of(everything))
    return int(worst > 0)


def _before(until: float, _: int) -> bool:
    return time.monotonic() < until


def table_of(everything: dict[str, Found]) -> str:
    """Return the table of readers and mutations, in Markdown: cases and findings by mutation."""
    ways = sorted({way for found in everything.values() for way, _ in found.results})
    head = ["reader", "cases", "read", "refused", "findings", "lines", "MB", "s", *ways]
    rows = []
    for name, found in everything.items():
        by: defaultdict[str, int] = defaultdict(int)
        for (way, kind), count in found.results.items():
            by[way] += count
            by[f"= {kind}"] += count
        outcome = [by["= result"], by["= sentence"], by["= finding"], len(found.reached)]
        costs = [f"{found.most_mb:.0f}", f"{found.most_s:.2f}"]
        rows.append([name, *map(str, (found.cases, *outcome)), *costs, *(str(by[w]) for w in ways)])
    return table(head, rows, "---")
