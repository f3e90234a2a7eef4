#!/usr/bin/env python3
"""Fails when a page or a comment points to a file, to a heading of a page, or to a name that does not exist.

    scripts/check_links.py [ROOT]

In Markdown files: relative links (what is on other servers changes without us), and paths from the root that stand as
`src/core/csv.cpp` in the text. In sources: the same paths in comments, as docs/effects.md.

In comments of C++ (but /*argument=*/): camelCase and kNames, snake_case in `backticks` or before a "(", each without its
unit and number (`dead_band_rad_s`), which no code or string has; files *.h and *.cpp that are neither here nor included.
Symbols of equations, of one letter before a "_", are no names.
"""
import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"\]\(([^()\s]+)\)")
HEADING = re.compile(r"^#+ +(.*?)\s*$")
ELSEWHERE = re.compile(r"[a-z]+:")
PATH = re.compile(r"`((?:cmake|configs|data|docs|include|scripts|src|tests)/[\w./*-]+)")
COMMENT_PATH = re.compile(
    r"(?:#|//).*?\b((?:cmake|configs|docs|include|scripts|src|tests)/[\w./-]+\.(?:cpp|h|md|py|yaml))\b")
TOKEN = re.compile(r'R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?P<comment>//[^\n]*|/\*.*?\*/)', re.S)
SNAKE = r"[a-z]{2,}\d*(?:_\w{2,})+"
NAME = re.compile(rf"(?<![\w./<*-])([a-z]{{2,}}\d*(?:[A-Z][a-z0-9]+)+|k[A-Z][a-z]\w*|{SNAKE}(?=\()|(?<=`){SNAKE}(?=`))")
UNIT = re.compile(r"\d+$|_(?:rad|deg|m|mm|s|ms|Hz|kg|N|Nm|A|V|Pa|W|K|ohm|degC|percent|m2|s2|\d+)$")
CPP_FILE = re.compile(r"\b(\w+\.(?:h|cpp))\b")
PLACEHOLDER = re.compile(r"[A-Z]{4}")  # src/model/effects/NAME.cpp


def prose(page):
    """The numbered lines of a page that are not in a block of code."""
    in_code = False
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            in_code = not in_code
        elif not in_code:
            yield number, line


def anchors(page):
    """Names of a page's headings as forges make them: lower case, without punctuation, spaces as hyphens."""
    known = set()
    for _, line in prose(page):
        if match := HEADING.match(line):
            text = re.sub(r"\]\([^)]*\)", "", match.group(1).lower())
            name = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
            repeats = sum(1 for other in known if re.fullmatch(re.escape(name) + r"(-\d+)?", other))
            known.add(f"{name}-{repeats}" if repeats else name)
    return known


def missing(path, root):
    return not PLACEHOLDER.search(path) and not any(root.glob(path.rstrip("/.")))


def broken(page, root):
    for number, line in prose(page):
        for path in PATH.findall(line):
            if missing(path, root):
                yield number, f"{path} does not exist"
        for link in LINK.findall(re.sub(r"`[^`]*`", "", line)):
            if ELSEWHERE.match(link):
                continue
            path, _, anchor = link.partition("#")
            target = page.parent / path if path else page
            if not target.exists():
                yield number, f"{path} does not exist"
            elif anchor and anchor not in anchors(target):
                yield number, f"{path or page.name} has no heading #{anchor}"


def broken_comments(source, root):
    for number, line in enumerate(source.read_text(encoding="utf-8").splitlines(), 1):
        for path in COMMENT_PATH.findall(line):
            if "#include" not in line and missing(path, root):
                yield number, f"{path} does not exist"


def exists(name, known):
    while name not in known and UNIT.search(name):
        name = UNIT.sub("", name)
    return name in known


def broken_names(sources):
    """Names and files that stand in comments of C++ and nowhere else: neither in its code nor in another language."""
    cpp = [source for source in sources if source.suffix in (".h", ".cpp")]
    texts = {source: source.read_text(encoding="utf-8") for source in cpp}
    names = {source.name for source in cpp}
    known = set(re.findall(r"\w+", " ".join(f.read_text(encoding="utf-8") for f in sources if f not in texts)))
    for source, text in texts.items():
        known.update(re.findall(r"\w+", TOKEN.sub(lambda match: " " if match["comment"] else match[0], text)))
        names.update(re.findall(r"#include <(?:.*/)?(.*)>", text))
    for source, text in texts.items():
        for match in TOKEN.finditer(text):
            comment, number = match["comment"] or "", text.count("\n", 0, match.start()) + 1
            yield from ((source, number, f"nothing is called {name}") for name in NAME.findall(comment)
                        if not exists(name, known))
            yield from ((source, number, f"{name} does not exist") for name in CPP_FILE.findall(comment)
                        if name not in names)


def files(root, *patterns):
    """What is tracked or could be, relative to the root."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", *patterns], cwd=root, capture_output=True,
                            text=True, check=True).stdout.splitlines()
    return [root / name for name in listed if (root / name).is_file()]


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    pages = files(root, "*.md")
    sources = files(root, "*.h", "*.cpp", "*.cmake", "*.py", "CMakeLists.txt", "scripts/*")
    found = [(page, number, why) for page in pages for number, why in broken(page, root)]
    found += [(source, number, why) for source in sources for number, why in broken_comments(source, root)]
    found += broken_names(sources)
    for file, number, why in found:
        print(f"{file.relative_to(root)}:{number}: {why}")
    print(f"{len(found)} broken links or names in {len(pages)} pages and the comments of {len(sources)} sources")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
