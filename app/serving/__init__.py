"""The server: addresses, who may use them, the interface for programs, and the start."""
