"""Any setting of the head, token by token: the fast head is compared with it."""

import torch
from torch.nn.functional import cross_entropy, normalize

from omnivat.head.reference import dfrft
from omnivat.kit.stages import MODALITIES


class Slow:
    """The arithmetic of a head, with its parameters."""

    def __init__(self, head):
        self.head, self.settings, self.own = head, head.settings, head.mffa
        self.literal = head.settings.feature_scale == "literal"

    def embedded(self, name, raw):
        layers = {"lang": self.head.project_lang, "vis": self.head.project_image}
        layers["tac"] = self.head.project_tac if self.settings.projects_apart else layers["vis"]
        rows = layers[name](self.head.standardised(name, raw))
        return rows if self.literal else self.head.length * normalize(rows, dim=-1)

    def tokens(self, name, embedding, order):
        """Return F_p(E), complex (B, D), and its tokens (B, T, D)."""
        if order is None:
            order = self.own.order.expand(3)[MODALITIES.index(name)]
        turned = torch.complex(*dfrft(embedding, order.reshape(-1, 1)))
        theta = self.own.theta[name] if self.settings.mffa else torch.ones(1)
        each = theta.to(turned)[:, None] * turned[:, None]  # (B, E, D)
        real, imaginary = each.real.relu(), each.imag.relu()
        kinds = {"tokens": torch.cat((real, imaginary), 1), "real": real, "magnitude": each.abs()}
        return turned, kinds[self.settings.complex_to_real]

    def bar(self, name, embedding, order=None, guide=None, guided=None, token=None):
        """Return F-bar (B, D); `token` maps the mean token to F_g."""
        if not self.settings.mffa:
            return embedding / self.head.length
        fratt, root = self.own.fratt, self.settings.width**0.5
        inside = self.settings.attention_scale == "inside"
        queries = tokens = self.tokens(name, embedding, order)[1]
        if guide is not None:
            queries = torch.where(guided[:, None, None], guide[:, None], tokens)
        if self.settings.class_token:
            agnostic = self.own.class_agnostic_tokens([name])
            added = agnostic if token is None else token(tokens.mean(1), agnostic)
            tokens = tokens + added[:, None]
        scores = fratt.query(queries) @ fratt.key(tokens).mT
        weights = torch.softmax(scores / (root if inside else 1), dim=-1)
        feature = fratt.ffn((weights @ fratt.value(tokens)).mean(1) / (1 if inside else root))
        return feature if self.literal else normalize(feature, dim=-1)

    def nodes(self, bars, root):
        """Return the nodes (B, N, D) that grow from features; [] for none."""
        kind, count = self.settings.generation, 2**self.settings.levels - 1
        if kind == "none":
            return []
        if kind == "interpolation":
            shares = [n / (count + 1) for n in range(1, count + 1)]
            return torch.stack([torch.lerp(bars[0], bars[-1], share) for share in shares], dim=1)
        grown = [root]
        for edge, (weight, bias) in enumerate(zip(*self.head.dtg.parameters(), strict=True)):
            parent = {"tree": edge // 2, "series": edge, "parallel": 0}[kind]
            grown.append(grown[parent] @ weight.T + bias)
        return torch.stack(grown, dim=1)

    def predict(self, images, order=None):
        """Return F-bar and F-hat of the images (M, B, D), and mean probabilities."""
        bars = [self.bar(n, self.embedded(n, raw), order) for n, raw in images.items()]
        nodes = self.nodes(bars, sum(bars))
        mean = nodes.mean(1) if len(nodes) and self.settings.tree_at_inference else 0.0
        hats = torch.stack(bars) + mean
        return torch.stack(bars), hats, self.head.classify(hats).softmax(-1).mean(0)

    def loss(self, images, lang, labels, *, lang_on, token_on, aligned, order=None):
        """Return 3 MMA + 2 NOD + cross-entropy of a batch; MMA acts on the pairs `aligned`."""
        same, on = (labels[:, None] == labels).to(self.head.dtype), lang_on[:, None]

        def token(mean, agnostic):
            return torch.where(token_on[:, None], same / same.sum(1, keepdim=True) @ mean, agnostic)

        text = guide = None
        inputs = {name: self.embedded(name, raw) for name, raw in images.items()}
        if lang is not None:
            text = self.bar("lang", self.embedded("lang", lang), order, token=token)
            long = self.settings.guide_length == "embedding"
            guide = text * (self.head.length if long else 1) if self.settings.mffa else None
        if guide is not None and self.settings.guide != "query":
            inputs = {name: x + guide * on for name, x in inputs.items()}
        query = None if self.settings.guide == "added" else guide
        bars = [self.bar(n, x, order, query, lang_on, token) for n, x in inputs.items()]
        nodes = self.nodes(bars, sum(bars) + (0 if text is None else text * on))
        mean = nodes.mean(1) if len(nodes) else 0.0
        total = sum(cross_entropy(self.head.classify(bar + mean), labels) for bar in bars)
        total = total / len(bars)
        for bar in bars if guide is not None else ():
            goal = text.log_softmax(-1)
            gap = (goal.exp() * (goal - bar.log_softmax(-1))).sum(-1)
            total = total + 3 * gap[aligned].mean()
        every = range(2**self.settings.levels - 1)
        groups = {
            "tree": [every[2**r - 1 : 2 ** (r + 1) - 1] for r in range(1, self.settings.levels)],
            "series": [every],
            "parallel": [every[1:]],
        }
        for group in groups.get(self.settings.generation, ()) if self.settings.edges else ():
            units = normalize(nodes[:, group.start : group.stop], dim=-1)
            excess = units @ units.mT - torch.eye(len(group)).to(units)
            total = total + 2 * torch.linalg.matrix_norm(excess).mean()
        return total
