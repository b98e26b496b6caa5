"""The five common materials, and the rules for other names."""

import json
import re
import unicodedata
from dataclasses import dataclass
from functools import cache
from pathlib import Path

MATERIALS = ("wood", "steel", "plastic", "ceramic", "glass")
NO_CLASS = "unlabelled"  # of pairs without a class
RULES_FILE = Path(__file__).with_name("materials.json")


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """One name in one source, its material, and the reason (see materials.json)."""

    source: str  # "touch_and_go", "objectfolder" or "tacquad"
    raw: str  # the source's spelling, in lower case
    named: str  # in words: label 4 is metal
    material: str  # one of MATERIALS, or "" if left out
    merged: bool  # True for merged materials; strict reading skips them
    grade: str  # "read" in a public source, "inferred" or "chosen"
    why: str


@cache
def rules(source: str) -> dict[str, Rule]:
    """Return the rules of one source by its own names."""
    written = json.loads(RULES_FILE.read_text(encoding="utf-8"))["rules"]
    return {rule["raw"]: Rule(**rule) for rule in written if rule["source"] == source}


def ruled(rule: Rule | None, raw: str, *, strict: bool) -> tuple[str, str]:
    """Return the material of a rule, or "" and the reason for leaving it out."""
    if rule is None or not rule.material:
        return "", f"{raw or 'no material'}: none of the five materials"
    if strict and rule.merged:
        return "", f"strict: {rule.named} is not {rule.material} itself"
    return rule.material, ""


def class_key(name: str) -> str:
    """Return the normalized class name: "Wood", "wood " and "WOOD" all give "wood".

    Case, extra blanks and compatible Unicode forms make no difference.
    """
    return " ".join(unicodedata.normalize("NFKC", name).casefold().split())


def in_order(names: set[str]) -> tuple[str, ...]:
    """Return class names, the five materials first in their usual order, then the others sorted."""
    return (*(name for name in MATERIALS if name in names), *sorted(names.difference(MATERIALS)))


def rules_in_text(text: str, source: str, *, glued: bool = False) -> tuple[Rule, ...]:
    """Return the rules whose word occurs in a text, one for each material.

    text   an item's name or caption; words are runs of letters, in any case
    glued  also find a word at the start or the end of another: "glasscup"

    Words of five or more letters may have one typing error: two swapped neighbours ("galss"), a
    missing letter ("platic") or a doubled one ("woodden"), but no wrong letter: "grass" is not
    glass. Of several rules for one material, one that is not merged has priority.
    """
    table = rules(source)
    found: dict[str, Rule] = {}
    for word in re.findall(r"[^\W\d_]+", class_key(text)):
        for rule in table.values():
            if not _stands_for(word, rule.raw, glued):
                continue
            if rule.material not in found or found[rule.material].merged:
                found[rule.material] = rule
    return tuple(found.values())


def _stands_for(word: str, raw: str, glued: bool) -> bool:
    if word in (raw, raw + "s"):
        return True
    if glued and len(word) >= len(raw) + 3 and (word.startswith(raw) or word.endswith(raw)):
        return True
    return min(len(word), len(raw)) >= 5 and word in _slips(raw)


@cache
def _slips(raw: str) -> frozenset[str]:
    cuts = [(raw[:i], raw[i:]) for i in range(len(raw))]
    doubled = {a + b[0] + b for a, b in cuts}
    missing = {a + b[1:] for a, b in cuts if len(raw) > 5}
    swapped = {a[:-1] + b[0] + a[-1] + b[1:] for a, b in cuts[1:]}
    return frozenset(doubled | missing | swapped) - {raw}
