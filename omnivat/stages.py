"""The stages of the head that can be seen, in their order."""

STAGES = ("raw", "frft", "relu", "f_bar", "f_hat")
# Raw embedding and raw DFrFT do not depend on the order: the transform is unitary, so every
# distance and cosine stays.
STILL = ("raw", "frft")
