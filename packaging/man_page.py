#!/usr/bin/env python3
"""Writes a man page from what a program and its subcommands print for --help.

  packaging/man_page.py build/release/bin/calibrate calibrate.1"""
import dataclasses
import pathlib
import re
import subprocess
import sys


TEXT_COLUMN = 30  # where CLI11 begins an option's text


@dataclasses.dataclass
class Help:
    description: str
    usage: str
    sections: dict  # heading -> [(term, text)]


def read_help(command):
    text = subprocess.run([*command, "--help"], capture_output=True, text=True, check=True, timeout=60).stdout
    description, _, rest = text.partition("Usage:")
    usage, _, rest = rest.partition("\n")
    sections, entries = {}, None
    for line in rest.splitlines():
        if heading := re.fullmatch(r"(\S[^:]*):", line):
            entries = sections.setdefault(heading[1], [])
        elif entry := re.fullmatch(r" {2}(\S.*?)(?: {2,}(\S.*))?", line):
            entries.append([entry[1], entry[2] or ""])
        elif line.strip() and entries:
            entries[-1][1] = f"{entries[-1][1]} {line.strip()}".strip()
    for entry in (entry for listed in sections.values() for entry in listed if not entry[1]):
        # A term that just fits is followed by a single blank.
        if entry[0][TEXT_COLUMN - 3:TEXT_COLUMN - 2] == " ":
            entry[:] = entry[0][:TEXT_COLUMN - 3].rstrip(), entry[0][TEXT_COLUMN - 2:]
    return Help(" ".join(description.split()), usage.strip(), sections)


def escaped(text):
    text = text.replace("\\", "\\(rs").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def entries(help_text):
    for heading, listed in help_text.sections.items():
        if heading.lower() == "subcommands":
            continue
        if heading != "Options":
            yield f".SS {escaped(heading)}"
        for term, text in listed:
            yield from (".TP", f"\\fB{escaped(term)}\\fR", escaped(text))


def man_page(program):
    top = read_help([program])
    name = program.name
    first_sentence = re.split(r"(?<=[.:;]) ", top.description)[0].rstrip(".:;")
    lines = [f'.TH {name.upper()} 1 "" Copresence "Copresence"', ".SH NAME", f"{name} \\- {escaped(first_sentence)}",
             ".SH SYNOPSIS", f"{escaped(top.usage)}", ".SH DESCRIPTION", escaped(top.description), ".SH OPTIONS",
             *entries(top)]
    subcommands = next((listed for heading, listed in top.sections.items() if heading.lower() == "subcommands"), [])
    for subcommand, _ in subcommands:
        verb = read_help([program, subcommand])
        lines += [f'.SH "{name.upper()} {escaped(subcommand).upper()}"', escaped(verb.usage), ".PP",
                  escaped(verb.description),
                  *entries(verb)]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    pathlib.Path(sys.argv[2]).write_text(man_page(pathlib.Path(sys.argv[1]).resolve()))
