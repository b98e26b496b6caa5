"""The methods that `benchmarks.ladder` trains."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from torch.nn.functional import cross_entropy

from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import Channels, channels_of, moved, profile_of, standardised
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.kit.tables import load
from omnivat.study.baselines import BASELINES
from omnivat.study.baselines.contract import Source, seeded
from omnivat.study.baselines.erm_mlp import Perceptron
from omnivat.training import TrainSettings, Watch
from omnivat.training.batches import batches, labels_of
from omnivat.training.from_pairs import TrainingPlan, plan_training
from omnivat.training.loop import train_once
from omnivat.training.state import run_name

Array = NDArray[Any]
Pair = tuple[Array, Array]  # rows (n, W) of VIS and TAC in the source's raw space
Profiles = Mapping[str, Channels]
PAGE = {"noise": 4.0, "shift": 1.0, "epochs": 120}  # of training, as in examples/make.sh
MEMBERS = 3  # heads of an ensemble: those of seeds 0, 1 and 2
COPIES = 4  # noisy ones of each pair, for a method that is solved
HEADS = Path("build/ladder_heads")  # trained heads, so that an ensemble trains none twice


@dataclass(frozen=True, slots=True, kw_only=True)
class Trained:
    """A method trained on one source: probabilities (n, K) and features (n, F) of pairs."""

    probabilities: Callable[[Pair], Array]
    features: Callable[[Pair], Array]

    def predict(self, pair: Pair) -> Array:
        answers: Array = self.probabilities(pair).argmax(1)
        return answers


Recipe = Callable[[Embeddings, str, int], Trained]  # set, source and seed


def unit(rows: Array) -> Array:
    found: Array = rows / np.maximum(np.linalg.norm(rows, axis=-1, keepdims=True), 1e-12)
    return found


def onto(pair: Pair, target: Profiles | None, source: Profiles, step: float = 1.0) -> Pair:
    """Return a target's rows with the source's statistics; as they are without a profile."""
    if target is None:
        return pair
    vis, tac = (moved(x, target[n], source[n], step) for n, x in zip(IMAGES, pair, strict=True))
    return vis, tac


def rows_of(embeddings: Embeddings, rows: Array) -> Pair:
    return embeddings.vis[rows], embeddings.tac[rows]


def profile(pair: Pair) -> dict[str, Channels]:
    return {name: channels_of(rows) for name, rows in zip(IMAGES, pair, strict=True)}


def joined(pair: Pair, source: Profiles) -> Array:
    """Return standardised unit rows of both images, side by side: (n, 2 W)."""
    parts = [unit(standardised(x, source[n])) for n, x in zip(IMAGES, pair, strict=True)]
    return np.hstack(parts)


def logistic(inputs: Array, labels: Array, classes: int) -> Callable[[Array], Array]:
    """Return the probabilities of logistic regression (C = 1)."""
    model = LogisticRegression(C=1, max_iter=300).fit(inputs, labels)

    def probabilities(rows: Array) -> Array:
        found = np.zeros((len(rows), classes))
        found[:, model.classes_] = model.predict_proba(rows)
        return found

    return probabilities


def nearest_mean(inputs: Array, labels: Array, classes: int) -> Callable[[Array], Array]:
    """Return softmax(10 cosine) to the class means; 0 for an absent class."""
    means = np.stack([inputs[labels == c].sum(0) for c in range(classes)])
    there = np.isin(np.arange(classes), labels)

    def probabilities(rows: Array) -> Array:
        shares = np.exp(10 * unit(rows) @ unit(means).T) * there
        found: Array = shares / shares.sum(1, keepdims=True)
        return found

    return probabilities


CLOSED = {"logistic": logistic, "nearest_mean": nearest_mean}  # refitted in a moment


def closed(name: str, pair: Pair, labels: Array, source: Profiles, classes: int) -> Trained:
    """Return a closed-form method fitted to pairs."""
    fitted = CLOSED[name](joined(pair, source), labels, classes)
    return Trained(probabilities=lambda rows: fitted(joined(rows, source)), features=lambda rows: joined(rows, source))


def baseline(name: str, embeddings: Embeddings, rows: Array, source: Profiles, seed: int) -> Trained:
    """Train a method of the table on standardised embeddings, mirrored copies included."""

    def seen(flip: str, modality: str) -> torch.Tensor:
        raw = getattr(embeddings, modality + flip)[rows]
        return torch.from_numpy(standardised(raw, source[modality])).float()

    fitted = load(BASELINES, name, kind="method")(
        Source(
            vis=seen("", "vis"),
            tac=seen("", "tac"),
            vis_flip=seen("_flip", "vis"),
            tac_flip=seen("_flip", "tac"),
            labels=torch.from_numpy(embeddings.label[rows]),
            objects=tuple(embeddings.rows["object"][row] for row in rows),
            classes=embeddings.header.classes,
            seed=seed,
        )
    )

    def inputs(pair: Pair) -> list[torch.Tensor]:
        parts = zip(IMAGES, pair, strict=True)
        return [torch.from_numpy(standardised(x, source[n])).float() for n, x in parts]

    return Trained(
        probabilities=lambda pair: fitted.predict(*inputs(pair))["fused"].numpy(),
        features=lambda pair: fitted.features(*inputs(pair))["pair"].numpy(),
    )


def head(embeddings: Embeddings, source: str, seed: int) -> Trained:
    """Train the light head by the page's recipe."""
    return _of_head(embeddings, light_head(embeddings, source, seed))


