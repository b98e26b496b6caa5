"""The joint loss: MMA + NOD + cross-entropy."""
