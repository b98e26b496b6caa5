"""My sensor: the profile of a visitor's unlabelled pictures.

A profile is mean and variance of each embedding channel; no picture is in it. Requests name it, and
`app.shared.pair_input` then moves uploaded images onto the statistics of the head's source.
"""

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from app.pair.pictures import decoded
from app.shared.mend import mend_in, way_in
from app.shared.pair_input import profile_in
from app.shared.requests import FILES
from app.shared.resources import Resources
from app.shared.state import Question, Reply, Unread, content_name, ref_from
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from omnivat.data.profile import Profile
    from omnivat.data.relief import Lamps

MOST_AT_ONCE = 100  # pictures of one request; a page with more sends several
DOMAIN = "My sensor"


def profile(resources: Resources, question: Question) -> Reply:
    """Make a profile of uploaded images, or add them to one.

    question  {"photos", "touches": references, at most MOST_AT_ONCE; "profile": one to add to}
    return    `profile`, its name, `counts` of pictures by modality, how touches are mended

    Pictures that came with the question and cannot be read are left out. A new profile of touches
    alone holds their lamps, if they give some.

    Raises DataError for no images or too many, or a head without its source's profile.
    """
    import numpy as np

    from omnivat.data.profile import Profile, channels_of, joined
    from omnivat.data.relief.files import TOUCH

    source = resources.head().source_profile
    before = profile_in(resources, question)
    given = {"vis": question.get("photos") or [], "tac": question.get("touches") or []}
    if not all(isinstance(some, list) and all(some) for some in given.values()):
        raise DataError("photos and touches have to be lists of uploaded pictures.")
    if not 0 < sum(map(len, given.values())) <= MOST_AT_ONCE:
        raise DataError(f"Send 1 to {MOST_AT_ONCE} pictures of your sensor at a time.")
    channels, mend = dict(before.channels) if before else {}, mend_in(question)
    gel = None if before or given["vis"] else _lamps(resources, question)
    relit = gel if resources.touch != TOUCH[0] else None  # they were read before it was known
    for name, some in given.items():
        pictures = [picture for picture in some if not isinstance(picture, Unread)]
        refs = [ref for ref in map(ref_from, pictures) if ref]
        if relit and name == "tac":
            taken = _readable(question, lambda file: resources.take_image(file, "", mend, relit))
            refs = [ref for ref, _ in taken]
        rows = [resources.embedding(ref, name, mend) for ref in refs]
        if rows:
            found = channels_of(np.stack(rows))
            channels[name] = joined(channels[name], found) if name in channels else found
    if not channels:
        # raises the reason why the first cannot be read
        ref_from(next(picture for some in given.values() for picture in some))
    made = Profile(channels=channels, key=source.key, domain=DOMAIN, way=way_in(mend), lamps=gel)
    kept = _kept(resources, replace(before, channels=channels) if before else made)
    return {**kept, "mend": mend}


def _lamps(resources: Resources, question: Question) -> "Lamps | None":
    """Return the lamps of the touches that came with a question; None if they give none."""
    import numpy as np

    from omnivat.data.relief import lamps

    images = _readable(question, lambda file: decoded(resources, file, question))
    try:
        return lamps(map(np.asarray, images))
    except DataError:
        return None


def _readable(question: Question, read: "Callable[[bytes | Path], Any]") -> "Iterator[Any]":
    """Yield what `read` makes of each file of a question that is a picture."""
    for file in question.get(FILES, ()):
        with suppress(DataError):
            yield read(file)


def save_sensor(resources: Resources, question: Question) -> bytes:
    """Return the profile named in a request as a file for the page and for `--profile`."""
    from omnivat.data.profile_file import save_profile

    found = profile_in(resources, question)
    if found is None:
        raise DataError("There is no profile of your sensor yet; give it pictures first.")
    with TemporaryDirectory(prefix="omnivat-save-") as folder:
        file = Path(folder) / "my-sensor.safetensors"
        save_profile(file, found)
        return file.read_bytes()


def load_sensor(resources: Resources, file: Path, _: Question) -> Reply:
    """Keep a saved profile; return as `profile` does. Raises DataError if it does not fit the
    head.
    """
    from omnivat.data.profile import require_key
    from omnivat.data.profile_file import load_profile

    source = resources.head().source_profile
    found = load_profile(file).read_by(source.key)
    require_key(found, source.key, source.width)
    return _kept(resources, found)


def from_the_start(resources: Resources) -> Reply:
    """Return the profile of --profile as `load_sensor` does; {} without one."""
    return load_sensor(resources, resources.where.profile, {}) if resources.where.profile else {}


def _kept(resources: Resources, profile: "Profile") -> Reply:
    from omnivat.data.relief.files import TOUCH, packed

    parts = [
        (channel.mean.tobytes(), channel.variance.tobytes())
        for channel in profile.channels.values()
    ]
    lamps = packed(profile.lamps) if profile.lamps else ""
    rest = (profile.domain, profile.step, profile.way, lamps)
    name = content_name(repr([profile.counts, *parts, rest]).encode())
    resources.profiles.keep(name, profile)
    # touches are then read again, by these lamps
    lit = resources.touch != TOUCH[0] and profile.lamps is not None
    return {"profile": name, "counts": profile.counts, "mend": profile.way, "lit": lit}
