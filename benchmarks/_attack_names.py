"""Hostile names of domains, classes, folders and pictures in every output; visitors kept apart."""

import csv
from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from PIL import Image

SCRIPT = "<script>alert(1)</script>"
NAMES = (SCRIPT, "=1+2", '" onload="alert(1)', "../../up", "\u202eevil", "{{7*7}}")
LIVE = ("<script>alert", "<img src=x", 'onload="alert')  # what no page or picture may hold
Case = tuple[str, bool]


def hostile_set(file: Path) -> Path:
    """Write embeddings whose domains, classes, objects and pictures have hostile names."""
    from omnivat.data.store import ROW_NAMES, Embeddings, Header, save_embeddings

    random, count = np.random.default_rng(0), 72
    domain, label = np.arange(count) % len(NAMES), np.arange(count) // 6 % len(NAMES)
    header = Header(
        encoder=SCRIPT,
        weights_hash="0" * 16,
        preprocessing="=1",
        domains=NAMES,
        classes=NAMES[::-1],
        origin=SCRIPT,
    )
    rows = {name: [NAMES[k % len(NAMES)] + str(k) for k in range(count)] for name in ROW_NAMES}
    rows["split"] = [""] * count
    vis, tac = random.standard_normal((2, count, 16)).astype(np.float32)
    data = Embeddings(header=header, vis=vis, tac=tac, domain=domain, label=label, rows=rows)
    save_embeddings(file, data)
    return file


def outputs(folder: Path) -> Iterator[Case]:
    """Yield every page, picture and table that the commands make of hostile names."""
    file, out = hostile_set(folder / "in" / "set.safetensors"), folder / "out"
    raw = ("--embeddings", file, "--stage", "raw")
    pictures = folder / "in" / '<img src=x onerror="alert(1)">'
    pictures.mkdir()
    for name in ("=1+2_vis.png", "-x_vis.png", "\u202e_tac.png"):
        Image.new("RGB", (40, 40), 90).save(pictures / name)
    for words in (
        ("report", file, "--out", out / "report"),
        ("gaps", *raw, "--figure", out / "gaps.html"),
        ("gaps", *raw, "--figure", out / "gaps.svg"),
        ("project", *raw, "--out", out / "map.csv", "--figure", out / "map.html"),
        ("profile", file, "--domain", NAMES[3], "--out", out / "of-set.safetensors"),
        ("profile", pictures, "--domain", SCRIPT, "--out", out / "of-folder.safetensors"),
    ):
        status, said = run(words)
        yield f"{words[0]} of hostile names: {said[-200:]!r}", status == 0
    strangers = [one.name for one in folder.iterdir() if one.name not in ("in", "out")]
    yield f"files elsewhere: {strangers}", not strangers
    for one in sorted(out.rglob("*")):
        if one.suffix in (".html", ".svg"):
            text = one.read_text(encoding="utf-8")
            found = [part for part in LIVE if part in text.replace('\\"', "")]
            yield f"{found} in {one.name}", not found
        if one.suffix == ".svg":
            yield f"{one.name} is XML", ElementTree.fromstring(text).tag.endswith("svg")
        if one.suffix == ".csv":
            with one.open(newline="", encoding="utf-8-sig") as handle:
                cells = {cell for row in csv.reader(handle) for cell in row}
            bad = [cell for cell in cells if cell[:1] in tuple("=@\t\r")]
            yield f"formulas in {one.name}: {bad[:3]}", not bad


def run(words: tuple[Any, ...]) -> tuple[int, str]:
    """Run one command here; return its status and what it wrote to stderr."""
    from omnivat.cli import main

    said = StringIO()
    with redirect_stdout(StringIO()), redirect_stderr(said):
        return main([str(word) for word in words]), said.getvalue()


def apart(app: Callable[[], Any], resources: Any) -> Iterator[Case]:
    """Yield pictures, profiles and taught heads of one visitor, used by it and by another."""
    from starlette.testclient import TestClient

    shared = app()
    own, other = (TestClient(shared, "http://127.0.0.1", client=(f"10.0.1.{k}", 1)) for k in (1, 2))
    with BytesIO() as handle:
        Image.new("RGB", (64, 64), 120).save(handle, "PNG")
        picture = handle.getvalue()
    ref = own.post("/omnivat/image?name=x", content=picture).json()["ref"]
    profile = own.post("/omnivat/profile", json={"photos": [ref]}).json()["profile"]
    lessons = [{"vis": f"row:{k}", "tac": f"row:{k}", "label": "ab"[k % 2]} for k in (0, 1, 2, 3)]
    taught = own.post("/omnivat/taught", json={"lessons": lessons}).json()["taught"]
    address = f"/omnivat/live?modality=vis&taught={taught}"
    for who, client, status in (("own", own, 200), ("another visitor", other, 410)):
        pair = {"vis": ref, "tac": "row:0"}
        moved = {**pair, "vis": "row:1", "profile": profile}
        for what, got in (
            ("the picture", client.post("/omnivat/pair", json=pair)),
            ("the profile", client.post("/omnivat/save/sensor", json=moved)),
            ("the taught head", client.post(address, content=picture)),
        ):
            yield f"{what} by {who}: {got.status_code}", got.status_code == status
