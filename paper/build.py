"""Build the report: paper.html, and paper.pdf where Chromium is at hand.

python paper/build.py [--out build/paper]
"""

import argparse
import shutil
import subprocess
from pathlib import Path

import pypandoc

HERE = Path(__file__).resolve().parent
OPTIONS = ("--citeproc", "--standalone", "--embed-resources", "--mathml", f"--resource-path={HERE}")
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def build(folder: Path) -> list[Path]:
    """Write the report into a folder; return its files."""
    folder.mkdir(parents=True, exist_ok=True)
    page = folder / "paper.html"
    pypandoc.convert_file(
        str(HERE / "paper.md"),
        "html",
        outputfile=str(page),
        extra_args=list(OPTIONS),
        cworkdir=str(HERE),
    )
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        return [page]
    sheet = folder / "paper.pdf"
    flags = ["--headless", "--no-sandbox", "--no-pdf-header-footer", f"--print-to-pdf={sheet}"]
    subprocess.run([browser, *flags, page.resolve().as_uri()], check=True, capture_output=True)
    return [page, sheet]


def main() -> None:
    """Build both files and print their names."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("build/paper"), help="folder")
    print(*build(parser.parse_args().out), sep="\n")


if __name__ == "__main__":
    main()
