"""Looks up every link and anchor of a site, without a network; prints how many there are."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """What a page links to, and what in it can be linked to."""

    def __init__(self, file):
        super().__init__()
        self.links = []
        self.ids = set()
        self.feed(file.read_text())

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids |= {found[name] for name in ("id", "name") if found.get(name)}
        for name in ("href", "src", "poster"):
            # `<base>` is what an error page has for links from any folder.
            if found.get(name) and tag != "base":
                self.links.append(found[name])


def problem(file, link, site, pages):
    """Why a link leads nowhere; None if it does not."""
    parts = urlsplit(link)
    if parts.scheme in ("http", "https", "mailto", "data"):
        return None
    target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    if not target.is_relative_to(site):
        return "leaves the site"
    if not target.is_file():
        return "leads to no file"
    fragment = unquote(parts.fragment)
    if fragment and target in pages and fragment not in pages[target].ids:
        return "leads to no place on its page"
    return None


def main():
    site = Path(sys.argv[1]).resolve()
    pages = {file: Page(file) for file in site.rglob("*.html")}
    broken = []
    count = 0
    for file, page in pages.items():
        for link in page.links:
            count += 1
            if why := problem(file, link, site, pages):
                broken.append(f"{file.relative_to(site)}: {link} {why}")
    if broken:
        sys.exit("\n".join(broken))
    print(count)


main()
