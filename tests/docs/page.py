"""The commands of a Markdown page, as its reader would type them.

A fence of language `sh` holds commands, one of `console` commands behind `$ ` and what they print. Every
fence has a language, so that nothing is a command by accident. HTML comments directly above a fence say
what the test needs to know:

  <!-- test: skip REASON -->       not run, because of REASON
  <!-- test: soak -->              takes long: run by ./run soak only
  <!-- test: fresh -->             servers that run so far are stopped, after what is set up
  <!-- test: output varies -->     what a console fence prints is not compared
  <!-- test: exits 1 -->           each command of the fence ends with this code
  <!-- test: setup COMMAND -->     run first: what the page's reader has already
  <!-- test: kinects SERIAL ... -->  these Kinects (of the fake libfreenect) are plugged in from here on
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
    output: list    # lines that a console fence shows
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
                raise PageFault(f"{where}: say why it is skipped")
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
            raise PageFault(f"{where}: there is no note \"{word}\"")


def split_commands(text):
    """Lines, with those joined that end in a backslash. Comments alone are no commands."""
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
    """Notes on the lines directly above a fence."""
    above = re.search(r"(?:<!-- test: (?:(?!-->).)* -->\n)*\Z", text[:start], re.DOTALL)
    return NOTE.findall(above[0])


def read(path):
    """All fences with commands of a page, in order. Raises PageFault where one is not clear."""
    text = path.read_text()
    fences = []
    for match in FENCE.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        where, language = f"{path.name}:{line}", match[1]
        if not language:
            raise PageFault(f"{where}: a fence without a language; sh for commands, text for what is none")
        if language not in COMMAND_LANGUAGES:
            continue
        commands, output = split_console(match[2]) if language == "console" else (split_commands(match[2]), [])
        if not commands:
            raise PageFault(f"{where}: no command in it")
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
