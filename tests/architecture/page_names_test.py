#!/usr/bin/env python3
"""Reads every Markdown page. A relative link must lead somewhere. A path in backticks that begins with a folder of the
project must exist, and so must a test named as Suite.Name. So pages name no file or test that was moved or renamed."""
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(sys.argv[1])
FOLDERS = ("common|capture_server|render_client|web_gateway|tools|tests|benchmarks|shaders|docs|data|packaging|cmake|"
           "web")
PATH = re.compile(rf"(?:{FOLDERS})/[\w./-]+")
TEST = re.compile(r"[A-Z]\w+\.[A-Z]\w+")
DEFINITION = re.compile(r"\b(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP|NAME)\s*\(?\s*(\w+)(?:,\s*|\.)(\w+)")
HISTORY = {"CHANGELOG.md"}  # names what was


def project_files():
    """Returns the files of the working tree that git does not ignore. Without git, all but build folders'."""
    if shutil.which("git"):
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", "--cached", "--others", "--exclude-standard"],
                                capture_output=True, text=True)
        if listed.returncode == 0:
            return [ROOT / line for line in listed.stdout.splitlines()]
    return [path for path in ROOT.rglob("*") if "build" not in path.relative_to(ROOT).parts]  # a tarball


def anchors(page):
    """Returns the anchors that GitHub makes from a page's headings."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def exists(path):
    # Pages may name a header and its source together, without an ending.
    return (ROOT / path).exists() or any((ROOT / f"{path}.{end}").exists() for end in ("h", "cpp"))


def faults_of(page, tests):
    text = re.sub(r"^```.*?^```", lambda fence: "\n" * fence[0].count("\n"), page.read_text(),
                  flags=re.MULTILINE | re.DOTALL)
    for number, line in enumerate(text.splitlines(), 1):
        where = f"{page.relative_to(ROOT)}:{number}"
        for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]*))?\)", line):
            if "://" in target:
                continue
            aim = (page.parent / target) if target else page
            if not aim.exists():
                yield f"{where}: the link to {target} leads nowhere"
            elif anchor and aim.suffix == ".md" and anchor not in anchors(aim):
                yield f"{where}: {target or page.name} has no heading for #{anchor}"
        for name in re.findall(r"`([^`]+)`", line):
            if PATH.fullmatch(name) and not exists(name):
                yield f"{where}: there is no {name}"
            if TEST.fullmatch(name) and name not in tests:
                yield f"{where}: there is no test {name}"


def main():
    files = project_files()
    tests = set()
    for file in files:
        if "tests" in file.parts and file.name.endswith(("_test.cpp", "CMakeLists.txt")):
            tests.update(".".join(found) for found in DEFINITION.findall(file.read_text()))
    pages = [file for file in files if file.suffix == ".md" and file.name not in HISTORY and file.exists()]
    faults = [fault for page in sorted(pages) for fault in faults_of(page, tests)]
    print("\n".join(faults) or f"{len(pages)} pages name nothing that is not there")
    return 1 if faults or not pages or not tests else 0


if __name__ == "__main__":
    sys.exit(main())
