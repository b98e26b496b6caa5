"""Compare the page without a server with `predict`: the same pairs, in a real Chromium.

    python -m benchmarks.site [--pairs 300] [--runtime FOLDER] [--out docs/benchmarks/site]
    python -m benchmarks.site --page FOLDER

A quarter of the pairs are the example pictures as files, a quarter are parts cut from them, and
half are pairs of the shipped set; each has three readings. Then pictures of kinds that decoders
treat differently. `--page` opens a folder that `omnivat export --site` wrote behind a line of 20
Mbit/s.
"""

import argparse
import base64
import functools
import http.server
import json
import shutil
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, BinaryIO

import numpy as np
import torch
from PIL import Image

from app.shared.components import WEB
from app.shared.decoder import Decoder
from app.shared.places import places
from app.shared.resources import Resources
from app.site.models import write_models
from benchmarks._attack_costly import encoded
from benchmarks._browser import chromium
from omnivat.encoders.base import for_modality
from omnivat.head.predict import predict_embeddings
from omnivat.kit.errors import OmniVatError
from omnivat.kit.files import write_json, write_text

PAGE = '<!doctype html><meta charset="utf-8"><title>models</title><link rel="icon" href="data:,">'
ASK = """async ([path, question, file]) => {
  const { respond } = await import('./web/site/local.js');
  const bytes = (text) => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
  const began = performance.now();
  const all = [JSON.stringify(question), ...(file ? [bytes(file)] : [])];
  const parts = all.map((one) => new Blob([one]));
  const query = new URLSearchParams(file ? { sizes: parts.map(({ size }) => size) } : {});
  const body = file ? new Blob(parts) : JSON.stringify(question);
  const response = await respond({ set: 'sensors', path, query, models, body });
  return [response.status, await response.json(), performance.now() - began];
}"""
WANTED = 0.005
MBIT, DELAY_S = 20, 0.02  # of the slow line
WAITS = (
    ("", "first_chapter_s", ".explore.ready"),
    ("?view=pair", "first_prediction_s", ".pair .reading .said"),
)
TOLD = """globalThis.told = 0; setInterval(() => {
  const text = document.querySelector('.on-its-way:not([hidden])')?.textContent ?? '';
  if (text.includes('the encoder')) told = performance.now();
}, 20)"""


class Site:
    """A folder of scripts and models alone, served as it is, and a page of it in a browser."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.fetched: list[str] = []  # addresses, where the browser tells them

    def outside(self) -> list[str]:
        """Return what was fetched from other hosts."""
        return [
            address
            for address in self.fetched
            if address.startswith("http") and "//localhost" not in address
        ]

    def ask(self, path: str, question: Any, file: bytes = b"") -> tuple[int, Any, float]:
        """Return status, reply and milliseconds of one request, with a picture after it."""
        sent = [path, question, base64.b64encode(file).decode()]
        status, reply, ms = self.page.evaluate(ASK, sent)
        return status, reply, ms

    def read(self, content: bytes) -> dict[str, Any]:
        """Return what the page reads in a photo, and its prediction; or the `problem`."""
        _, reply, _ = self.ask("pair", {"vis": "file:0", "names": ["the image"]}, content)
        return dict(reply)


class Line:
    """A connection to the world that all requests share: bytes are handed out no faster than
    `rate` a second.
    """

    PIECE = 16384

    def __init__(self, rate: float, delay: float = 0.0) -> None:
        self.rate, self.delay = rate, delay
        self.free, self.lock = time.monotonic(), threading.Lock()

    def send(self, source: BinaryIO, to: BinaryIO) -> None:
        """Copy a file to a visitor, at this line's rate."""
        time.sleep(self.delay)
        while piece := source.read(self.PIECE):
            with self.lock:
                self.free = max(self.free, time.monotonic()) + len(piece) / self.rate
                wait = self.free - time.monotonic()
            time.sleep(max(0.0, wait))
            to.write(piece)


@contextmanager
def served(folder: Path, line: Line | None = None) -> Iterator[str]:
    """Yield the address of a plain file server of `folder`, at the rate of `line` if one is
    given.
    """

    class Quiet(http.server.SimpleHTTPRequestHandler):
        protocol_version = "HTTP/1.1" if line else "HTTP/1.0"
        extensions_map = {  # noqa: RUF012
            **http.server.SimpleHTTPRequestHandler.extensions_map,
            ".mjs": "text/javascript",
        }

        def copyfile(self, source: Any, outputfile: Any) -> None:
            """Send a file."""
            (line.send if line else shutil.copyfileobj)(source, outputfile)

        def log_message(self, *_: Any) -> None:
            """Stay silent."""

    handler = functools.partial(Quiet, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("localhost", 0), handler)
    server.daemon_threads = True
    server.handle_error = lambda *_: None  # type: ignore[method-assign]  # a browser that left
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://localhost:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()


