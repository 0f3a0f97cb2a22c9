#!/usr/bin/env python3
"""The parts of Trunnion include each other only as docs/architecture.md says.

    link_graph_test.py SOURCE_DIR LINK_GRAPH

LINK_GRAPH is what CMake wrote: one line a part, `name: linked parts`. Checked are
  - the linked parts, against the table of docs/architecture.md (down the page or along an arrow of its diagram);
  - every #include of a part's sources, against what that part links, directly or through others;
  - outside libraries that stay in few places or behind plain headers.
Exit status 1 and a line for each finding.
"""
import pathlib
import re
import sys

# Outside headers that only these parts may see.
CONFINED = [
    (re.compile(r"CGAL/"), {"testpiece", "errormap"}),
    (re.compile(r"(?:gp|BRep\w*|TopoDS|TopExp|Geom\w*|STEP\w*|RWGltf|XCAF\w*|TDocStd|Interface|ElSLib|Message)_?\w*\.hxx"),
     {"testpiece"}),
    (re.compile(r"\w+\.hxx"), {"testpiece"}),
    (re.compile(r"CLI/"), {"app"}),
    (re.compile(r"pybind11/"), {"python"}),
    (re.compile(r"toml\+\+/"), {"io"}),
    (re.compile(r"sqlite3\.h|libpq-fe\.h"), {"history"}),
    (re.compile(r"regex$"), set()),
]
BELONGS_TO_ALL = {"error.h", "loaded_module.h"}
# Headers that only sources of their own part include: the strict TOML reader of machine, job and piece files.
FOR_SOURCES_ONLY = {"src/io/toml_reader.h"}
# Outside headers too heavy for a header of ours.
HEAVY = re.compile(r"CGAL/|CLI/|toml\+\+/|nlohmann/json\.hpp|boost/|Eigen/(Dense|SVD|QR|LU|Cholesky|Eigenvalues|Sparse)|.*\.hxx")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def allowed_parts(page):
    """The table rows `| part | what it holds | may include |` of the architecture page."""
    allowed = {}
    for line in page.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if len(cells) == 3 and re.fullmatch(r"`\w+`", cells[0]):
            allowed[cells[0].strip("`")] = set(re.findall(r"`(\w+)`", cells[2]))
    return allowed


def closure(graph, part, seen=None):
    """Everything reachable from `part`, itself excluded."""
    seen = set() if seen is None else seen
    for other in graph.get(part, ()):
        if other not in seen:
            seen.add(other)
            closure(graph, other, seen)
    return seen


def sources(root):
    """(part, path) of every source and header of a part."""
    for folder, part in [("postproc", "postproc"), ("compensation", "compensation"), ("src", None)]:
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in {".h", ".cpp"}:
                continue
            inside = path.relative_to(root / folder).parts
            if part is None and len(inside) == 1:
                continue  # what belongs to all
            yield part or inside[0], path


def include_findings(root, linked):
    parts = set(linked) | {"app", "python"}
    for part, path in sources(root):
        place = path.relative_to(root)
        reach = closure(linked, part) | {part} if part in linked else parts
        own = str(path.with_suffix(".h").relative_to(root / "src" if "src" == place.parts[0] else root))
        first = None
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            quoted, name = match[1] == '"', match[2]
            where = f"{place}:{number}: {name}"
            first = first or name
            for pattern, homes in CONFINED:
                if pattern.match(name) and part not in homes:
                    yield f"{where}: may be included by {', '.join(sorted(homes)) or 'no part'}, not by {part}"
                    break
            if path.suffix == ".h" and HEAVY.match(name) and str(place) not in FOR_SOURCES_ONLY:
                yield f"{where}: too heavy for a header, it belongs into a source behind it"
            if not quoted or name in BELONGS_TO_ALL:
                continue
            target = name.split("/")[0]
            if "/" not in name or target not in parts:
                yield f"{where}: an include path starts at a part, and no part is called '{target}'"
            elif target not in reach:
                yield f"{where}: {part} does not link {target}"
        if path.suffix == ".cpp" and path.with_suffix(".h").exists() and first != own:
            yield f"{place}: includes {first} first, its own header {own} is wanted there"


def main():
    root, graph_file = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    linked = {}
    for line in graph_file.read_text(encoding="utf-8").splitlines():
        name, _, rest = line.partition(":")
        linked[name] = rest.split()
    allowed = allowed_parts(root / "docs" / "architecture.md")
    findings = []
    if not linked or not allowed:
        findings.append("no parts found: the link graph or the table of docs/architecture.md is empty")
    for part, others in linked.items():
        if part not in allowed:
            findings.append(f"{part}: a part that docs/architecture.md does not tell of")
            continue
        for other in sorted(set(others) - closure(allowed, part)):
            findings.append(f"{part}: links {other}, which the diagram of docs/architecture.md does not allow")
    for part in allowed:
        if part in closure(allowed, part):
            findings.append(f"{part}: reaches itself in the table of docs/architecture.md")
    findings += include_findings(root, linked)
    print("\n".join(findings) or f"{len(linked)} parts include each other as the diagram says")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
