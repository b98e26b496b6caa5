"""Does one hidden layer on [V; T], as one more term of the root, help a head? Evidence from the sources alone.

    python -m benchmarks.branch [--folds 0,1] [--out build/branch.jsonl]

Heads of the page's recipe are trained on three quarters of the objects of a source; the log loss and the share of errors
are those of the held-out objects, as they are and under twelve imitated sensors (`omnivat.selection`). No target is read.
With `--targets SET` the heads of seed 0 are trained on whole sources and scored on the other domains of that set.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import normalize

from benchmarks._ladder_methods import Pair, _of_head, _perceptron, _plan, _standard
from omnivat.cli.arguments import numbers
from omnivat.data.profile import profile_of
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.from_pairs import TrainingPlan
from omnivat.heads import default_embeddings
from omnivat.model import training
from omnivat.model.head import OmniVaT
from omnivat.model.settings import HeadSettings
from omnivat.protocol.records import append, lines
from omnivat.selection import evidence
from omnivat.stages import IMAGES
from omnivat.threads import pin_thread
from omnivat.train import Watch, loop

FORMAT = "omnivat-branch-1"
HIDDEN = 256  # as ERM-MLP


class Branched(OmniVaT):
    """A head whose root has one more term: a hidden layer on both standardised images."""

    def __init__(self, settings: HeadSettings) -> None:
        super().__init__(settings)
        inner = nn.Linear(2 * settings.input_width, HIDDEN), nn.GELU(), nn.Dropout(0.5)
        self.branch = nn.Sequential(*inner, nn.Linear(HIDDEN, settings.width))
        self.term: Tensor | None = None

    def note(self, given: dict[str, Tensor]) -> None:
        """Keep the term of these pairs for the pass that follows."""
        rows = torch.cat([2 * self._standardised(name, given[name]) for name in IMAGES], dim=-1)
        self.term = normalize(self.branch(rows), dim=-1)

    def forward(self, vis: Any, tac: Any, **more: Any) -> Any:
        self.note({"vis": vis, "tac": tac})
        return super().forward(vis, tac, **more)

    def training_pass(self, vis: Any, tac: Any, *given: Any, **more: Any) -> Any:
        self.note({"vis": vis, "tac": tac})
        return super().training_pass(vis, tac, *given, **more)

    def _mean(self, found: Tensor, root: Tensor, fold: bool) -> Tensor | None:
        return super()._mean(found, root if len(found) == 1 else root + self.term, fold)


_plain_output = training._output
training._output = lambda model, features, found, root, tokens: _plain_output(
    model, features, found, root + model.term if isinstance(model, Branched) else root, tokens
)


def trained(plan: TrainingPlan, kind: str) -> Any:
    """Return the probabilities (n, K) of pairs, in the plan's classes."""
    if kind == "erm":
        model, own = _perceptron(plan, plan.seed).eval(), profile_of(plan.pairs).channels

        def perceptron(pair: Pair) -> Any:
            with torch.inference_mode():
                return model(*(_standard(x, own[n]) for n, x in zip(IMAGES, pair, strict=True))).softmax(-1).numpy()

        return perceptron
    plain = loop.build_head

    def branched(settings: HeadSettings, *, seed: int) -> OmniVaT:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            return Branched(settings)

    loop.build_head = branched if kind == "branch" else plain
    head = loop.train_once(
        plan.pairs, plan.settings, plan.training, bank=plan.bank, seed=plan.seed, resume=None, watch=Watch()
    ).model
    loop.build_head = plain
    whole = _of_head(plan.embeddings, head.eval()).probabilities
    column = [plan.embeddings.header.classes.index(name) for name in plan.settings.classes]
    some = range(0, 100_000, 500)  # the term is that of the last pass

    def head_of(pair: Pair) -> Any:
        parts = [whole((pair[0][k : k + 500], pair[1][k : k + 500])) for k in some if k < len(pair[0])]
        return np.vstack(parts)[:, column]

    return head_of


def scores(shares: Any, label: Any) -> list[float]:
    """Return log loss and accuracy."""
    own = shares[np.arange(len(label)), label]
    return [float(-np.log(np.maximum(own, 1e-12)).mean()), float((shares.argmax(1) == label).mean())]


def held(embeddings: Embeddings, source: str, fold: int, kind: str) -> dict[str, list[float]]:
    """Return scores on each of the held-out sets of a fold."""
    plan = _plan(embeddings, source, fold, lang=kind != "erm")
    found = evidence(plan.pairs, fold)
    predict = trained(replace(plan, pairs=found.fit), kind)
    lookup = np.array(
        [plan.settings.classes.index(n) if n in plan.settings.classes else -1 for n in embeddings.header.classes]
    )
    return {name: scores(predict((rows.vis, rows.tac)), lookup[rows.label]) for name, rows in found.held.items()}


def away(embeddings: Embeddings, source: str, kind: str) -> dict[str, list[float]]:
    """Return scores on all pairs of every other domain."""
    plan = _plan(embeddings, source, 0, lang=kind != "erm")
    predict, names = trained(plan, kind), embeddings.header.classes
    lookup = np.array([plan.settings.classes.index(n) if n in plan.settings.classes else -1 for n in names])
    label, scored = lookup[embeddings.label], {}
    for index, name in enumerate(embeddings.header.domains):
        rows = np.flatnonzero((embeddings.domain == index) & (label >= 0))
        if name != source:
            scored[name] = scores(predict((embeddings.vis[rows], embeddings.tac[rows])), label[rows])
    return scored


def main() -> None:
    """Add the missing lines and print the means."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--folds", default="0", help="of the evidence")
    parser.add_argument("--targets", type=Path, help="score on the domains of this set instead")
    parser.add_argument("--kinds", default="plain,branch,erm")
    parser.add_argument("--out", type=Path, default=Path("build/branch.jsonl"), help="the records")
    options = parser.parse_args()
    pin_thread()
    embeddings = load_embeddings(options.targets or default_embeddings())
    have = {(r["source"], r["fold"], r["kind"]) for r in lines(options.out, FORMAT)}
    for fold in numbers(options.folds):
        for source in embeddings.header.domains:
            for kind in options.kinds.split(","):
                if (source, fold, kind) in have:
                    continue
                found = away(embeddings, source, kind) if options.targets else held(embeddings, source, fold, kind)
                append(options.out, {"format": FORMAT, "source": source, "fold": fold, "kind": kind, "scores": found})
                loss, right = np.mean(list(found.values()), axis=0)
                print(source, fold, kind, f"{loss:.3f} {100 * right:.1f}", flush=True)


if __name__ == "__main__":
    main()
