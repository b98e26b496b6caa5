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
from omnivat.cli.arguments import download, passed, progress_bar, shared, whole
from omnivat.kit.errors import DataError
from omnivat.kit.files import write_json, write_text

if TYPE_CHECKING:
    from omnivat.data.paper_sets import PaperSets
    from omnivat.encoders import Encoder

STATE, EMBEDDINGS, LANG = "reproduce.json", "embeddings.safetensors", "lang.safetensors"
ENCODING = ("weights", "device", "download")  # options of an encoder
TIMED = 8  # pairs for timing the encoder


def add(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--data", type=Path, required=True, help="folder of the data sets")
    parser.add_argument(
        "--encoder", default="", metavar="NAME", help="clip with --weights, else clip-vit-b16"
    )
    parser.add_argument("--methods", default="", metavar="a,b,c", help="of the comparison")
    parser.add_argument("--no-ablations", action="store_true", help="skip the ablations")
    parser.add_argument("--styles", type=whole(1), default=80, help="styles of PromptStyler")
    parser.add_argument("--steps", type=whole(1), default=100, help="steps for each style")
    shared(
        parser, "seeds", "jobs", "only", "device", out="output folder", set="a setting of the head"
    )
    shared(parser, "workers", weights="checkpoint of CLIP, of any layout and size")
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
    _run("protocol", protocol, _shared(options, bank) + _named("--methods", options.methods))
    if not options.no_ablations:
        _run("ablate", ablate, _shared(options, bank, "ablations") + _named("--only", options.only))
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
    given = ["--encoder", name, "--out", str(file), "--method", "promptstyler"]
    given += ["--styles", str(options.styles), "--steps", str(options.steps)]
    if options.weights:
        given += ["--weights", str(options.weights)]
    _run("prompts", prompts, [*given, "--device", options.device])
    return file


def _shared(options: argparse.Namespace, bank: Path | None, folder: str = "protocol") -> list[str]:
    given = ["--embeddings", str(options.out / EMBEDDINGS), "--out", str(options.out / folder)]
    given += ["--seeds", options.seeds, "--jobs", str(options.jobs), "--device", options.device]
    settings = [*options.set, *(() if bank else ("lang=false",))]
    given += [part for text in settings for part in ("--set", text)]
    return [*given, "--lang", str(bank)] if bank else given


def _named(option: str, value: str) -> list[str]:
    return [option, value] if value else []


def _run(command: str, module: Any, arguments: list[str]) -> None:
    """Print and run another command."""
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
