#!/usr/bin/env python3
"""Lines of CMake, Python, TypeScript and shell have at most 120 columns, lines of pages 140. clang-format limits
those of C++.

  tests/architecture/line_lengths_test.py FOLDER

Free are what cannot be divided: rows of tables, headings, marks and fenced blocks of pages."""
import pathlib
import sys

ROOT = pathlib.Path(sys.argv[1])
FOLDERS = (".ci", "benchmarks", "capture_server", "cmake", "common", "data", "docs", "packaging", "render_client",
           "simulation", "tests", "tools", "web", "web_gateway")
SHELL = {"run", "debian13"}


def limit_of(path):
    if path.suffix == ".md":
        return 140
    return 120 if path.suffix in (".cmake", ".py", ".ts") or path.name in SHELL | {"CMakeLists.txt"} else None


def divisible_lines(path):
    """The lines of a file that can be divided, with their numbers."""
    fenced = False
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if path.suffix == ".md":
            fenced ^= line.lstrip().startswith("```")
            if fenced or line.lstrip().startswith(("|", "#", "<!--", "![", "[")):
                continue
        yield number, line


def main():
    paths = [path for path in ROOT.iterdir() if path.is_file()]
    paths += [path for folder in FOLDERS for path in (ROOT / folder).rglob("*")
              if path.is_file() and "dist" not in path.parts]
    paths = sorted(path for path in paths if limit_of(path))
    faults = [f"{path.relative_to(ROOT)}:{number}: {len(line)} columns, allowed are {limit_of(path)}"
              for path in paths for number, line in divisible_lines(path) if len(line) > limit_of(path)]
    print("\n".join(faults) or f"{len(paths)} files, no line too long")
    return 1 if faults or not paths else 0


if __name__ == "__main__":
    sys.exit(main())
