"""Linear maps of the photo, the touch and both, averaged: a plain head over standardised
embeddings.

Each channel is centred and scaled by a profile and bounded by tanh, and each row is brought to
length √W (`omnivat.data.profile.standardised`). Three maps then give class probabilities: one of
the photo, one of the touch, one of both side by side. The prediction for a pair is their mean.
Training may add fresh noise in every step: white noise on every channel, and one offset along the
directions in which the pairs differ.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn
from torch.nn.functional import cross_entropy, normalize

from omnivat.data.profile import Channels, channels_of, floor_of, scale_of

STEPS, PLAIN_STEPS = 400, 150  # of AdamW on all pairs at once, with training noise and without
SPREAD_ROWS = 512  # pairs that span an offset; bounds the work for large domains
RATE, DECAY = 1.28, 1e-2  # the rate is divided by W, and a cosine schedule takes it to zero
Raw = Mapping[str, Float[Tensor, "N W"]]  # embeddings by modality


class LinearMaps(nn.Module):
    """One linear map for each image, and one of both if there are two; all zero at the start."""

    def __init__(self, width: int, classes: int, modalities: Sequence[str]) -> None:
        super().__init__()
        inputs = {name: (name,) for name in modalities}
        self.inputs = inputs | ({"both": tuple(modalities)} if len(modalities) > 1 else {})
        self.maps = nn.ModuleDict(
            {
                name: nn.utils.skip_init(nn.Linear, len(parts) * width, classes)
                for name, parts in self.inputs.items()
            }
        )
        for weight in self.parameters():
            nn.init.zeros_(weight)

    def logits(self, rows: Raw) -> dict[str, Float[Tensor, "N K"]]:
        """Return map name -> logits, for each map whose images are among the standard rows."""
        return {
            name: self.maps[name](torch.cat([rows[part] for part in parts], dim=-1))
            for name, parts in self.inputs.items()
            if set(parts) <= set(rows)
        }

    def forward(self, rows: Raw) -> dict[str, Float[Tensor, "N K"]]:
        """Return class probabilities of each given image alone, and "fused", the mean of all
        maps.
        """
        shares = {name: logits.softmax(-1) for name, logits in self.logits(rows).items()}
        fused = torch.stack(list(shares.values())).mean(0)
        return {name: shares[name] for name in rows} | {"fused": fused}


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedMaps:
    """Linear maps, and the profile that standardises their rows."""

    maps: LinearMaps
    profile: Mapping[str, Channels]

    def standard(self, raw: Raw) -> dict[str, Float[Tensor, "N W"]]:
        """Return raw embeddings as the maps take them: standardised, bounded, of length √W."""
        return {name: standard_rows(rows, self.profile[name]) for name, rows in raw.items()}

    def __call__(self, raw: Raw) -> dict[str, Float[Tensor, "N K"]]:
        """Return class probabilities of raw embeddings; see `LinearMaps`."""
        readings: dict[str, Tensor] = self.maps(self.standard(raw))
        return readings


def standard_rows(raw: Float[Tensor, "N W"], profile: Channels) -> Float[Tensor, "N W"]:
    """Return rows standardised by a profile, bounded, of length √W."""
    scale = torch.as_tensor(scale_of(profile, floor_of(profile)))
    bounded = torch.tanh((raw - torch.as_tensor(profile.mean)) / scale)
    rows: Tensor = normalize(bounded, dim=-1) * bounded.shape[1] ** 0.5
    return rows


def fit_maps(
    raw: Raw,
    labels: Int[Tensor, " N"],
    classes: int,
    *,
    profile: Mapping[str, Channels] | None = None,
    noise: float = 0.0,
    shift: float = 0.0,
    seed: int = 0,
    steps: int = 0,
) -> FittedMaps:
    """Train linear maps on pairs; equal seeds give equal maps.

    raw      embeddings of the pairs: "vis", "tac" or both
    labels   class indices
    profile  that standardises them; None: their own
    noise    white noise in training, in standard deviations of each channel
    shift    size of an offset in training, drawn for every pair in every step, in the spread of the
             pairs

    steps    of training; 0: STEPS with training noise, PLAIN_STEPS without

    >>> raw = {name: torch.eye(4).repeat(3, 1) for name in ("vis", "tac")}
    >>> fitted = fit_maps(raw, torch.arange(4).repeat(3), 4)
    >>> fitted(raw)["fused"].argmax(-1)[:4].tolist()
    [0, 1, 2, 3]
    """
    profile = profile or {name: channels_of(rows.numpy()) for name, rows in raw.items()}
    random = torch.Generator().manual_seed(seed)
    width = next(iter(raw.values())).shape[1]
    model = LinearMaps(width, classes, tuple(raw))
    fitted = FittedMaps(maps=model, profile=profile)
    rows, fresh = fitted.standard(raw), bool(noise or shift)
    steps = steps or (STEPS if fresh else PLAIN_STEPS)
    optimiser = torch.optim.AdamW(model.parameters(), lr=RATE / width, weight_decay=DECAY)
    rates = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    for _ in range(steps):
        if fresh:
            drawn = {n: _disturbed(x, profile[n], noise, shift, random) for n, x in raw.items()}
            rows = fitted.standard(drawn)
        losses = [cross_entropy(logits, labels) for logits in model.logits(rows).values()]
        optimiser.zero_grad(set_to_none=True)
        torch.stack(losses).sum().backward()
        optimiser.step()
        rates.step()
    model.requires_grad_(False).eval()
    return fitted


def _disturbed(
    raw: Tensor, profile: Channels, noise: float, shift: float, random: torch.Generator
) -> Tensor:
    """Return raw rows under white noise, each moved by an offset of its own."""
    rows = raw
    if noise:
        spread = torch.as_tensor(profile.variance).sqrt()
        rows = rows + noise * spread * torch.randn(rows.shape, generator=random)
    if shift:
        some = raw[torch.randperm(len(raw), generator=random)[:SPREAD_ROWS]]
        weights = torch.randn(len(rows), len(some), generator=random)
        offsets = weights @ (some - torch.as_tensor(profile.mean))
        rows = rows + offsets * (shift / len(some) ** 0.5)
    return rows