def make(resources: Resources, folder: Path, runtime: Path | None) -> None:
    """Write the models, the scripts that use them, and an empty page."""
    models = write_models({"sensors": resources}, folder, runtime)
    shutil.copytree(WEB, folder / "web")
    write_text(folder / "index.html", f"{PAGE}<script>const models = '{models}/';</script>")


@contextmanager
def opened(folder: Path) -> Iterator[Site]:
    """Yield the site in a browser."""
    with served(folder) as address, chromium() as browser:
        site = Site(browser.new_page())
        site.page.on("request", lambda request: site.fetched.append(request.url))
        site.page.goto(address)
        yield site


def own_pairs(resources: Resources, count: int) -> Iterator[dict[str, bytes]]:
    """Yield pairs of files: the examples as they are, then parts cut from them."""
    examples = list(resources.examples().values())
    random = np.random.default_rng(0)
    for number in range(count):
        files = examples[number % len(examples)]
        if number < len(examples):
            yield {name: file.read_bytes() for name, file in files.items()}
            continue
        pair = {}
        for name, file in files.items():
            with Image.open(file) as image:
                wide, high = (int(side * random.uniform(0.4, 0.9)) for side in image.size)
                left = int(random.integers(image.width - wide + 1))
                top = int(random.integers(image.height - high + 1))
                pair[name] = encoded(
                    image.convert("RGB").crop((left, top, left + wide, top + high)), "PNG"
                )
        yield pair


def expected(resources: Resources, pair: Mapping[str, torch.Tensor]) -> dict[str, Any]:
    """Return the readings of `predict` for one pair of embeddings."""
    (found,) = predict_embeddings(resources.head(), pair["vis"], pair["tac"])
    return {"fused": found["probabilities"], **found["modalities"]}


def embedded(resources: Resources, decoder: Decoder, content: bytes, modality: str) -> torch.Tensor:
    """Return the embedding (1, width) of a file as VIS or TAC, as the server makes it."""
    encoder = for_modality(resources.encoder(), modality)
    return encoder.embed(encoder.preprocess(decoder.read(content, "a").image)[None])


def compared(
    computed: Mapping[str, Any], classes: list[str], wanted: Mapping[str, Any]
) -> tuple[float, int]:
    """Return the largest difference of a probability, and the number of changed classes."""
    gaps, changed = [], 0
    for name, shares in wanted.items():
        ours, theirs = np.array(computed[name]), np.array([shares[c] for c in classes])
        gaps.append(float(np.abs(ours - theirs).max()))
        changed += int(ours.argmax() != theirs.argmax())
    return max(gaps), changed


