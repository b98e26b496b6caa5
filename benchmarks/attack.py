"""Attack the page and count the results: `python -m benchmarks.attack`.

Hostile images, heads, sets, requests (to the page, the API and MCP) and callers are sent to the
page's routes. A case passes if the status is below 500 within the time limit, an error is one
sentence, and no sentence contains a folder of the server. Failures are printed with their seed.
With --fuzz, every reader of files is fuzzed instead (`benchmarks/_fuzz.py`).
"""

import argparse
import json
import random
import sys
from base64 import b64encode
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

from app.shared.messages import UNEXPECTED
from benchmarks._attack_costly import decoded
from benchmarks._attack_files import heads, images, questions, sets, spoilt_tensors
from benchmarks._fuzz import report
from benchmarks._fuzz_readers import READERS

SLOW_S = 5.0  # seconds; a slower reply is a failure
TOOLS = ("about", "predict", "gaps")  # of the API; a report takes minutes
OUT = Path("docs/benchmarks/attack.json")


@dataclass(slots=True)
class Counts:
    """The results of one kind of attack."""

    held: int = 0
    statuses: Counter[int] = field(default_factory=Counter)
    slowest_s: float = 0.0
    fell: list[str] = field(default_factory=list)

    def take(self, response: Any, seconds: float, what: str) -> None:
        """Check one reply."""
        self.statuses[response.status_code] += 1
        self.slowest_s = max(self.slowest_s, seconds)
        problem = judged(response, seconds)
        if problem:
            self.fell.append(f"{what}: {problem}")
        else:
            self.held += 1


def judged(response: Any, seconds: float) -> str:
    """Return the fault of a reply; "" if it passes."""
    if response.status_code >= 500 and response.status_code != 503:
        return f"status {response.status_code}"
    if seconds > SLOW_S:
        return f"{seconds:.1f} s"
    try:
        if response.status_code >= 400:
            said = response.json()["error"]
        elif "ndjson" in response.headers.get("content-type", ""):  # the rest of a reply
            said = json.loads(response.text.splitlines()[-1]).get("problem", ".")
        else:
            return ""
        if said == UNEXPECTED:
            return "an error nobody thought of, after the first line"
        said = said["message"] if isinstance(said, dict) else said  # of JSON-RPC
    except (ValueError, KeyError, TypeError):
        return f"no sentence: {response.text[:80]!r}"
    if not said.endswith(".") or "\n" in said or "Traceback" in said:
        return f"no sentence: {said[:80]!r}"
    folders = [name for name in ("tmp", "home", "root", "work", "var") if f"/{name}/" in said]
    return f"a folder of the server: {said[:120]!r}" if folders else ""


def attack(client: Any, resources: Any, seed: int, count: int) -> dict[str, Counts]:
    """Send `count` hostile inputs of each kind; return the results."""
    from app.serving.routes import QUESTIONS

    kinds = ("images", "touches", "questions", "api", "heads", "sets", "profiles", "callers")
    found = {name: Counts() for name in kinds}

    def send(kind: str, what: str, address: str, **more: Any) -> Any:
        began = perf_counter()
        response = client.post(address, **more)
        found[kind].take(response, perf_counter() - began, f"seed {seed}, {what}")
        return response

    client.post("/omnivat/pair", json={"vis": "row:0"})  # the head and the set are loaded
    client.post("/omnivat/image", content=next(iter(images(random.Random(0), 1))))  # the encoder
    for k, content in enumerate(images(random.Random(seed), count)):
        send("images", f"image {k}", "/omnivat/image?name=x", content=content)
        chosen = random.Random(f"{seed} {k}")
        name = chosen.choice(("file:0", "file:1", "file:", "file:٣", "unread:x", "image:x:AAAA"))
        place = chosen.choice((name, [name], {"vis": name}, [[name]]))
        question: dict[str, Any] = {
            chosen.choice(("vis", "tac", "pairs", "lessons", "touches")): place,
            "modality": chosen.choice(("vis", "both", 1)),
            "as": chosen.choice(("figures", "npy", "ply", "", None)),
            "with": chosen.choice(
                (["familiar", "journey"], ["rivals", "moving"], "x", [[1]], None)
            ),
            "theme": "%00",
        }
        text = json.dumps(question | {"names": chosen.choice((None, "x", [1], ["a"]))}).encode()
        cut = chosen.choice((len(text), len(text) - 1, 0))
        route = chosen.choice(("pair", chosen.choice(list(QUESTIONS))))
        way = f"{route}?sizes={cut},{len(text) + len(content) - cut}"
        send(
            "touches", f"image {k}, {question} to {way}", f"/omnivat/{way}", content=text + content
        )
        if len(content) < 2_000_000:
            address = "data:image/png;base64," + b64encode(content).decode()
            send("api", f"image {k}", "/omnivat/api/predict", json={"vis": address})
    for k, question in enumerate(questions(random.Random(seed), count)):
        name = list(QUESTIONS)[k % len(QUESTIONS)]
        content = json.dumps(question).encode()
        send("questions", f"{name} {question!r:.200}", f"/omnivat/{name}", content=content)
        tool = TOOLS[k % len(TOOLS)]
        call = {"jsonrpc": "2.0", "method": "tools/call", "id": question.get("k", k)}
        call["params"] = {"name": tool, "arguments": question}
        send("api", f"{tool} {question!r:.200}", f"/omnivat/api/{tool}", content=content)
        send("api", f"mcp {call!r:.200}", "/omnivat/mcp", content=json.dumps(call).encode())
    where = resources.where
    for kind, files in (
        ("heads", heads(where.head, random.Random(seed), count)),
        ("sets", sets(where.embeddings, random.Random(seed), count)),
    ):
        for k, parts in enumerate(files):
            loaded = load(client, parts)
            response = send(kind, f"{kind} {k}", "/omnivat/load", json={"parts": loaded})
            if response.status_code == 200:
                used(client, response.json()["set"], found[kind], f"seed {seed}, {kind} {k}")
    chance = random.Random(seed)
    for k in range(count):
        content = spoilt_tensors((where.head / "profile.safetensors").read_bytes(), chance)
        response = send("profiles", f"profile {k}", "/omnivat/sensor", content=content)
        if response.status_code == 200:
            question = {"vis": "row:1", "profile": response.json()["profile"]}
            send("profiles", f"profile {k}, then a pair", "/omnivat/pair", json=question)
    for k, headers in enumerate(callers(random.Random(seed), count)):
        response = send("callers", f"caller {k}", "/omnivat/pair", json={}, headers=headers)
        if response.status_code != 403:
            found["callers"].fell.append(f"served {headers}")
    return found


