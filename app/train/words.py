"""Train here in words: how far a run is, its result, the runs of a visit. Runs in, markup out."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from app.shared.messages import readable
from app.shared.tables import tables
from app.train.runs import Run
from omnivat.data.domains import titled

MEASURED = {"accuracy/unseen": "accuracy, unseen", "modality_gap/f_hat": "modality gap"}
MEASURED["domain_gap/f_hat"] = "domain gap"
TASK = (
    "<b>Train a head on one domain, and watch it meet the others.</b> Dotted lines show guessing."
)
ALONE = (
    "<b>Train a head on this domain.</b> The set has no other, so accuracy away from home stays"
    " unknown."
)
FIRST = "Nothing has been trained yet."
# the mode of p whose frames are the head's own
OWN = next((row["id"] for row in tables()["modes"] if "own" in row["can"]), "")


def standing(run: Run) -> str:
    """Return how far a run is, and how many pairs of its source have no class."""
    job, total, done = run.job, run.plan.training.epochs, len(run.epochs)
    if job.state == "failed":
        return readable(job.problem)
    if job.state == "cancelled":
        return f"Cancelled after {done} of {total} epochs."
    step, queue = job.step, job.place
    if job.state == "waiting":
        queued = f": place {queue} in the queue. One training runs at a time" if queue else ""
        words = f"Waiting{queued}"
    elif job.state == "done":
        words = f"Done: {total} epochs"
    elif done >= total:
        words = "Calibrating probabilities on held-out pairs"
    elif done and step:
        words = f"Training: {step.text} of {total}" + (f", {step.left}" if step.left else "")
    else:
        words = f"Starting: {step.text if step else 'loading'}"
    lost = run.plan.left_out
    subject = "1 pair without a class is" if lost == 1 else f"{lost} pairs without a class are"
    return f"{words}." + (f" {subject} left out." if lost else "")


def status(sentence: str, run: Run | None = None, *, problem: bool = False) -> str:
    """Return the panel of a sentence; of a run, with its progress and what its head offers."""
    parts = [f'<p class="status" role="status">{escape(readable(sentence))}</p>']
    if run and run.active:
        done, total = len(run.epochs), run.plan.training.epochs
        parts.append(f'<progress value="{done / total}" aria-label="Epochs"></progress>')
    if run and run.loaded:
        parts.append(
            f'<span class="row"><a class="button main use" href="?set={run.loaded}&mode={OWN}">Open'
            f' it in Explore</a><a class="button save" href="omnivat/head.zip?set={run.loaded}"'
            ' download="trained-head.zip">Download the head</a><span class="hint">It is loaded for'
            " this visit only.</span></span>"
        )
    kind = "wait problem" if problem else "panel stand"
    whence = _provenance(run) if run and run.epochs else ""
    return f'<section class="ov train"><div class="{kind}">{"".join(parts)}</div>{whence}</section>'


def _provenance(run: Run) -> str:
    where = "its own test pairs."
    if _newest(run, "accuracy/unseen") is not None:
        where = (
            "the test pairs of the unseen domains (their mean). The model was given nothing from"
            " these domains."
        )
    return (
        f'<p class="provenance">Measured with this run’s head (D&nbsp;=&nbsp;'
        f"{run.plan.settings.width}), trained on {escape(titled(run.plan.source))} and tested on"
        f" {where}</p>"
    )


def before(*, fits: bool) -> str:
    """Return what the charts show before a run."""
    head = "the loaded head" if fits else "a head for another set"
    return f"{FIRST} Below: how {head} was trained; yours adds accuracy, gaps and a map."


def unfit(problem: str, remedy: Mapping[str, str]) -> str:
    """Return why nothing can be trained on a set, and a remedy as `app.shared.fit` has it."""
    more = (
        f'<div class="panel headless"><p>{escape(remedy["remedy"])}</p><pre tabindex="0">'
        f"{escape(remedy['command'])}</pre></div>"
    )
    return (
        f'<section class="ov train"><div class="wait problem">{escape(readable(problem))}</div>'
        f"{more if remedy['command'] else ''}</section>"
    )


def task(domains: Sequence[str]) -> str:
    """Return the task of the tab for a set of these domains."""
    words = ALONE if len(domains) == 1 else TASK
    return f'<section class="ov train"><p class="explain task">{words}</p></section>'


def earlier(runs: Sequence[Run]) -> str:
    """Return the finished runs of a browser as a table, and how the last two differ."""
    if not runs:
        return ""
    head = "".join(f"<th>{words}</th>" for words in ("Settings", "p", *MEASURED.values()))
    rows = "".join(
        f"<tr><th scope=row>{escape(run.words)}</th><td>{run.epochs[-1]['order']:.3f}</td>"
        + "".join(f"<td>{_figure(name, _newest(run, name))}</td>" for name in MEASURED)
        + "</tr>"
        for run in runs
    )
    return (
        '<section class="ov train"><div class="panel earlier"><h2>Trained in this visit</h2>'
        '<div class="scroll" tabindex="0" role="group" aria-label="Trained in this visit">'
        f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
        '<p class="hint">Each over the same pairs as above.</p>'
        f'<p class="difference">{_compared(runs)}</p></div></section>'
    )


def _compared(runs: Sequence[Run]) -> str:
    shares = [_newest(run, "accuracy/unseen") for run in runs[-2:]]
    if len(shares) < 2 or None in shares:
        return ""
    points = 100 * (shares[1] - shares[0])
    return (
        f"The last run is {abs(points):.1f} points {'below' if points < 0 else 'above'} the one"
        " before it. Train the same settings with other seeds to see how much is chance."
    )


def _newest(run: Run, name: str) -> Any:
    """Return the newest value of a measure; None without any."""
    found: Sequence[Mapping[str, Any]] = [epoch for epoch in run.epochs if name in epoch]
    return found[-1][name] if found else None


def _figure(name: str, value: float | None) -> str:
    if value is None:
        return "–"
    return f"{100 * value:.1f} %" if name.startswith("accuracy") else f"{value:.2f}"