def distilled(embeddings: Embeddings, source: str, seed: int, members: int = 0) -> Trained:
    """Train one light head on the mean logits of `members` (0: MEMBERS) of them, by the same recipe without LANG."""
    teachers = [light_head(embeddings, source, member).eval() for member in range(members or MEMBERS)]
    model = _kept("distilled", _plan(embeddings, source, seed, lang=False), teachers)
    return _of_head(embeddings, model)


def _plan(embeddings: Embeddings, source: str, seed: int, *, lang: bool = True, mffa: bool = True) -> TrainingPlan:
    training = TrainSettings(**PAGE, lang=lang)  # type: ignore[arg-type]
    head = {"width": 64, "mffa": mffa}
    return plan_training(embeddings, source, head=head, training=training, seed=seed)


def light_head(embeddings: Embeddings, source: str, seed: int) -> Any:
    """Return the model of `head`."""
    return _kept("omnivat", _plan(embeddings, source, seed))


def dtg_recipe(embeddings: Embeddings, source: str, seed: int) -> Trained:
    """Train the light head without MFFA, its tree alone, by the page's recipe."""
    return _of_head(embeddings, _kept("dtg", _plan(embeddings, source, seed, mffa=False)))


def _kept(name: str, plan: TrainingPlan, teachers: Sequence[Any] = ()) -> Any:
    """Return the head of a plan, trained once for this data and these settings."""
    bank = plan.bank if plan.training.lang else None
    run = run_name(plan.pairs, plan.settings, plan.training, plan.bank, plan.seed)

    def trained() -> Any:
        return train_once(
            plan.pairs,
            plan.settings,
            plan.training,
            bank=bank,
            seed=plan.seed,
            resume=None,
            watch=Watch(),
            teachers=teachers,
        ).model

    return _once(HEADS / f"{name}-{len(teachers)}-{run}.pt", trained)


def _once(file: Path, train: Callable[[], Any]) -> Any:
    """Return a model in evaluation mode, trained if the file is not there."""
    if not file.is_file():
        file.parent.mkdir(parents=True, exist_ok=True)
        torch.save(train(), file)
    return torch.load(file, weights_only=False).eval()


def _of_head(embeddings: Embeddings, model: Any) -> Trained:
    column = [embeddings.header.classes.index(name) for name in model.settings.classes]

    @torch.inference_mode()
    def output(pair: Pair) -> Any:
        return model(*(torch.from_numpy(np.asarray(x, np.float32)) for x in pair))

    def probabilities(pair: Pair) -> Array:
        found = np.zeros((len(pair[0]), len(embeddings.header.classes)))
        found[:, column] = output(pair).probabilities.numpy()
        return found

    def features(pair: Pair) -> Array:
        return np.hstack([unit(rows.numpy()) for rows in output(pair).f_hat.values()])

    return Trained(probabilities=probabilities, features=features)


def ensemble(members: Sequence[Trained]) -> Trained:
    """Return a soft ensemble: the mean of the probabilities, the features side by side."""
    return Trained(
        probabilities=lambda pair: np.mean([m.probabilities(pair) for m in members], axis=0),
        features=lambda pair: np.hstack([m.features(pair) for m in members]),
    )