def pairs_compared(site: Site, resources: Resources, count: int) -> dict[str, Any]:
    """Return the largest differences from `predict` over `count` pairs, by kind of pair."""
    decoder, embeddings = Decoder(), resources.embeddings()
    classes = list(resources.head().settings.classes)
    gaps: dict[str, list[float]] = {"pictures": [], "pairs of the set": []}
    changed, ms = 0, []
    for files in own_pairs(resources, count // 2):
        pair = {
            name: embedded(resources, decoder, content, name) for name, content in files.items()
        }
        refs = {name: site.read(content)["pictures"][0]["ref"] for name, content in files.items()}
        _, reply, _ = site.ask("pair", refs)
        gap, more = compared(reply["exact"]["readings"], classes, expected(resources, pair))
        gaps["pictures"].append(gap)
        changed += more
    rows = np.linspace(0, len(embeddings) - 1, count - count // 2).astype(int).tolist()
    for row in rows:
        pair = {
            n: torch.from_numpy(getattr(embeddings, n)[row : row + 1].copy())
            for n in ("vis", "tac")
        }
        _, reply, spent = site.ask("pair", {"vis": f"row:{row}", "tac": f"row:{row}"})
        gap, more = compared(reply["exact"]["readings"], classes, expected(resources, pair))
        gaps["pairs of the set"].append(gap)
        changed += more
        ms.append(spent)
    decoder.close()
    return {
        "pairs": {name: len(found) for name, found in gaps.items()},
        "readings": 3 * count,
        "largest_difference": {name: max(found) for name, found in gaps.items()},
        "changed_classes": changed,
        "pair_ms": float(np.median(ms)),
    }


def odd_pictures(resources: Resources) -> dict[str, bytes]:
    """Return files of kinds that decoders treat differently."""
    with Image.open(next(iter(resources.examples().values()))["vis"]) as file:
        base = file.convert("RGB").resize((640, 480), Image.Resampling.BICUBIC)
    turned = {}
    for turn in (3, 6, 7):
        exif = Image.Exif()
        exif[274] = turn
        turned[f"JPEG, orientation {turn}"] = encoded(base, "JPEG", quality=95, exif=exif)
        turned[f"PNG, orientation {turn}"] = encoded(base, "PNG", exif=exif)
        turned[f"WebP, orientation {turn}"] = encoded(base, "WEBP", lossless=True, exif=exif)
    ramp = Image.linear_gradient("L").resize(base.size)
    alpha = base.copy()
    alpha.putalpha(ramp)
    grey = np.asarray(base.convert("L")).astype(np.uint16) * 256 + 77
    large = base.resize((5472, 3648), Image.Resampling.BICUBIC)
    whole = encoded(base, "PNG")
    return {
        **turned,
        "JPEG, CMYK": encoded(base.convert("CMYK"), "JPEG", quality=95),
        "JPEG, grey": encoded(base.convert("L"), "JPEG", quality=95),
        "JPEG, progressive": encoded(base, "JPEG", quality=95, progressive=True),
        "PNG, 16 bit": encoded(Image.fromarray(grey), "PNG"),
        "PNG, palette": encoded(base.quantize(64), "PNG"),
        "PNG, alpha": encoded(alpha, "PNG"),
        "WebP, lossy": encoded(base, "WEBP", quality=90),
        "GIF": encoded(base.quantize(128), "GIF"),
        "BMP": encoded(base, "BMP"),
        "JPEG, 20 megapixels": encoded(large, "JPEG", quality=90),
        "PNG, 1 pixel wide": encoded(base.resize((1, 400)), "PNG"),
        "JPEG, cut short": encoded(base, "JPEG", quality=95)[:9000],
        "PNG, cut short": whole[: len(whole) // 2],
        "PNG, a damaged piece": whole[:3000] + bytes(40) + whole[3040:],
        "text": b"this is no picture",
        "empty": b"",
    }


def odd_compared(site: Site, resources: Resources) -> dict[str, Any]:
    """Return, for each odd file, the difference from `predict`, or both refusals."""
    decoder = Decoder()
    classes = list(resources.head().settings.classes)
    found: dict[str, Any] = {}
    for name, content in odd_pictures(resources).items():
        reply = site.read(content)
        try:
            row = embedded(resources, decoder, content, "vis")
        except OmniVatError as error:
            found[name] = {"server": str(error), "browser": reply.get("problem", "taken")}
            continue
        if "problem" in reply:
            found[name] = {"server": "taken", "browser": reply["problem"]}
            continue
        (wanted,) = predict_embeddings(resources.head(), row, None)
        gap, changed = compared(
            reply["exact"]["readings"], classes, {"vis": wanted["probabilities"]}
        )
        found[name] = {"difference": gap, "changed": changed}
    decoder.close()
    return found


def over_line(folder: Path) -> dict[str, float]:
    """Return the seconds until a new visitor at 20 Mbit/s has a chapter, a prediction, the
    encoder.
    """
    found = {}
    with served(folder, Line(MBIT * 1e6 / 8, DELAY_S)) as address, chromium() as browser:
        for query, name, selector in WAITS:
            page = browser.new_context().new_page()
            page.set_default_timeout(300_000)
            page.add_init_script(TOLD)
            began = time.monotonic()
            page.goto(address + query, wait_until="commit")
            page.wait_for_selector(selector)
            found[name] = time.monotonic() - began
            if query:
                page.wait_for_selector(".pair .on-map canvas")
                found["encoder_there_s"] = page.evaluate("told") / 1000
            page.context.close()
    return found


def main() -> None:
    """Make the site, open it, compare, and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pairs", type=int, default=300)
    parser.add_argument(
        "--page", type=Path, help="a folder that export --site wrote: its waits alone"
    )
    parser.add_argument("--runtime", type=Path, help="folder of onnxruntime-web")
    parser.add_argument("--out", type=Path, help="write the figures here, as JSON")
    options = parser.parse_args()
    record: dict[str, Any]
    if options.page:
        record = {f"at_{MBIT}_mbit_per_s": over_line(options.page)}
    else:
        resources = Resources(places())
        with TemporaryDirectory(prefix="omnivat-site-") as place:
            make(resources, Path(place), options.runtime)
            with opened(Path(place)) as site:
                record = pairs_compared(site, resources, options.pairs)
                record["odd_pictures"] = odd_compared(site, resources)
                record["other_hosts"] = site.outside()
    print(json.dumps(record, indent=2, ensure_ascii=False))
    if options.out:
        write_json(options.out.with_suffix(".json"), record)
    if "pairs" in record and (
        record["changed_classes"] or max(record["largest_difference"].values()) >= WANTED
    ):
        raise SystemExit("The browser's predictions differ from those of `predict`.")


if __name__ == "__main__":
    main()
