"""Pages as files: HTML, or PDF as a browser prints it."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from lumped.errors import OptionError
from lumped.support.whole_files import whole_file, write_text

_PROGRAMS = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
)
_SECONDS = 120


def find_printer(path: Path) -> str | None:
    """The browser that prints a file .pdf: $LUMPED_CHROMIUM, or on the PATH; None for HTML.

    Raises
    ------
    OptionError
        If there is none, or the file is neither.
    """
    if path.suffix.lower() in (".html", ".htm"):
        return None
    if path.suffix.lower() != ".pdf":
        raise OptionError(f"{path.name}: a report is a page .html or .pdf; name one of these.")
    given = os.environ.get("LUMPED_CHROMIUM")
    for program in (given,) if given else _PROGRAMS:
        if found := shutil.which(program):
            return found
    missing = f"LUMPED_CHROMIUM = {given!r} is no program" if given else "none is on the PATH"
    raise OptionError(
        f"{path.name}: Chromium, Chrome or Edge prints a PDF, and {missing}. {_by_hand(path)}"
    )


def write_page(path: Path, html: str, printer: str | None) -> None:
    """Write a page, whole or not at all; a printer, from `find_printer`, makes a PDF of it.

    Raises
    ------
    OptionError
        If the printer makes none.
    """
    if printer is None:
        write_text(path, html)
        return
    # beside the file: a browser in a container of its own does not see the usual temporary folder
    with tempfile.TemporaryDirectory(
        prefix="lumped-print-", dir=path.absolute().parent, ignore_cleanup_errors=True
    ) as folder:
        page, printed = Path(folder, "page.html"), Path(folder, "page.pdf")
        page.write_text(html, encoding="utf-8")
        is_root = hasattr(os, "geteuid") and os.geteuid() == 0
        command = [printer, "--headless", "--disable-gpu", "--no-pdf-header-footer"]
        command += ["--no-sandbox"] * is_root  # without it Chromium refuses to run for root
        command += [f"--user-data-dir={folder}/profile", f"--print-to-pdf={printed}", page.as_uri()]
        try:
            done = subprocess.run(command, capture_output=True, timeout=_SECONDS, check=False)
            told = done.stderr.decode(errors="replace").strip().splitlines()
        except (OSError, subprocess.TimeoutExpired) as fault:
            told = [str(fault)]
        made = printed.read_bytes() if printed.is_file() else b""
    if not made.startswith(b"%PDF-"):
        why = told[-1] if told else "it says nothing"
        raise OptionError(f"{path.name}: {printer} printed no PDF ({why}). {_by_hand(path)}")
    with whole_file(path) as file:
        file.write(made)


def _by_hand(path: Path) -> str:
    return f"Write {path.stem}.html instead, open it in any browser and print it to a file."
