"""The visible stages of the head, in order."""

STAGES = ("raw", "frft", "relu", "f_bar", "f_hat")
# Raw embedding and raw DFrFT have the same distances and cosines at every order, because the
# transform is unitary.
STILL = ("raw", "frft")
