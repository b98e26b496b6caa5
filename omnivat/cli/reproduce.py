"""Reproduce the paper's tables: read its data sets, embed them, run everything, print both figures.

python -m omnivat reproduce --data ROOT --weights FILE --out DIR

Every step resumes. docs/reproduce.md lists the data sets, their sources and sizes.
"""

import argparse
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from omnivat.cli import ablate, prompts, protocol
from omnivat.cli.arguments import (
    count,
    declare,
    download,
    flag,
    list_of,
    passed,
    path,
    progress_bar,
    text,
)
from omnivat.kit.errors import DataError
from omnivat.kit.files import write_json, write_text

if TYPE_CHECKING:
    from omnivat.data.paper_sets import PaperSets
    from omnivat.encoders import Encoder

STATE, EMBEDDINGS, LANG = "reproduce.json", "embeddings.safetensors", "lang.safetensors"
ENCODING = ("weights", "device", "download")  # options of an encoder
TIMED = 8  # pairs for timing the encoder


def add(parser: argparse.ArgumentParser) -> None:
    declare(
        parser,
        "seeds",
        "jobs",
        "only",
        "device",
        "workers",
        data=path("folder of the data sets", required=True),
        encoder=text("clip with --weights, else clip-vit-b16", "NAME"),
        methods=list_of("of the comparison", "a,b,c"),
        no_ablations=flag("skip the ablations"),
        styles=count("styles of PromptStyler", default=80),
        steps=count("steps for each style", default=100),
        out="output folder",
        set="a setting of the head",
        weights="checkpoint of CLIP, of any size",
    )
    download(parser)


def run(options: argparse.Namespace) -> None:
    """Run every unfinished step; write the tables."""
    from omnivat.data.pairs import summary_table
    from omnivat.data.paper_sets import read_paper_sets
    from omnivat.encoders import load_encoder
    from omnivat.study.protocol import records
    from omnivat.study.reports.reproduced import cost_report, margins_report

    options.out.mkdir(parents=True, exist_ok=True)
    name = options.encoder or ("clip" if options.weights else "clip-vit-b16")
    sets = read_paper_sets(options.data)
    lines = [summary_table(part) for part in sets.parts.values()]
    if sets.missing:
        lines.append(f"Not found: {', '.join(sets.missing)}; their settings are skipped.")
    text = "\n\n".join(lines)
    write_text(options.out / "data.txt", text + "\n")
    print(text)
    encoder = load_encoder(name, **passed(options, *ENCODING))
    _embed(sets, name, encoder, options)
    bank = _lang(name, encoder, options)
    shared = passed(options, "seeds", "jobs", "device") | {
        "embeddings": options.out / EMBEDDINGS,
        "set": [*options.set, *(() if bank else ("lang=false",))],
        "lang": bank,
    }
    _run("protocol", protocol, **shared, out=options.out / "protocol", methods=options.methods)
    if not options.no_ablations:
        _run("ablate", ablate, **shared, out=options.out / "ablations", only=options.only)
    found = records.read(options.out / "protocol" / protocol.RUNS)
    write_text(options.out / "margins.md", margins_report(found))
    write_text(options.out / "cost.md", cost_report(found, _measured(sets, encoder)))
    print(
        f"Tables written to {options.out}: protocol/report.md, margins.md, cost.md"
        + ("" if options.no_ablations else ", ablations/")
    )


def _embed(sets: "PaperSets", name: str, encoder: "Encoder", options: argparse.Namespace) -> None:
    """Embed all pairs with the dots of gels, as the paper has them, unless the file has the same
    pairs and encoder.
    """
    from omnivat.encoders.embed import embed_pairs
    from omnivat.kit.schema import read_object

    made_by = [encoder.name, encoder.weights_hash, encoder.precision, encoder.preprocessing]
    state = {"pairs": sets.fingerprint, "encoder": made_by}
    file = options.out / EMBEDDINGS
    with suppress(DataError, OSError):
        if file.is_file() and read_object(options.out / STATE) == state:
            print(f"{file} has these pairs and this encoder; kept")
            return
    with progress_bar(f"embed with {name}") as show:
        report = embed_pairs(
            sets.pairs,
            name,
            file,
            **passed(options, *ENCODING, "workers"),
            dots="keep",
            on_step=show,
        )
    write_json(options.out / STATE, state)
    print(f"{report.embedded} pairs embedded, {len(report.skipped)} skipped")


def _lang(name: str, encoder: "Encoder", options: argparse.Namespace) -> Path | None:
    """Return the LANG bank of the checkpoint's text tower; make it if needed."""
    from omnivat.encoders.lang.bank import load_bank

    tower = getattr(encoder, "text_hash", "")
    if not tower:
        print(
            "The checkpoint has no text tower; heads train without LANG, and text methods are"
            " skipped"
        )
        return None
    file: Path = options.out / LANG
    if file.is_file() and load_bank(file).text_hash == tower:
        print(f"{file} belongs to this checkpoint; kept")
        return file
    how = passed(options, "styles", "steps", "weights", "device")
    _run("prompts", prompts, encoder=name, out=file, method="promptstyler", **how)
    return file


def _run(command: str, module: Any, **options: Any) -> None:
    """Print and run another command; an option without a value is left out."""
    arguments = []
    for name, values in options.items():
        for value in values if isinstance(values, list) else [values]:
            words = ",".join(map(str, value)) if isinstance(value, tuple) else str(value or "")
            arguments += [f"--{name}", words] if words else []
    print(f"\n$ omnivat {command} {' '.join(arguments)}", flush=True)
    parser = argparse.ArgumentParser(prog=f"omnivat {command}")
    module.add(parser)
    module.run(parser.parse_args(arguments))


def _measured(sets: "PaperSets", encoder: "Encoder") -> dict[str, Any]:
    """Return the encoder's time for a pair, and the GPU memory if there is a GPU."""
    import platform

    import torch

    from omnivat.encoders.cache import embed_pair

    pairs = sets.pairs.pairs[:TIMED]
    embed_pair(encoder, pairs[0].vis, pairs[0].tac)  # the first call also warms up
    began = time.perf_counter()
    for pair in pairs:
        embed_pair(encoder, pair.vis, pair.tac, tac_crop=pair.tac_crop)
    seconds = (time.perf_counter() - began) / len(pairs)
    gpu = torch.cuda.is_available() and torch.cuda.max_memory_allocated() > 0
    return {
        "encoder, s a pair": seconds,
        "memory, MB": torch.cuda.max_memory_allocated() / 2**20 if gpu else None,
        "machine": torch.cuda.get_device_name() if gpu else platform.processor() or "one CPU",
    }
