#!/usr/bin/env python3
"""Fails when two files define a type or an inline function of the same qualified name (the one-definition rule).

The linker keeps one of them without a word, and every other file then works with the wrong layout. Names in unnamed
namespaces and inside functions belong to their file and are left alone. The text is scanned for braces, not compiled:
fast enough for every test run. Every run first shows itself that it would find a planted pair.
"""
import collections
import pathlib
import re
import sys

# What hides braces or names: comments, literals, and lines of the preprocessor with their continuations.
HIDDEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"'
                    r"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])+'|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.DOTALL | re.MULTILINE)
NAMESPACE = re.compile(r"\bnamespace\b\s*([\w:]*)\s*$")
TYPE = re.compile(r"\b(?:enum\s+class|enum\s+struct|enum|class|struct|union)\s+([A-Za-z_][\w:]*(?:<[^{}]*>)?)"
                  r"\s*(?:final\s*)?(?::[^:(][^()]*)?$")
FUNCTION = re.compile(r"([~\w:]+|operator\s*[^\s\w(]+)\s*(\(.*\))\s*(?:const|noexcept|->.*|\s)*$", re.DOTALL)
SHARED_FUNCTION = re.compile(r"\b(?:inline|constexpr|consteval|template)\b")


def definitions(text):
    """Yields the qualified name of every type and inline function that the text defines for the whole program."""
    text = HIDDEN.sub(lambda match: "\n" * match.group().count("\n"), text)
    scopes = []  # a name, or None for what hides what is inside: an unnamed namespace, a body, an initialiser
    head = ""
    for piece in re.split(r"([{};])", text):
        if piece == "{":
            name = None
            space = NAMESPACE.search(head)
            kind = None if space else TYPE.search(head.strip())
            hidden = None in scopes
            if space:
                name = space.group(1) or None
            elif kind:
                name = kind.group(1)
                if not hidden:
                    yield "::".join([*scopes, name])
            elif not hidden and SHARED_FUNCTION.search(head) and (function := FUNCTION.search(head.strip())):
                yield "::".join([*scopes, function.group(1) + re.sub(r"\s+", " ", function.group(2))])
            scopes.append(name)
        elif piece == "}" and scopes:
            scopes.pop()
        head = piece if piece not in "{};" else ""


def twice(files):
    """(name, its files) of every name that more than one file defines. `files`: path -> text."""
    places = collections.defaultdict(set)
    for path, text in files.items():
        for name in definitions(text):
            places[name].add(path)
    return sorted((name, sorted(paths)) for name, paths in places.items() if len(paths) > 1)


def check_itself():
    """Finds the pair that stood here once (PoseErrors in report and diagnose), and nothing in what is allowed."""
    page = "namespace simgap { /* { */ class PoseErrors final : public Base { struct Row { int a; }; }; }"
    evidence = 'namespace simgap { const char* kOpen = "{"; struct PoseErrors { double b; }; enum class Kind { kA }; }'
    local = "namespace simgap { namespace { struct PoseErrors {}; } void f() { struct PoseErrors {}; } class Row; }"
    inline = "namespace simgap { inline int twice(int a) { return 2 * a; } struct Kind* find(); }"
    overload = "namespace simgap { inline double twice(double a) { return 2 * a; } enum class Kind; }"
    found = twice({"page.h": page, "evidence.h": evidence, "local.cpp": local, "inline.h": inline, "other.h": overload})
    assert found == [("simgap::PoseErrors", ["evidence.h", "page.h"])], found
    assert twice({"a.h": inline, "b.h": inline}) == [("simgap::twice(int a)", ["a.h", "b.h"])]


def main():
    check_itself()
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    paths = sorted(path for base in ("src", "include") for path in (root / base).rglob("*.[ch]*"))
    found = twice({str(path.relative_to(root)): path.read_text(encoding="utf-8") for path in paths})
    for name, places in found:
        print(f"{name} is defined in {', '.join(places)}")
    print(f"{len(found)} names defined twice")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
