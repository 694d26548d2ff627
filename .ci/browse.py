#!/usr/bin/env python3
"""Open every page of a site in Chromium, wide and narrow, light and dark, and say what is wrong.

A page is wrong if the browser's console has an error or a warning, if it asks for anything outside of the
site, or if it is wider than the window. A second argument is a folder for pictures of all pages.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from browser import browser, missing

MOST_MB = 15


def main(site: Path, pictures: Path | None) -> int:
    """Look at all pages; return the exit code."""
    size = sum(path.stat().st_size for path in site.rglob("*") if path.is_file()) / 1e6
    pages = sorted(path for path in site.rglob("*.html") if "_static" not in path.parts)
    wrong = [f"the site has {size:.1f} MB, more than {MOST_MB}"] if size > MOST_MB else []
    if lack := missing("chromium"):
        print(f"{lack}: pages are not opened", file=sys.stderr)
        pages = []
    for dark in (False, True) if pages else ():
        with browser("chromium", dark=dark) as window:
            for page in pages:
                name = page.relative_to(site)
                for width in (1280, 390):
                    window.open(page, width)
                    told = window.complaints()
                    told += [
                        url
                        for url in window.requests()
                        if not url.startswith((site.as_uri(), "data:", "blob:"))
                    ]
                    if (shown := window.run("document.documentElement.scrollWidth")) > width:
                        told.append(f"{shown} pixels wide")
                    wrong += [
                        f"{name}, {width} pixels, {'dark' if dark else 'light'}: {text}" for text in told
                    ]
                    if pictures:
                        shot = f"{'-'.join(name.with_suffix('').parts)}-{width}{'-dark' * dark}.png"
                        window.screenshot(pictures / shot, whole=width == 390)
    print("\n".join([*wrong, f"{len(pages)} pages, {size:.1f} MB: {len(wrong)} faults"]))
    return 1 if wrong else 0


if __name__ == "__main__":
    given = [Path(argument).resolve() for argument in sys.argv[1:]]
    sys.exit(main(given[0], given[1] if len(given) > 1 else None))
