"""Every route that computes ends when its visitor leaves, and at its time limit."""

from dataclasses import replace
from functools import partial

import pytest

from app.serving.api import WORK
from app.serving.routes import FACTS, PROJECT_FILES, QUESTIONS, SENT, routes
from app.shared.jobs import Jobs
from app.shared.messages import BusyError, CancelledError
from app.shared.requests import FILES as PICTURES
from app.shared.state import InTwo
from app.shared.visitor_sets import VisitorSets
from omnivat.head.predict_set import CHUNK
from omnivat.kit.progress import CHECK

from .conftest import LESSONS

PAIR = {"vis": "row:3", "tac": "row:3"}
MORE = [
    {"vis": f"row:{row}", "tac": f"row:{row}", "label": label}
    for row, label in ((42, "cork"), (74, "glass"))
]
# route -> question, and the fewest checkpoints inside; none for what reads a file or two
WORKING = {
    "pair": ({**PAIR, "with": ["familiar", "rivals"]}, 4),  # a map may be on its way
    "many": ({"pairs": [PAIR] * 7}, 7),
    "rivals": (PAIR, 1),
    "attention": (PAIR, 1),
    "tree": (PAIR, 1),
    "votes": ({}, 1),
    "neighbours": ({"stage": "f_hat", "point": 0}, 1),
    "ladder": ({}, 1),
    "known": ({"known": "none"}, 1),
    "journey": (PAIR, 0),  # under a second for all stops
    "predictions": ({"method": "nearest_mean"}, 1),
    "familiar": (PAIR, 2),
    "profile": ({"photos": ["row:3"]}, 0),
    "teach": ({"lessons": LESSONS}, 2 * len(LESSONS)),
    "curve": ({"lessons": [*LESSONS, *MORE]}, 3 * len(LESSONS)),
    "taught": ({"lessons": LESSONS}, len(LESSONS)),
    "save/set": ({"lessons": LESSONS}, len(LESSONS)),
    "save/head": ({"lessons": LESSONS}, len(LESSONS)),
    "save/sensor": ({}, 0),
    "save/figure": ({}, 0),
    "unseen": ({}, 2),
    **dict.fromkeys(
        ("about", "fit", "own", "heads", "modes", "first", "pairs", "toy", "examples"), ({}, 0)
    ),
}

# the other routes: files as they are; pictures and files of visitors, stopped below; jobs of their
# own with a limit, in `test_training`, and programs, whose tools are those of `WORK`
FILES = {
    "web/{name:path}",
    "frames",
    "plotly.js",
    "thumbnails.{kind}",
    "example/{name:path}/{modality}",
    "real",
    "head.zip",
    "real/{name:path}",
    "api/schema",
    *PROJECT_FILES,
}
PICTURED = ("live", "occlusion", "relief", "card")  # of pictures that come with the question
TOOLS = {"mcp", "api/{rest:path}", *(f"api/{tool}" for tool in WORK)}


class Leaving(Jobs):
    """Jobs that count checkpoints; at one of them the visitor leaves, or the time is over."""

    def __init__(self, at=-1, *, late=False):
        super().__init__()
        self.at, self.late, self.checks = at, late, 0

    def give(self, work):
        """Run work as the server does; return its result or raise its error."""

        def counted(job):
            check = job.check

            def at_checkpoint():
                self.checks += 1
                if self.checks == self.at and self.late:
                    job.left_s = -1.0
                elif self.checks == self.at:
                    job.cancelled = True
                check()

            CHECK.set(at_checkpoint)
            return work()

        return self.start(counted, lane="quick", deadline_s=1000).future.result(300)


@pytest.fixture(scope="module")
def work(small_places):
    """Return a function of a route's name: its work, for a new server."""
    from app.shared.resources import Resources

    def of(name):
        resources = Resources(replace(small_places, compare=(small_places.head,)))
        if name in FACTS:
            return partial(FACTS[name], resources)

        def whole():
            found = QUESTIONS[name](resources, WORKING[name][0])
            return found.rest() if isinstance(found, InTwo) else found

        return whole

    return of


def test_the_table_has_every_route_that_computes(resources):
    """A new route has to be entered in `WORKING`, which stops it, or be told why it is not."""
    assert {*WORKING, *PICTURED} == {*QUESTIONS, *FACTS}
    paths = {
        route.path.removeprefix("/omnivat/") for route in routes(VisitorSets(resources), api=True)
    }
    assert paths - set(WORKING) == FILES | {*SENT, *PICTURED, "part", "load"} | TOOLS


@pytest.mark.parametrize("name", [name for name, (_, inside) in WORKING.items() if inside])
def test_work_ends_at_the_checkpoint_after_its_visitor_left_or_its_time(work, name):
    whole = Leaving()
    whole.give(work(name))
    assert whole.checks >= WORKING[name][1]
    middle = (whole.checks + 1) // 2
    for late, error in ((False, CancelledError), (True, BusyError)):
        jobs = Leaving(middle, late=late)
        with pytest.raises(error):
            jobs.give(work(name))
        assert jobs.checks == middle


@pytest.mark.parametrize("reply", ["image", "live", "occlusion"])
def test_work_on_a_sent_picture_ends_so_too(resources, png, reply):
    whole = Leaving()

    def begun(seed):
        question = {"modality": "vis"}
        if reply in SENT:
            return partial(SENT[reply][0], resources, png(seed=seed), question)
        return partial(QUESTIONS[reply], resources, {**question, PICTURES: [png(seed=seed)]})

    first, second = begun(1), begun(2)
    whole.give(first)
    jobs = Leaving(whole.checks)
    with pytest.raises(CancelledError):
        jobs.give(second)


def test_a_large_set_is_checked_for_each_block(work, resources):
    """The pairs between two checkpoints are bounded, whatever the size of the set."""
    jobs = Leaving()
    jobs.give(partial(FACTS["unseen"], resources))
    assert len(resources.embeddings()) / jobs.checks <= CHUNK
