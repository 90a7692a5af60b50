#!/usr/bin/env python3
"""Reads the comments of all sources and all pages. Each paper cited as "Surname and Surname YEAR", each RFC and each
ITU-T recommendation must be in docs/bibliography.md. Each equation of the thesis must be in
docs/internals/thesis.md."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
FOLDERS = ("common", "capture_server", "render_client", "web_gateway", "tools", "shaders", "tests", "benchmarks",
           "docs")
SOURCES = {".h", ".cpp", ".comp", ".vert", ".frag"}
BIBLIOGRAPHY, THESIS = ROOT / "docs/bibliography.md", ROOT / "docs/internals/thesis.md"

SURNAME = "[A-Z][a-zäöüéñ]+"
PAPER = re.compile(rf"\b({SURNAME}(?:(?:, and |, | and ){SURNAME})*)(?: et al\.)?,? \(?((?:19[5-9]|20[0-2])\d)\b")
STANDARD = re.compile(r"RFC \d+|ITU-T [A-Z]\.\d+")
EQUATION = re.compile(r"(?:\beq\.|\bequations?) (\d\.\d+(?:(?:, | and | to )\d\.\d+)*)")
MONTHS = {"January", "February", "March", "April", "May", "June", "July", "August", "September", "October",
          "November", "December"}


def prose(path):
    """Returns the comments of a source, or the text of a page, as one line."""
    text = path.read_text(errors="replace")
    if path.suffix in SOURCES:
        text = "\n".join(line.split("//", 1)[1].lstrip("/!< ") for line in text.splitlines() if "//" in line)
    return re.sub(r"\s+", " ", text)


def equations(text):
    """Returns 2.1, 2.2 and 2.3 for "2.1 to 2.3", and both numbers for "3.4 and 3.5"."""
    numbers = re.findall(r"(\d)\.(\d+)", text)
    if " to " not in text:
        return {f"{chapter}.{number}" for chapter, number in numbers}
    (chapter, first), (_, last) = numbers[0], numbers[-1]
    return {f"{chapter}.{number}" for number in range(int(first), int(last) + 1)}


def main():
    bibliography = BIBLIOGRAPHY.read_text().replace("Möller", "Moeller")
    entries = [re.sub(r"\s+", " ", entry) for entry in re.split(r"\n\n|\n\|", bibliography)]
    table = THESIS.read_text().split("## Chapter 1")[0]
    listed = set().union(*(equations(row.split("|")[1]) for row in table.splitlines() if row.startswith("| ")))
    papers, faults = 0, []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in SOURCES | {".md"} or path in (BIBLIOGRAPHY, THESIS) or not path.is_file():
                continue
            text, name = prose(path), path.relative_to(ROOT)
            for authors, year in PAPER.findall(text):
                surnames = re.findall(r"[A-Z]\w+", authors)
                if surnames[0] in MONTHS:
                    continue
                papers += 1
                if not any(all(part in entry for part in (year, *surnames)) for entry in entries):
                    faults.append(f"{name}: docs/bibliography.md has no {' and '.join(surnames)} {year}")
            for standard in STANDARD.findall(text):
                if standard not in bibliography:
                    faults.append(f"{name}: docs/bibliography.md has no {standard}")
            for cited in EQUATION.findall(text):
                for number in sorted(equations(cited) - listed):
                    faults.append(f"{name}: docs/internals/thesis.md has no equation {number}")
    print("\n".join(faults) or f"{papers} citations of papers, all in docs/bibliography.md")
    return 1 if faults or not papers or not listed else 0


if __name__ == "__main__":
    sys.exit(main())
