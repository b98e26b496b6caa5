"""OmniVaT as the paper has it, top to bottom, in plain torch. Read this first.

Source: Qiu et al., *OmniVaT: Single Domain Generalization for Multimodal Visual-Tactile Learning*;
Eq. numbers are the paper's. A comment beside a line is the shape of its result: B pairs, W width of
the encoder, D width of the head, E numbers θ_e, T = 2E tokens, N nodes, K classes. Where the paper
leaves something open, this is the project's choice; docs/method.md gives the reasons. The fast head
(`head.py`) has the same parameters under the same names and computes the same; a test holds the two
together.
"""

import torch
from torch import Tensor, linalg, log_softmax, nn, relu, softmax, stack
from torch.nn.functional import cross_entropy, linear, normalize

from omnivat.fractional import basis
from omnivat.kit.stages import MODALITIES  # lang: text, in training alone; vis: photo; tac: touch


def dfrft(x: Tensor, p: Tensor) -> tuple[Tensor, Tensor]:
    """Eq. 2: F_p(x) = V exp(-iπpk/2) Vᵀ x, as its real and imaginary part.

    V are the eigenvectors of the Fourier matrix, k the index of each. p = 0 leaves x as it is,
    p = 1 is the Fourier transform, and p in between stops on the way.
    """
    vectors, k = basis(x.shape[-1], dtype=x.dtype)  # (D, D), (D,)
    angle = torch.pi / 2 * p * k  # (D,)
    cos, sin = angle.cos().to(x.dtype), angle.sin().to(x.dtype)  # of float64, as p is
    inner = x @ vectors  # (B, D)
    return (inner * cos) @ vectors.mT, (inner * -sin) @ vectors.mT


