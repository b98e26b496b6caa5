"""Example pairs: `<domain>/<class>/<name>_{vis,tac}.(png|webp|jpg)`."""

from dataclasses import dataclass
from pathlib import Path

from omnivat.data.domains import is_simulated
from omnivat.errors import DataError

ENDINGS = (".png", ".webp", ".jpg", ".jpeg")


@dataclass(frozen=True, slots=True, kw_only=True)
class Example:
    """One example: a pair of image files."""

    name: str  # "TAG-sim/wood/a": unique
    domain: str
    material: str
    vis: Path
    tac: Path

    def file(self, modality: str) -> Path:
        """Return the file of "vis" or "tac"."""
        return self.vis if modality == "vis" else self.tac


def find_examples(folder: Path) -> dict[str, Example]:
    """Return the complete pairs under `folder` by name; a missing folder has none."""
    found = {}
    for vis in sorted(folder.glob("*/*/*_vis.*")):
        if vis.suffix.lower() not in ENDINGS:
            continue
        stem = vis.stem.removesuffix("_vis")
        tacs = [p for p in vis.parent.glob(f"{stem}_tac.*") if p.suffix.lower() in ENDINGS]
        if not tacs:
            continue
        domain, material = vis.parent.parent.name, vis.parent.name
        name = f"{domain}/{material}/{stem}"
        found[name] = Example(name=name, domain=domain, material=material, vis=vis, tac=tacs[0])
    return found


def example_named(examples: dict[str, Example], name: str) -> Example:
    """Return the example called `name`.

    Raises DataError if there is none.
    """
    if name not in examples:
        raise DataError(f"No example is called '{name:.80}'; pick one of the gallery.")
    return examples[name]


def listed(examples: dict[str, Example]) -> list[dict[str, object]]:
    """Return the gallery's data for each example."""
    return [
        {"name": one.name, "domain": one.domain, "class": one.material, "simulated": is_simulated(one.domain)}
        for one in examples.values()
    ]
