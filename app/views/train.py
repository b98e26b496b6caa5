"""Train here: choose settings, watch a head learn, use it. `app.training` does the work."""

TITLE = "Train here"
