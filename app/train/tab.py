"""The tab in Gradio's own components: settings, charts that grow with the epochs, the map.

The browser mounts the components when the tab is opened, and requests the choices of its set then;
Plotly is loaded with the first figure. A timer looks at a run, so no connection stays open.
"""

import json
import os
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from app.shared.fit import fit
from app.shared.requests import done, set_of
from app.shared.state import ForgottenError, Recent
from app.shared.visitor_sets import VisitorSets
from app.train import words
from app.train.plan import NUMBERS, ORDERS, WIDTHS, offered
from app.train.runs import KEPT_RUNS, Run, Trainings
from omnivat.data.domains import titled
from omnivat.kit.errors import DataError, OmniVatError

if TYPE_CHECKING:
    from gradio import Request

    from omnivat.figures.specs import Spec

TITLE = "Train here"
LOOK_S = 1.0  # between two looks at a run
WIDE = (700, 1100)  # CSS pixels of a page whose charts have two columns, or three
KEPT = "omnivat-trainings"  # the browser's record: {"visitor": a name, "runs": names of its runs}
COLOURS = ("domain", "class", "modality")
Changes = dict[Any, Any]  # component -> its changes


class TrainTab:
    """The tab of one Gradio page: its components and what their events do."""

    def __init__(self, sets: VisitorSets, tab: Any) -> None:
        import gradio as gr

        self.sets, self.runs, self.update = sets, Trainings(sets), gr.update
        # a page's newest run: a look may carry the record from before that run
        self.newest: Recent[str] = Recent(KEPT_RUNS)
        self.task = gr.HTML(words.task(()))
        with gr.Row(elem_classes="bench"):
            with gr.Column(scale=0, min_width=250, elem_classes="choices") as self.form:
                self.settings = self._settings(gr)
            with gr.Column(min_width=300, elem_classes="watching"):
                self.status = gr.HTML(words.status(words.FIRST))
                plot = partial(gr.Plot, show_label=False, visible=False)
                self.charts = plot(elem_id="train-charts")
                self.colour = gr.Radio(
                    [*COLOURS], value=COLOURS[0], label="Map of F̂, coloured by", visible=False
                )
                self.map = plot(elem_id="train-map")
                self.earlier = gr.HTML(visible=False)
        self.kept = gr.BrowserState(None, storage_key=KEPT, secret=KEPT)
        self.wide = gr.Number(0, visible=False)  # CSS pixels; 0 until the tab is opened
        self.timer = gr.Timer(LOOK_S, active=False)
        seen = (self.kept, self.wide, self.colour)
        once = "(before) => [before ? -before : innerWidth]"
        self._on(tab.select, self.opened, (self.wide,), js=once)
        self._on(self.go.click, self.begin, (*seen, *self.settings.values()))
        self._on(self.timer.tick, self.look, seen)
        self._on(self.colour.change, self.look, seen)
        self._on(self.stop.click, self.cancel, seen)

    def _settings(self, gr: Any) -> dict[str, Any]:
        """Lay out the settings; return their components by name."""
        components: dict[str, Any] = {}
        chosen = partial(gr.Dropdown, filterable=False)
        # the choices come with the set, and `plan_from` checks them
        components["source"] = gr.Dropdown([], label="Learn from", allow_custom_value=True)
        orders = [(text, name) for name, text in ORDERS.items()]
        components["order"] = chosen(orders, value="gradient", label="What p does")
        with gr.Row(elem_classes="acts"):
            self.go = gr.Button(  # pressed once there are choices
                "Train", variant="primary", elem_classes="go", interactive=False
            )
            self.stop = gr.Button("Cancel", visible=False, elem_classes="stop")
        with gr.Accordion("Advanced", open=False, elem_classes="advanced"):
            components["width"] = chosen([*WIDTHS], value=64, label="D, width")
            for name, (text, least, most, first) in NUMBERS.items():
                label = f"{text} ({least:g}\N{NO-BREAK SPACE}to\N{NO-BREAK SPACE}{most:g})"
                components[name] = gr.Number(first, label=label, elem_id=f"train-{name}")
            components["lang"] = gr.Checkbox(label="LANG guides the training", elem_id="train-lang")
        return components

    def _on(
        self, event: Any, work: Callable[..., Changes], given: Sequence[Any], **more: Any
    ) -> None:
        """Do `work` at an event, as a job of the visitor; a refusal becomes a sentence."""
        from gradio import Request, skip

        async def answered(request: Request, *values: Any) -> Any:
            try:
                job = partial(work, request, *values)
                return await done(request.request, self.sets.shared.jobs, job) or skip()  # type: ignore[arg-type]
            except OmniVatError as error:
                return {self.status: words.status(str(error), problem=True)}

        shown = [self.task, self.form, *self.settings.values(), self.go, self.stop, self.status]
        shown += [self.charts, self.colour, self.map, self.earlier]
        shown += [self.kept, self.wide, self.timer]
        more |= {"queue": False, "show_progress": "hidden", "api_visibility": "private"}
        event(answered, [*given], shown, **more)

    def opened(self, request: "Request", pixels: float) -> Changes:
        """Offer the choices of the visitor's set; nothing if the tab was opened before."""
        if pixels < 0:
            return {}
        resources = set_of(self.sets, request)
        try:
            domains, first, guided = offered(resources)
        except DataError as error:
            gone = self.update(visible=False)
            said = words.unfit(str(error), fit(resources))
            return {self.wide: pixels, self.form: gone, self.task: gone, self.status: said}
        found = {
            self.wide: pixels,
            self.task: words.task(resources.embeddings().header.domains),
            self.settings["source"]: self.update(
                choices=[(titled(name), name) for name in domains], value=first
            ),
            self.settings["lang"]: guided,
            self.go: self.update(interactive=True),
            self.timer: self.update(active=True),
        }
        if epochs := resources.head().metrics.get("epochs"):
            said = words.before(fits=not fit(resources)["problem"])
            found |= {self.status: words.status(said), self.charts: self._curves(epochs, pixels)}
        return found

    def begin(
        self, request: "Request", record: Any, pixels: float, by: Any, *values: Any
    ) -> Changes:
        """Start a training."""
        visitor, before = _kept(record)
        visitor = visitor or os.urandom(12).hex()
        question = dict(zip(self.settings, values, strict=True))
        key = self.runs.start(set_of(self.sets, request), question, visitor)
        self.newest.keep(request.session_hash or "", key)
        record = {"visitor": visitor, "runs": [*before, key][-KEPT_RUNS:]}
        return {self.kept: record} | self.look(request, record, pixels, by)

    def look(self, request: "Request", record: Any, pixels: float, by: Any) -> Changes:
        """Show the newest run as far as it is."""
        names = _kept(record)[1]
        newest = self.newest.get(request.session_hash or "")
        names += [newest] if newest and newest not in names else []
        if not names:
            return {self.timer: self.update(active=False)}
        try:
            run = self.runs.named(names[-1])
        except ForgottenError as error:
            record = {**record, "runs": []}
            return {self.status: words.status(str(error), problem=True), self.kept: record} | {
                self.timer: self.update(active=False),
                self.go: self.update(interactive=True),
                self.stop: self.update(visible=False),
            }
        there, active = run.job.state == "done", run.active
        found: Changes = {
            self.status: words.status(words.standing(run), run),
            self.timer: self.update(active=active),
            self.go: self.update(interactive=not active),
            self.stop: self.update(visible=active),
            self.colour: self.update(visible=there),
            self.map: self.update(visible=there, **({"value": _map(run, by)} if there else {})),
        }
        if run.epochs:
            plan = run.plan
            total, classes = plan.training.epochs, len(plan.settings.classes)
            found[self.charts] = self._curves(run.epochs, pixels, total=total, classes=classes)
        if table := words.earlier(self.runs.finished(names)):
            found[self.earlier] = self.update(value=table, visible=True)
        return found

    def cancel(self, request: "Request", record: Any, pixels: float, by: Any) -> Changes:
        """Stop the newest run."""
        names = _kept(record)[1]
        self.runs.named(names[-1] if names else "").job.cancel()
        return self.look(request, record, pixels, by)

    def _curves(self, epochs: Sequence[Any], pixels: float, **more: Any) -> Any:
        from omnivat.figures.specs import training_spec

        columns = 1 + sum(pixels > width for width in WIDE)
        drawn = training_spec(epochs, columns=columns, **more)
        return self.update(value=_sent(drawn), visible=True, elem_classes=f"columns-{columns}")


