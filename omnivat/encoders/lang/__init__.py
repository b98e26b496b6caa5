"""Text (LANG): prompts, the encoders that embed them, and the bank of embeddings for training."""
