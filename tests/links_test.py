#!/usr/bin/env python3
"""Links between the pages of the project lead somewhere, and what they quote stands there.

    links_test.py SOURCE_DIR

Every relative link of every .md file must name a file or folder that is there, and a heading of it where it names one. A
fenced block marked ```LANGUAGE PATH quotes that file: its lines must stand there, one after another.
Exit status 1 and a line for each finding.
"""
import pathlib
import re
import sys

LINK = re.compile(r"\[[^\]\n]*\]\(([^)\s]+)\)")


def anchors(page):
    """The anchors that a page's headings make: lower case, punctuation gone, blanks to hyphens."""
    found = set()
    for line in page.read_text(encoding="utf-8").splitlines():
        heading = re.match(r"#+\s+(.*)", line)
        if heading:
            found.add(re.sub(r"[^\w\- ]", "", heading[1].lower()).replace(" ", "-"))
    return found


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    findings, links, quotes = [], 0, 0
    for page in sorted(root.rglob("*.md")):
        if "build" in page.relative_to(root).parts or ".git" in page.parts:
            continue
        fenced, quoted, quote = False, None, []
        for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
            if line.lstrip().startswith("```"):
                if quoted is not None and "\n".join(quote) not in quoted:
                    findings.append(f"{page.relative_to(root)}:{number}: what is quoted above does not stand there")
                fenced = not fenced
                words = line.strip().split()
                source = root / words[1] if fenced and len(words) == 2 else None
                quoted, quote = None, []
                if source is not None:
                    quotes += 1
                    if source.is_file():
                        quoted = source.read_text(encoding="utf-8")
                    else:
                        findings.append(f"{page.relative_to(root)}:{number}: {words[1]} is not there")
                continue
            if fenced:
                quote.append(line)
                continue
            for target in LINK.findall(line):
                if re.match(r"[a-z]+:", target):
                    continue
                links += 1
                name, _, anchor = target.partition("#")
                place = (page.parent / name).resolve() if name else page
                if not place.exists() or not place.is_relative_to(root):
                    findings.append(f"{page.relative_to(root)}:{number}: {target} is not there")
                elif anchor and anchor not in anchors(place):
                    findings.append(f"{page.relative_to(root)}:{number}: {name or page.name} has no heading {anchor}")
    print("\n".join(findings) or f"{links} links lead somewhere, {quotes} quotes are true")
    return 1 if findings or links == 0 or quotes == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