def _map(run: Run, by: Any) -> Any:
    """Return the map of a finished run as Gradio takes it."""
    from omnivat.figures.specs import map_spec
    from omnivat.figures.theme import CLASSES, DOMAINS, MODALITIES

    embeddings = run.plan.embeddings.header
    places, domain, label = run.map()
    groups: dict[Any, tuple[Any, Sequence[str], Sequence[str]]] = {
        "class": (label, embeddings.classes, CLASSES),
        "modality": ([0] * len(domain) + [1] * len(domain), ("photo", "touch"), MODALITIES),
        "domain": (domain, [titled(name) for name in embeddings.domains], DOMAINS),
    }
    group, names, colours = groups.get(by, groups["domain"])
    drawn = map_spec(places, group, names, title="", colours=colours)
    return _sent(drawn, margin={"l": 0, "r": 0, "t": 8, "b": 8}, height=520)


def _sent(drawn: "Spec", **layout: Any) -> Any:
    """Return a figure as Gradio sends it, without Plotly's own buttons."""
    from gradio.components.plot import PlotData

    from omnivat.figures.theme import template

    whole = drawn["layout"] | {"template": template("omnivat")} | layout
    sent = {"data": drawn["data"], "layout": whole, "config": {"displayModeBar": False}}
    return PlotData(type="plotly", plot=json.dumps(sent))


def _kept(record: Any) -> tuple[str, list[str]]:
    """Return a visitor's name and the names of its runs from what its browser kept."""
    found = record if isinstance(record, dict) else {}
    visitor, runs = found.get("visitor"), found.get("runs")
    names = [name for name in runs if isinstance(name, str)] if isinstance(runs, list) else []
    return visitor if isinstance(visitor, str) else "", names


build = TrainTab