def load(client: Any, parts: dict[str, bytes]) -> dict[str, str]:
    """Upload the files of a head or set; return their names."""
    return {
        name: client.post(f"/omnivat/part?name={name}", content=content).json().get("part", "")
        for name, content in parts.items()
    }


def used(client: Any, name: str, counts: Counts, what: str) -> None:
    """Use an accepted head or set: its facts and one pair."""
    for address in ("about", "heads"):
        began = perf_counter()
        response = client.get(f"/omnivat/{address}?set={name}")
        counts.take(response, perf_counter() - began, f"{what}, then {address}")
    for address in ("pair", "tree"):
        began = perf_counter()
        question = {"vis": "row:1", "tac": "row:1"}
        response = client.post(f"/omnivat/{address}?set={name}", json=question)
        counts.take(response, perf_counter() - began, f"{what}, then {address}")


def callers(chance: random.Random, count: int) -> list[dict[str, str]]:
    """Return headers of other sites and of foreign host names."""
    sites = ["https://evil.example", "null", "http://127.0.0.1.evil.example", "file://", "http://["]
    names = ["evil.example", "127.0.0.1.evil.example", "10.0.0.1", "localhost.evil.example", "x@y"]
    made = []
    for _ in range(count):
        way = chance.randrange(3)
        made.append(
            {"host": chance.choice(names)}
            if way == 0
            else {"origin": chance.choice(sites)}
            if way == 1
            else {"sec-fetch-site": chance.choice(["cross-site", "same-site"])}
        )
    return made


def main(arguments: list[str] | None = None) -> int:
    """Run the attack and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=200, help="hostile things of each kind")
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--fuzz", action="store_true", help="damage files of every reader instead")
    parser.add_argument("--reader", choices=READERS, help="with --fuzz: this one alone")
    parser.add_argument("--minutes", type=float, default=2, help="with --fuzz: of each reader")
    parser.add_argument("--keep", type=Path, help="with --fuzz: folder for the files of findings")
    chosen = parser.parse_args(arguments)
    if chosen.fuzz:
        names = [chosen.reader] if chosen.reader else list(READERS)
        return report(names, chosen.seed, chosen.minutes, chosen.keep)
    from starlette.applications import Starlette
    from starlette.middleware import Middleware
    from starlette.testclient import TestClient

    from app.serving.guard import Guard, rules
    from app.serving.routes import routes
    from app.shared.places import places
    from app.shared.resources import Resources
    from app.shared.visitor_sets import VisitorSets
    from omnivat.kit.files import write_json

    resources = Resources(places())

    guarded = [Middleware(Guard, rules=rules("127.0.0.1"))]
    application = Starlette(routes=routes(VisitorSets(resources), api=True), middleware=guarded)
    with TestClient(application, base_url="http://127.0.0.1") as client:
        found = attack(client, resources, chosen.seed, chosen.count)
    found["costly"] = costly = Counts()
    for what, held in decoded(resources.shared.decoder):
        costly.held += held
        costly.fell += [] if held else [what]
    resources.shared.close()
    record: dict[str, dict[str, Any]] = {
        name: {
            "held": counts.held,
            "fell": counts.fell,
            "statuses": {str(status): n for status, n in sorted(counts.statuses.items())},
            "slowest_s": round(counts.slowest_s, 2),
        }
        for name, counts in found.items()
    }
    write_json(chosen.out, {"seed": chosen.seed, "count": chosen.count, "attacks": record})
    for name, part in record.items():
        print(f"{name:10} held {part['held']:5}  fell {len(part['fell'])}  {part['statuses']}")
        for line in part["fell"][:10]:
            print("   ", line)
    return int(any(counts.fell for counts in found.values()))


if __name__ == "__main__":
    sys.exit(main())
