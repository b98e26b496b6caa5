"""Records of runs with scores that a person can average."""

DATA = {
    "encoder": "efficientnet-lite0",
    "weights_hash": "0" * 16,
    "simulated": True,
    "origin": "made by a test",
}


def record(method, source, seed, values, **changes):
    """Return a record with one target for each value of ACC; Macro-F1 is 0.1 lower."""
    scores = [
        {"accuracy": v, "macro_f1": v - 0.1, "macro_f1_union": v - 0.2, "ece": 0.05} for v in values
    ]
    return {
        "method": method,
        "label": {"omnivat": "OmniVaT"}.get(method, method),
        "note": "",
        "source": source,
        "part": "",
        "seed": seed,
        "data": DATA,
        "versions": {"torch": "2"},
        "parameters": 10,
        "seconds": 1.0,
        "missing_targets": [],
        "targets": {
            f"target {i}": {"part": "", "pairs": 9, "scores": {"fused": s, "vis": s, "tac": s}}
            for i, s in enumerate(scores)
        },
    } | changes


def answered_record(method, source, seed, share, *, reading_shares=None):
    """Return a record with kept predictions: of 40 objects of two classes, a share is right."""
    truth = "0" * 20 + "1" * 20

    def answers(right):
        count = round(20 * right)
        return ("0" * count + "1" * (20 - count)) + ("1" * count + "0" * (20 - count))

    readings = {"fused": share, "vis": share, "tac": 0.5} | (reading_shares or {})
    scores = {
        n: {"accuracy": v, "macro_f1": v, "macro_f1_union": v, **dict.fromkeys(MEASURES, 0.1)}
        for n, v in readings.items()
    }
    target = {
        "part": "",
        "pairs": 40,
        "scores": scores,
        "margins": {"vis": 0.1, "tac": None, "pair": 0.2},
        "truth": truth,
        "objects": "0-39",
        "answers": {n: answers(v) for n, v in readings.items()},
    }
    return record(method, source, seed, [], targets={"t": target}, classes=["a", "b"])


MEASURES = ("ece", "nll", "aurc")


def grid(method, share, **changes):
    return [
        answered_record(method, source, seed, share, **changes)
        for source in ("A", "B", "C")
        for seed in (0, 1)
    ]
