"""Train here: choose settings, watch a head learn, use it. `app.train` does the work."""

from app.train.tab import TrainTab

TITLE = "Train here"
build = TrainTab
