"""One table of terms: the page's definitions and docs/glossary.md."""

import json
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TERMS = json.loads((ROOT / "app/web/shared/glossary.json").read_text(encoding="utf-8"))


def test_the_glossary_holds_the_terms_of_the_page_word_for_word():
    rows = "".join(f"| {term} | {sentence} |\n" for term, sentence in TERMS.items())
    table, _ = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").split("\n## Letters\n")
    assert table.endswith(f"| term | meaning |\n| --- | --- |\n{rows}")


def test_a_sentence_of_the_glossary_ends_without_a_stop_and_fits_a_small_panel():
    assert [
        term for term, sentence in TERMS.items() if sentence.endswith(".") or len(sentence) > 130
    ] == []
