"""SPG: a generator makes a prompt for each image and compares the image with the class texts.

Stage 1 learns one prompt for the source (CoOp). Stage 2 trains a conditional GAN: its generator
makes a prompt from noise and an image's embedding; its discriminator separates it from the learned
prompt. SPG needs pooled embeddings and the live text tower, but not the inside of the image tower.
Source: Bai et al., Soft Prompt Generation for Domain Generalization, ECCV 2024; networks, starts,
rates, schedules and clips are those of its code, for other sets than PACS and VLCS where they
differ. Our changes: VIS and TAC count as images alike, images are mirrored, not cropped, and one
fixed noise vector serves every prediction, so that a prediction does not depend on the batch.
"""

import math
from collections.abc import Callable
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, mse_loss, normalize

from omnivat.encoders.lang.clip_prompts import ClipPrompts
from omnivat.kit.errors import DataError
from omnivat.kit.seeding import derive_seed
from omnivat.study.baselines.contract import Fitted, Source, late, seeded
from omnivat.study.baselines.descent import size
from omnivat.study.baselines.text import LOGIT_SCALE, texts_of_the_image_encoder

START = "a photo of a"  # the initial prompt: four word vectors
NOISE, HIDDEN = 100, (128, 256, 512, 1024)
PROMPT_EPOCHS, GAN_EPOCHS, WARM, BATCH = 50, 70, 4, 32
PROMPT_RATE, GAN_RATE, LEAST = 2e-3, 2e-4, 1e-5
# Largest norms of gradients: weights, biases, and the layers named.
OF_JUDGE = (0.05, 0.5, {"0.weight": 5.0, "0.bias": 5.0, "8.weight": 5.0, "8.bias": 5.0})
OF_GENERATOR = (5e-3, 5e-8, {"9.bias": 1.0, "11.bias": 1.0})


class Generator(nn.Module):
    """(noise (B, 100), image (B, D)) -> prompt (B, T, W)."""

    def __init__(self, width: int, shape: tuple[int, ...]) -> None:
        super().__init__()
        layers: list[nn.Module] = [nn.Linear(NOISE + width, HIDDEN[0]), nn.LeakyReLU(0.2)]
        for before, after in pairwise(HIDDEN):
            layers += [nn.Linear(before, after), nn.BatchNorm1d(after, 0.8), nn.LeakyReLU(0.2)]
        self.layers = nn.Sequential(*layers, nn.Linear(HIDDEN[-1], shape[0] * shape[1]), nn.Tanh())
        self.shape = shape
        _start(self)

    def forward(self, noise: Tensor, image: Tensor) -> Tensor:
        made: Tensor = self.layers(torch.cat((noise, image), dim=-1))
        return made.reshape(-1, *self.shape)


class Discriminator(nn.Module):
    """(prompt (B, T, W), image (B, D)) -> how real (B, 1)."""

    def __init__(self, width: int, shape: tuple[int, ...]) -> None:
        super().__init__()
        size = shape[0] * shape[1] + width
        layers: list[nn.Module] = [nn.Linear(size, 512), nn.LeakyReLU(0.2)]
        for _ in range(2):
            layers += [nn.Linear(512, 512), nn.Dropout(0.4), nn.LeakyReLU(0.2)]
        self.layers = nn.Sequential(*layers, nn.Linear(512, 1))
        _start(self)

    def forward(self, prompt: Tensor, image: Tensor) -> Tensor:
        judged: Tensor = self.layers(torch.cat((prompt.flatten(1), image), dim=-1))
        return judged


def _start(network: nn.Module) -> None:
    for layer in network.modules():
        if isinstance(layer, nn.Linear):
            nn.init.kaiming_uniform_(layer.weight, nonlinearity="leaky_relu")


def rate(epoch: int, full: float, epochs: int, warm: int) -> float:
    """Return an epoch's rate: 1e-5 first, then linear up to `full`, then cosine."""
    if epoch < warm:
        return full * epoch / warm if epoch else LEAST
    return full * 0.5 * (1 + math.cos(math.pi * (epoch - warm) / epochs))


def fit(source: Source) -> Fitted:
    """Learn the source's prompt, then the generator; rates and epochs as published.

    Raises DataError if the image encoder's own text tower is not available.
    """
    texts_of_the_image_encoder(source, "SPG")
    if source.prompts is None:
        raise DataError(
            "SPG needs the live text tower of the images' checkpoint, which is not at hand; make"
            " the LANG bank on this machine with `python -m omnivat prompts --encoder NAME"
            " --weights FILE`."
        )
    tower, scale = source.prompts(), source.logit_scale or LOGIT_SCALE
    with seeded(derive_seed(source.seed, "spg")):
        prompt = learn_prompt(source, tower, scale)
        generator = learn_generator(source, prompt)
        noise = torch.randn(1, NOISE)
    probabilities = _reader(generator, noise, tower, source.classes, scale)
    return Fitted(predict=late(lambda _, rows: probabilities(rows)), parameters=size(generator))


