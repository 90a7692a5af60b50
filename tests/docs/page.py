"""Reads the commands of a Markdown page.

A fence of language `sh` has commands. A fence of language `console` has commands after `$ ` and their
output. Every fence needs a language. HTML comments directly above a fence are notes for the test:

  <!-- test: skip REASON -->       do not run this fence, because of REASON
  <!-- test: soak -->              takes long: only ./run soak runs it
  <!-- test: fresh -->             stop all servers first, after the setup commands
  <!-- test: output varies -->     do not compare the output of a console fence
  <!-- test: exits 1 -->           each command of the fence ends with this exit code
  <!-- test: setup COMMAND -->     run this first: it makes what a reader already has
  <!-- test: kinects SERIAL ... -->  plug in these Kinects of the fake libfreenect
"""
import dataclasses
import pathlib
import re

FENCE = re.compile(r"^```(\S*)[^\n]*\n(.*?)^```[ ]*$", re.MULTILINE | re.DOTALL)
NOTE = re.compile(r"<!-- test: (.*?) -->", re.DOTALL)
COMMAND_LANGUAGES = ("sh", "console")


class PageFault(Exception):
    pass


@dataclasses.dataclass
class Fence:
    line: int
    commands: list  # texts, continuation lines joined
    output: list    # lines of a console fence
    skip: str = ""
    soak: bool = False
    fresh: bool = False
    output_varies: bool = False
    exit_code: int = 0
    setup: list = dataclasses.field(default_factory=list)
    kinects: list = dataclasses.field(default_factory=list)


def read_notes(fence, notes, where):
    for note in notes:
        word, _, rest = " ".join(note.split()).partition(" ")
        if word == "skip":
            if len(rest) < 8:
                raise PageFault(f"{where}: skip needs a reason")
            fence.skip = rest
        elif word == "soak":
            fence.soak = True
        elif word == "fresh":
            fence.fresh = True
        elif word == "output" and rest == "varies":
            fence.output_varies = True
        elif word == "exits":
            fence.exit_code = int(rest)
        elif word == "setup":
            fence.setup.append(rest)
        elif word == "kinects":
            fence.kinects = rest.split()
        else:
            raise PageFault(f"{where}: unknown note \"{word}\"")


def split_commands(text):
    """Lines, joined where one ends with a backslash, without comment lines."""
    lines = re.sub(r"\\\n\s*", "", text).splitlines()
    return [line.strip() for line in lines if line.strip() and not line.strip().startswith("#")]


def split_console(text):
    commands, output = [], []
    for line in re.sub(r"\\\n\s*", "", text).splitlines():
        if line.startswith("$ "):
            commands.append(line[2:])
        elif commands:
            output.append(line)
    return commands, output


def notes_above(text, start):
    """The notes on the lines directly above a fence."""
    above = re.search(r"(?:<!-- test: (?:(?!-->).)* -->\n)*\Z", text[:start], re.DOTALL)
    return NOTE.findall(above[0])


def read(path):
    """Returns all fences with commands, in order. Raises PageFault for a wrong fence."""
    text = path.read_text()
    fences = []
    for match in FENCE.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        where, language = f"{path.name}:{line}", match[1]
        if not language:
            raise PageFault(f"{where}: this fence needs a language: sh for commands, text for anything else")
        if language not in COMMAND_LANGUAGES:
            continue
        commands, output = split_console(match[2]) if language == "console" else (split_commands(match[2]), [])
        if not commands:
            raise PageFault(f"{where}: this fence has no command")
        fence = Fence(line, commands, output)
        read_notes(fence, notes_above(text, match.start()), where)
        fences.append(fence)
    return fences


def inline_code(path):
    """(line, text) of every code span outside of fences."""
    text = FENCE.sub(lambda fence: "\n" * fence[0].count("\n"), path.read_text())
    return [(text.count("\n", 0, span.start()) + 1, " ".join(span[1].split()))
            for span in re.finditer(r"`([^`]+)`", text)]


def all_pages(root):
    return [root / "README.md", root / "CONTRIBUTING.md", root / "data/recordings/README.md",
            *sorted((root / "docs").rglob("*.md"))]
