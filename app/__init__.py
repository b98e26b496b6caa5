"""The page: it shows what the library computes and computes nothing of its own."""