class FrATT(nn.Module):
    """Fractional Fourier attention, one head. Eq. 4."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.query, self.key, self.value = (nn.Linear(width, width) for _ in range(3))
        self.ffn = nn.Sequential(
            nn.Linear(width, 4 * width), nn.GELU(), nn.Linear(4 * width, width)
        )

    def forward(self, queries: Tensor, tokens: Tensor) -> Tensor:
        """Return a feature (B, D) of queries and tokens (B, T, D)."""
        scores = self.query(queries) @ self.key(tokens).mT  # (B, T, T)
        # the root: inside, against Eq. 4
        weights = softmax(scores / tokens.shape[-1] ** 0.5, dim=-1)
        mixed: Tensor = self.ffn((weights @ self.value(tokens)).mean(1))  # (B, D)
        return mixed


class MFFA(nn.Module):
    """Multimodal fractional Fourier adapter: one order p and one FrATT for all modalities."""

    def __init__(self, width: int, expansion: int, classes: int) -> None:
        super().__init__()
        self.order = nn.Parameter(torch.tensor(0.5, dtype=torch.float64))  # p, learned
        # equal ones stay equal
        spread = torch.linspace(0.5, 1.5, expansion) if expansion > 1 else torch.ones(1)
        self.theta = nn.ParameterDict({m: nn.Parameter(spread.clone()) for m in MODALITIES})
        self.fratt = FrATT(width)
        # class tokens, kept while training
        self.register_buffer("bank", torch.zeros(3, classes, width))
        self.register_buffer("bank_seen", torch.zeros(classes).bool())

    def class_token(self, name: str) -> Tensor:
        """Return the class-agnostic token (D,): the mean over the classes; it needs no label."""
        bank, seen = self.get_buffer("bank"), self.get_buffer("bank_seen").double()
        rows: Tensor = bank[MODALITIES.index(name)]
        return (seen.to(rows) @ rows) / seen.sum().clamp_min(1).to(rows)

    def forward(
        self,
        name: str,
        embedding: Tensor,
        guide: Tensor | None = None,
        guided: Tensor | None = None,
        same: Tensor | None = None,
        token_on: Tensor | None = None,
    ) -> Tensor:
        """Return F̄ (B, D) of one modality's embeddings (B, D).

        guide, guided    F̄ of LANG (B, D), and which pairs (B,) it guides
        same, token_on   which pairs share a class (B, B), and which see their own class token (B,)
        """
        parts = stack(dfrft(embedding, self.order), dim=1)  # (B, 2, D)
        # Eq. 3: (B, T, D)
        tokens = relu(self.theta[name][:, None] * parts[:, :, None]).flatten(1, 2)
        queries = tokens
        if guide is not None and guided is not None:  # Eq. 6: LANG is the query
            queries = torch.where(guided[:, None, None], guide[:, None], tokens)
        token = self.class_token(name).expand_as(embedding)  # F_g: (B, D)
        if same is not None and token_on is not None:  # in training: the mean of the pair's class
            of_class = same / same.sum(1, keepdim=True) @ tokens.mean(1)  # (B, D)
            token = torch.where(token_on[:, None], of_class, token)
        return normalize(self.fratt(queries, tokens + token[:, None]), dim=-1)


class DTG(nn.Module):
    """Discrete tree generation: a binary tree of linear children. Eq. 7 and 8."""

    def __init__(self, width: int, levels: int) -> None:
        super().__init__()
        edges = 2**levels - 2
        self.weight = nn.Parameter(
            stack([linalg.qr(torch.empty(width, width).normal_())[0] for _ in range(edges)])
        )
        self.bias = nn.Parameter(torch.zeros(edges, width))

    def forward(self, root: Tensor) -> Tensor:
        """Return all nodes (B, N, D) of roots (B, D): node n has the children 2n + 1 and 2n + 2."""
        nodes = [root]
        for edge, (weight, bias) in enumerate(zip(self.weight, self.bias, strict=True)):
            nodes.append(linear(nodes[edge // 2], weight, bias))  # (B, D)
        return stack(nodes, dim=1)


class Reference(nn.Module):
    """The head: frozen embeddings of widths `images` and `text` in, class probabilities out.

    A worked pair becomes one prediction over three classes; the tree has 2^3 - 1 = 7 nodes:

    >>> _ = torch.manual_seed(0)
    >>> head = Reference(classes=3, images=12, text=10, width=8)
    >>> vis, tac = torch.randn(1, 12), torch.randn(1, 12)
    >>> probabilities = head({"vis": vis, "tac": tac})
    >>> probabilities.shape, torch.allclose(probabilities.sum(), torch.tensor(1.0))
    (torch.Size([1, 3]), True)
    >>> photo, touch = (head.mffa(m, head.embedded(m, x)) for m, x in (("vis", vis), ("tac", tac)))
    >>> head.dtg(photo + touch).shape
    torch.Size([1, 7, 8])

    >>> head({"vis": vis}).shape  # from the photo alone
    torch.Size([1, 3])
    """

    def __init__(
        self, classes: int, images: int, text: int, width: int, expansion: int = 4, levels: int = 3
    ) -> None:
        super().__init__()
        self.length = width**0.5
        self.project_image, self.project_tac = (nn.Linear(images, width) for _ in range(2))
        self.project_lang = nn.Linear(text, width)
        self.mffa, self.dtg = MFFA(width, expansion, classes), DTG(width, levels)
        self.classifier = nn.Parameter(torch.empty(classes, width).normal_(std=width**-0.5))

    def embedded(self, name: str, raw: Tensor) -> Tensor:
        """Project an encoder's embeddings (B, W) to (B, D), of length √D."""
        layers = {"lang": self.project_lang, "vis": self.project_image, "tac": self.project_tac}
        embedding: Tensor = normalize(layers[name](raw), dim=-1) * self.length  # (B, D)
        return embedding

    def classify(self, features: Tensor) -> Tensor:
        """Return logits (B, K): ten times the cosine to each class."""
        return 10 * normalize(features, dim=-1) @ normalize(self.classifier, dim=-1).mT

    def forward(self, images: dict[str, Tensor]) -> Tensor:
        """Return probabilities (B, K) of "vis", "tac" or both (B, W). Alg. 2, with the tree."""
        bars = [self.mffa(name, self.embedded(name, raw)) for name, raw in images.items()]
        mean = self.dtg(stack(bars).sum(0)).mean(1)  # T = F̄ᵛ + F̄ᵗ, and the mean node: (B, D)
        return stack([softmax(self.classify(bar + mean), dim=-1) for bar in bars]).mean(0)

    def loss(
        self,
        images: dict[str, Tensor],
        lang: Tensor,
        labels: Tensor,
        lang_on: Tensor,
        token_on: Tensor,
    ) -> Tensor:
        """Return the joint loss of a batch, Alg. 1: 10 L_MMA + L_NOD + cross-entropy. Eq. 12.

        lang       (B, L) text embeddings of the labels (B,)
        lang_on    (B,) pairs that LANG guides; the others learn to do without
        token_on   (B,) pairs that see the token of their own class
        """
        same = (labels[:, None] == labels).to(self.classifier)  # (B, B)
        text = self.mffa("lang", self.embedded("lang", lang), None, None, same, token_on)
        guide, on = self.length * text, lang_on[:, None]  # (B, D), (B, 1)
        bars = {
            # Eq. 5
            name: self.mffa(
                name, self.embedded(name, raw) + guide * on, guide, lang_on, same, token_on
            )
            for name, raw in images.items()
        }
        nodes = self.dtg(stack(list(bars.values())).sum(0) + text * on)  # (B, N, D)
        total = stack(
            [cross_entropy(self.classify(bar + nodes.mean(1)), labels) for bar in bars.values()]
        ).mean()
        goal = log_softmax(text, dim=-1)  # Eq. 9, L_MMA: KL from LANG to each image
        for bar in bars.values():
            total = total + 10 * (goal.exp() * (goal - log_softmax(bar, dim=-1))).sum(-1).mean()
        count, level = nodes.shape[1], 2
        while level <= count:  # Eq. 10, 11, L_NOD: nodes of one level are kept apart
            units = normalize(nodes[:, level - 1 : 2 * level - 1], dim=-1)  # (B, level, D)
            excess = units @ units.mT - torch.eye(level).to(units)
            total = total + linalg.matrix_norm(excess).mean()
            level *= 2
        return total
