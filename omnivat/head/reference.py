"""OmniVaT as the paper has it, from top to bottom, in plain torch. Read this first.

A photo (vis) and a touch image (tac) of one surface come as vectors of frozen encoders. The head
predicts the surface's class. It is trained in one domain, the images of one sensor, and tested in
others. A text of the class (lang) is used in training only. One image of a pair may be missing.

    vector -> E -> its transform of order p -> tokens -> attention: F̄      MFFA, Eq. 2 to 6
    root = sum of all F̄ -> seven nodes, root one -> F̂ = F̄ + their mean     DTG, Eq. 8, 11
    F̂ -> ten times its cosine to each class -> softmax -> mean over vis, tac     ours

Equations have the paper's numbers and order. "Ours" marks what it leaves open (docs/method.md).
Beside a line is the shape of its result: B pairs, M images a pair, widths W (image), L (text) and
D (head), T = 2 x expansion tokens, N nodes, K classes.
"""

import torch
from torch import Tensor, eye, linalg, log_softmax, nn, relu, softmax, stack, where
from torch.nn.functional import cross_entropy, kl_div, linear, normalize

from omnivat.fractional import basis
from omnivat.kit.stages import MODALITIES  # lang, vis, tac


def dfrft(x: Tensor, p: Tensor) -> tuple[Tensor, Tensor]:
    """Return the fractional Fourier transform of order p, real and imaginary part. Eq. 2, 14.

    It acts on rows of x (B, D). p is in quarter turns: 0 leaves a row, 1 is its Fourier transform,
    2 reverses it. V holds the eigenvectors: a bell around entry 0 in column k = 0, then ever faster
    waves; for even D the last k is D, not D - 1. The Fourier transform multiplies the row's share
    of column k by (-i)^k, its power p by exp(-i p k π/2).

    >>> dfrft(torch.tensor([[1.0, 0, 0, 0]]), torch.tensor(1.0))[0]  # a pulse: a flat spectrum
    tensor([[0.5000, 0.5000, 0.5000, 0.5000]])
    """
    v, k = basis(x.shape[-1], dtype=x.dtype)  # V (D, D), orthonormal; k (D,), double
    angle = torch.pi / 2 * p * k  # (D,)
    shares = x @ v  # (B, D)
    real, imaginary = shares * angle.cos().to(x), shares * -angle.sin().to(x)  # times exp(-i angle)
    return real @ v.mT, imaginary @ v.mT


def fractional_tokens(embedding: Tensor, theta: Tensor, p: Tensor) -> Tensor:
    """Return F (B, T, D), real (ours): ReLU(θ Re of E's dfrft), all θ; then of Im. Eq. 3."""
    parts = stack(dfrft(embedding, p), dim=1)  # (B, 2, D)
    return relu(theta[:, None] * parts[:, :, None]).flatten(1, 2)


