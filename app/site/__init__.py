"""The page as files: one document, or a folder that any file server serves."""
