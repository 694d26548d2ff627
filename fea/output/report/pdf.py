"""A page as PDF, printed by a Chromium of this machine without a window."""

import os
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from fea.output.target import PictureError

# Programs of the Chromium family, by the names that systems give them; macOS keeps them out of the path.
_PROGRAMS = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge",
    "microsoft-edge", "brave-browser",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)  # fmt: skip
_PATIENCE = 120.0  # seconds


def write_pdf(page: Path, pdf: Path) -> None:
    """Print a page. Raises `PictureError`: there is no Chromium, or it wrote nothing; says what to do."""
    program = next((found for name in _PROGRAMS if (found := shutil.which(name))), None)
    by_hand = f"Open {page} in any browser and print it into a file."
    if program is None:
        raise PictureError(f"No Chromium, Chrome or Edge was found to print {page}. {by_hand}")
    with TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        made = Path(profile, pdf.name)
        options = ["--headless", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={profile}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:  # its sandbox refuses the superuser
            options.append("--no-sandbox")
        command = [program, *options, f"--print-to-pdf={made}", page.absolute().as_uri()]
        try:
            subprocess.run(command, capture_output=True, check=True, timeout=_PATIENCE)  # noqa: S603 - a browser
            written = made.read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise PictureError(
                f"{program} could not print {page} ({type(error).__name__}). {by_hand}"
            ) from error
    pdf.write_bytes(written)