class FrATT(nn.Module):
    """Fractional Fourier attention, with one head: queries read tokens of the transform."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.query, self.key, self.value = (nn.Linear(width, width) for _ in range(3))
        wide = 4 * width  # ours, as are GELU and every bias
        self.ffn = nn.Sequential(nn.Linear(width, wide), nn.GELU(), nn.Linear(wide, width))

    def forward(self, queries: Tensor, tokens: Tensor) -> Tensor:
        """Return F̄ (B, D), of length 1 (ours), of queries and tokens (B, T, D). Eq. 4."""
        scores = self.query(queries) @ self.key(tokens).mT / tokens.shape[-1] ** 0.5  # (B, T, T)
        weights = softmax(scores, dim=-1)  # (B, T, T); the paper has √D outside (ours: inside)
        return normalize(self.ffn((weights @ self.value(tokens)).mean(1)), dim=-1)  # over queries


class MFFA(nn.Module):
    """Multimodal fractional Fourier adapter: one order p and one FrATT for all modalities."""

    def __init__(self, width: int, expansion: int, classes: int) -> None:
        super().__init__()
        self.order = nn.Parameter(torch.tensor(0.5, dtype=torch.float64))  # p, learned
        spread = torch.linspace(0.5, 1.5, expansion)  # ours: equal θ would stay equal
        self.theta = nn.ParameterDict({m: nn.Parameter(spread.clone()) for m in MODALITIES})
        self.fratt = FrATT(width)
        self.register_buffer("bank", torch.zeros(3, classes, width))  # F_g of each class seen,
        self.register_buffer("bank_seen", torch.zeros(classes).bool())  # kept by omnivat/training

    def mean_token(self, name: str) -> Tensor:
        """Return F_g (D,) where the class is not known: its mean over the classes (ours)."""
        bank = self.get_buffer("bank")[MODALITIES.index(name), self.get_buffer("bank_seen")]
        return bank.sum(0) / max(len(bank), 1)

    def with_class(self, name: str, tokens: Tensor, means: Tensor) -> Tensor:
        """Return F_g + F (B, T, D); `means` (B, B) @ mean tokens (B, D) is F_g of the class."""
        of_class = means @ tokens.mean(1)  # F_g (B, D); a row of zeros in `means`: no class given
        return tokens + where(means.any(1)[:, None], of_class, self.mean_token(name))[:, None]

    def image(self, name: str, e: Tensor, text: Tensor, on: Tensor, means: Tensor) -> Tensor:
        """Return F̄ (B, D) of images; F̄ of the text guides those that are `on`. Eq. 5 and 6."""
        guide = text * text.shape[-1] ** 0.5  # (B, D), of length √D like E (ours)
        tokens = fractional_tokens(e + guide * on[:, None], self.theta[name], self.order)  # Eq. 5
        queries = where(on[:, None, None], guide[:, None], tokens)  # Eq. 6: T times the text
        return self.fratt.forward(queries, self.with_class(name, tokens, means))

    def alignment(self, text: Tensor, bar: Tensor) -> Tensor:
        """Return L_MMA of one image: λ KL(text ‖ image), λ = 10, the mean of all pairs. Eq. 7."""
        image, goal = log_softmax(bar, dim=-1), log_softmax(text, dim=-1)  # over D (ours)
        return 10 * kl_div(image, goal, reduction="batchmean", log_target=True)

    def forward(self, name: str, embedding: Tensor) -> Tensor:
        """Return F̄ (B, D) of images at prediction: no text, so the tokens are queries (ours)."""
        tokens = fractional_tokens(embedding, self.theta[name], self.order)  # (B, T, D)
        return self.fratt.forward(tokens, tokens + self.mean_token(name))


class DTG(nn.Module):
    """Discrete tree generation: root (node 0), its children (1, 2), leaves (3 to 6)."""

    def __init__(self, width: int, levels: int) -> None:
        super().__init__()
        self.levels = levels
        self.weight = nn.Parameter(linalg.qr(torch.randn(2**levels - 2, width, width)).Q)  # ours
        self.bias = nn.Parameter(torch.zeros(self.weight.shape[:2]))  # ours

    def forward(self, root: Tensor) -> Tensor:
        """Return nodes (B, N, D): node e + 1 is a linear map of one parent, node e // 2. Eq. 8."""
        nodes = [root]
        for edge, (weight, bias) in enumerate(zip(self.weight, self.bias, strict=True)):
            nodes.append(linear(nodes[edge // 2], weight, bias))  # (B, D)
        return stack(nodes, dim=1)

    def diversity(self, nodes: Tensor) -> Tensor:
        """Return L_NOD, least where the nodes of each level are orthogonal; of the root it is 0."""
        units = normalize(nodes, dim=-1).split([2**r for r in range(self.levels)], dim=1)
        excess = [u @ u.mT - eye(u.shape[1]).to(u) for u in units[1:]]  # (B, 2^r, 2^r); A: Eq. 9
        return stack([linalg.matrix_norm(x).mean() for x in excess]).sum()  # Eq. 10


class Reference(nn.Module):
    """The head; `head.py` is its fast form. Each modality has `expansion` θ."""

    def __init__(
        self, classes: int, image: int, text: int, width: int, expansion: int = 4, levels: int = 3
    ) -> None:
        super().__init__()  # project_image is for vis; all three maps are ours
        self.project_image, self.project_tac = nn.Linear(image, width), nn.Linear(image, width)
        self.project_lang = nn.Linear(text, width)
        self.mffa, self.dtg = MFFA(width, expansion, classes), DTG(width, levels)
        self.classifier = nn.Parameter(torch.randn(classes, width) / width**0.5)

    def embed(self, name: str, vector: Tensor) -> Tensor:
        """Return E (B, D): vectors (B, W), or those of texts (B, L), projected and scaled to length
        √D. Both steps are ours.
        """
        layers = {"lang": self.project_lang, "vis": self.project_image, "tac": self.project_tac}
        return normalize(layers[name](vector), dim=-1).mul(self.classifier.shape[1] ** 0.5)

    def logits(self, bars: Tensor, nodes: Tensor) -> Tensor:
        """Return logits (M, B, K): ten times the cosine of F̂ to each class (ours). F̂: Eq. 11."""
        hats = normalize(bars + nodes.mean(1), dim=-1)  # (M, B, D), at length 1
        return 10 * hats @ normalize(self.classifier, dim=-1).mT

    def loss(
        self, images: dict[str, Tensor], lang: Tensor, labels: Tensor, on: Tensor, token_on: Tensor
    ) -> Tensor:
        """Return the loss of a batch, L_MMA + L_NOD + L_CE. Eq. 12, Alg. 1.

        images    (B, W) each; lang (B, L) a text of each pair's class; labels (B,) the class
        on        (B,) bool: E, queries, root get the text: half (ours); others: only L_MMA, F_g
        token_on  (B,) bool: F_g is the class's mean here, `on` or not: half (ours); others: bank
        """
        same, mffa = labels[:, None] == labels, self.mffa  # same (B, B)
        means = same.to(lang) / same.sum(1, keepdim=True) * token_on[:, None]  # (B, B)
        tokens = fractional_tokens(self.embed("lang", lang), mffa.theta["lang"], mffa.order)
        text = mffa.fratt(tokens, mffa.with_class("lang", tokens, means))  # F̄ (B, D), Eq. 4
        bars = stack([mffa.image(m, self.embed(m, x), text, on, means) for m, x in images.items()])
        nodes = self.dtg(bars.sum(0) + text * on[:, None])  # (B, N, D); the text joins the root
        total: Tensor = self.dtg.diversity(nodes)  # L_NOD
        for bar, logits in zip(bars, self.logits(bars, nodes), strict=True):  # L_CE: mean (ours)
            total = total + mffa.alignment(text, bar) + cross_entropy(logits, labels) / len(bars)
        return total

    def forward(self, images: dict[str, Tensor]) -> Tensor:
        """Return probabilities (B, K). Keys: "vis", "tac" or both. Alg. 2; with a tree (ours).

        >>> head = Reference(classes=3, image=12, text=10, width=6).requires_grad_(False)
        >>> pair = {"vis": torch.randn(1, 12), "tac": torch.randn(1, 12)}
        >>> head.dtg(head.mffa("tac", head.embed("tac", pair["tac"]))).shape  # nodes of a touch
        torch.Size([1, 7, 6])
        >>> [round(float(head(x).sum()), 5) for x in (pair, {"tac": pair["tac"]})]  # no photo
        [1.0, 1.0]
        """
        bars = stack([self.mffa(name, self.embed(name, x)) for name, x in images.items()])
        return softmax(self.logits(bars, self.dtg(bars.sum(0))), dim=-1).mean(0)  # mean: ours