def learn_prompt(source: Source, tower: ClipPrompts, scale: float) -> Tensor:
    """Return the prompt (T, W) that separates the source's classes: CoOp, one context for all."""
    prompt = tower.words(START).detach().clone().requires_grad_(True)
    images, labels = _images(source)
    optimiser = torch.optim.SGD([prompt], lr=LEAST, momentum=0.9, weight_decay=5e-4)
    for epoch in range(PROMPT_EPOCHS):
        optimiser.param_groups[0]["lr"] = rate(epoch, PROMPT_RATE, PROMPT_EPOCHS, 1)
        for rows in torch.split(torch.randperm(len(images)), BATCH):
            texts = normalize(tower.embed_contexts(prompt[None], source.classes)[0], dim=-1)
            loss = cross_entropy(scale * images[rows] @ texts.T, labels[rows])
            (prompt.grad,) = torch.autograd.grad(loss, [prompt])
            optimiser.step()
    return prompt.detach()


def learn_generator(source: Source, prompt: Tensor) -> Generator:
    """Train the least-squares GAN on generated prompts against the learned one."""
    images, _ = _images(source)
    generator = Generator(images.shape[1], tuple(prompt.shape))
    judge = Discriminator(images.shape[1], tuple(prompt.shape))
    optimisers = [
        torch.optim.AdamW(net.parameters(), lr=LEAST, weight_decay=1e-4)
        for net in (generator, judge)
    ]
    for epoch in range(GAN_EPOCHS):
        for optimiser in optimisers:
            optimiser.param_groups[0]["lr"] = rate(epoch, GAN_RATE, GAN_EPOCHS, WARM)
        for rows in torch.split(torch.randperm(len(images)), BATCH):
            if len(rows) > 1:  # BatchNorm needs two
                other = torch.randperm(len(images))[: len(rows)]
                _gan_step(generator, judge, optimisers, images[rows], images[other], prompt)
    return generator.eval().requires_grad_(False)


def _gan_step(
    generator: Generator,
    judge: Discriminator,
    optimisers: list[torch.optim.AdamW],
    images: Tensor,
    others: Tensor,
    prompt: Tensor,
) -> None:
    """Train both networks: the learned prompt beside `images` is real, generated ones beside
    `others` are not.
    """
    made = generator(torch.randn(len(others), NOISE), others)
    real = judge(prompt.expand(len(images), *prompt.shape), images)
    fake = judge(made.detach(), others)
    judge_loss = mse_loss(real, torch.ones_like(real)) + mse_loss(fake, torch.zeros_like(fake))
    _step(optimisers[1], judge, judge_loss, OF_JUDGE)
    fooled = judge(made, others)
    _step(optimisers[0], generator, mse_loss(fooled, torch.ones_like(fooled)), OF_GENERATOR)


def _step(
    optimiser: torch.optim.AdamW,
    network: nn.Module,
    loss: Tensor,
    most: tuple[float, float, dict[str, float]],
) -> None:
    optimiser.zero_grad(set_to_none=True)
    loss.backward()
    of_weights, of_biases, named = most
    for name, weight in network.named_parameters():
        own = of_weights if name.endswith("weight") else of_biases
        torch.nn.utils.clip_grad_norm_(weight, named.get(name.removeprefix("layers."), own))
    optimiser.step()


def _images(source: Source) -> tuple[Tensor, Tensor]:
    full = source.both_views()
    rows = normalize(torch.cat((full.vis, full.tac)), dim=-1)
    return rows, full.labels.repeat(2)


def _reader(
    generator: Generator, noise: Tensor, tower: ClipPrompts, classes: tuple[str, ...], scale: float
) -> Callable[[Tensor], Tensor]:
    """Return (B, D) -> probabilities (B, K); each image has its own prompt and texts."""

    @torch.no_grad()
    def few(images: Tensor) -> Tensor:
        prompts = generator(noise.expand(len(images), NOISE), images)
        texts = normalize(tower.embed_contexts(prompts, classes), dim=-1)  # (B, K, D)
        return (scale * (texts @ images[..., None])[..., 0]).softmax(-1)

    def probabilities(rows: Tensor) -> Tensor:
        images = normalize(rows, dim=-1)
        if torch.compiler.is_exporting():  # a loop over a batch of any size cannot be traced
            return few(images)
        return torch.cat([few(part) for part in images.split(BATCH)])

    return probabilities