def erm_recipe(embeddings: Embeddings, source: str, seed: int) -> Trained:
    """Train ERM-MLP as the page's head: its input, mirroring, noise, shift, epochs and batches."""
    plan = _plan(embeddings, source, seed, lang=False)
    run = run_name(plan.pairs, plan.settings, plan.training, None, seed)
    model = _once(HEADS / f"erm-{run}.pt", lambda: _perceptron(plan, seed))
    own = profile_of(plan.pairs).channels
    column = [embeddings.header.classes.index(name) for name in plan.settings.classes]

    @torch.inference_mode()
    def probabilities(pair: Pair) -> Array:
        found = np.zeros((len(pair[0]), len(embeddings.header.classes)))
        parts = [_standard(x, own[n]) for n, x in zip(IMAGES, pair, strict=True)]
        found[:, column] = model(*parts).softmax(-1).numpy()
        return found

    @torch.inference_mode()
    def features(pair: Pair) -> Array:
        parts = [_standard(x, own[n]) for n, x in zip(IMAGES, pair, strict=True)]
        found: Array = model.features(*parts).numpy()
        return found

    return Trained(probabilities=probabilities, features=features)


def _perceptron(plan: TrainingPlan, seed: int) -> Perceptron:
    training = plan.training
    labels, every = labels_of(plan.pairs, plan.settings), np.arange(len(plan.pairs))
    own = profile_of(plan.pairs).channels
    with seeded(derive_seed(seed, "erm-recipe")):
        model = Perceptron(plan.pairs.width, len(plan.settings.classes), IMAGES)
        optimiser = torch.optim.AdamW(model.parameters(), lr=3e-4, weight_decay=1e-2, fused=True)
        steps = training.epochs * -(-len(every) // training.batch)
        rates = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
        for epoch in range(training.epochs):
            stream = derive_seed(seed, "epoch", epoch)
            for batch in batches(plan.pairs, labels, every, None, training, stream):
                logits = model(*(_standard(getattr(batch, n).numpy(), own[n]) for n in IMAGES))
                optimiser.zero_grad(set_to_none=True)
                cross_entropy(logits, batch.labels).backward()
                optimiser.step()
                rates.step()
    return model


def logistic_recipe(embeddings: Embeddings, source: str, seed: int) -> Trained:
    """Fit logistic regression to COPIES noisy, shifted copies of each pair, drawn as for the page's head."""
    plan = _plan(embeddings, source, seed, lang=False)
    labels, every = labels_of(plan.pairs, plan.settings), np.arange(len(plan.pairs))
    own = profile_of(plan.pairs).channels
    drawn = [
        (joined((batch.vis.numpy(), batch.tac.numpy()), own), batch.labels.numpy())  # type: ignore[union-attr]
        for epoch in range(COPIES)
        for batch in batches(plan.pairs, labels, every, None, plan.training, derive_seed(seed, "epoch", epoch))
    ]
    column = [embeddings.header.classes.index(name) for name in plan.settings.classes]
    said = np.array(column)[np.concatenate([y for _, y in drawn])]
    inputs = np.vstack([x for x, _ in drawn])
    fitted = logistic(inputs, said, len(embeddings.header.classes))
    return Trained(probabilities=lambda pair: fitted(joined(pair, own)), features=lambda pair: joined(pair, own))


def _standard(rows: Array, source: Channels) -> torch.Tensor:
    return torch.from_numpy(standardised(rows, source)).float()


def _soft(recipe: Recipe) -> Recipe:
    def members(embeddings: Embeddings, source: str, seed: int) -> Trained:
        return ensemble([recipe(embeddings, source, member) for member in range(MEMBERS)])

    return members


RECIPES: dict[str, Recipe] = {
    "omnivat": head,
    "erm_recipe": erm_recipe,
    "logistic_recipe": logistic_recipe,
    "dtg_recipe": dtg_recipe,
    "distilled": distilled,
    "omnivat_soft": _soft(head),
    "dtg_soft": _soft(dtg_recipe),
    "erm_soft": _soft(erm_recipe),
    "logistic_soft": _soft(logistic_recipe),
}
