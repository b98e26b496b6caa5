"""The two gaps of the default set, raw and after the head, at three orders.

python -m examples.two_gaps
"""

from omnivat import default_embeddings, default_head, load_embeddings, load_head, sweep

head = load_head(default_head())
embeddings = load_embeddings(default_embeddings())
orders = [0.0, head.model.order, 1.0]
found = sweep(head.model, embeddings, orders, stages=("frft", "relu", "f_hat"))

print(f"{len(embeddings)} pairs, simulated: {embeddings.header.simulated}")
print(f"{'':<22}" + "".join(f"p = {p:<8.3f}" for p in orders))
for name in ("modality_gap/frft", "modality_gap/relu", "modality_gap/f_hat", "domain_gap/f_hat"):
    print(f"{name:<22}" + "".join(f"{value:<12.3f}" for value in found.curves[name]))
print(f"{'accuracy':<22}" + "".join(f"{v:<12.3f}" for v in found.curves["accuracy/all"]))
