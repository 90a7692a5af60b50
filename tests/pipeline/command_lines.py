#!/usr/bin/env python3
"""Gives every option of every program wrong values: text for a number, nothing, NaN, negative and huge numbers. Each
must be rejected with exit code 2 and one sentence that names the option, quotes the value and says what is allowed.

  tests/pipeline/command_lines.py [--bin FOLDER]

The options are read from --help, so new options are tested automatically. The exit code is 0 if all tests pass."""
import argparse
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAMS = [["capture_server"], ["render_client"], ["web_gateway"], ["depth_bench"], ["view_bench"],
            ["simulate_kinect"], ["record", "cut"], ["record", "repair"], ["record", "from-images"],
            ["record", "export"],
            ["calibrate", "intrinsics"], ["calibrate", "markers"], ["calibrate", "refine"], ["calibrate", "check"]]
NUMBERS = ["foo", "", "nan", "1;2", "-1e99", "1e99", "9" * 40, "0x", "--5"]
WORDS = [""]
# Those of type TEXT that take a few words, or a text of one form only.
FORMS = {"--size", "--truth-size", "--range", "--renderer", "--view", "--stereo", "--unseen", "--background",
         "--color-matching", "--codec", "--effort", "--board-size", "--dictionary", "--chessboard",
         "--projector-slot", "--exposure", "--white-balance", "--hole-filling", "--temporal-filter", "--compute",
         "--pace", "--unit", "--solver", "--board", "--format"}
WRONG_FORMS = ["foo", "", "-1", "1x", "nan:nan", "infxinf"]
# Without a value it has a meaning of its own.
MAY_BE_EMPTY = {"--truth"}
NO_VALUE = {"--help", "--version"}


def options_of(binary, verb):
    """Returns (name, type) of every option that takes a value."""
    help_text = subprocess.run([binary, *verb, "--help"], capture_output=True, text=True, check=True).stdout
    found = re.findall(r"^  (?:-\w,)?(--[a-z][a-z-]*)[ ]+([A-Z]{3,}|\{)?", help_text, re.MULTILINE)
    return [(name, kind) for name, kind in found if name not in NO_VALUE and kind]


def wrong_values(name, kind):
    if name in MAY_BE_EMPTY:
        return ["foo"]
    if kind in ("INT", "UINT", "FLOAT"):
        return NUMBERS
    return WRONG_FORMS if name in FORMS else WORDS


def complaint(binary, verb, name, value):
    """Returns what is wrong with the program's message, or None."""
    given = [f"{name}={value}"] if value else [name, value]
    ran = subprocess.run([binary, *verb, *given], capture_output=True, text=True, timeout=20)
    lines = ran.stderr.splitlines() or [""]
    said = f"exit {ran.returncode}, \"{lines[0]}\""
    if ran.returncode != 2:
        return said
    if name not in lines[0] or not any(quoted in lines[0] for quoted in (f'"{value}"', f"'{value.split(':')[0]}'")):
        return f"{said} does not name the option and the value"
    if len(lines) > 1 or len(lines[0]) > 400:
        return f"{said} is too long"
    if not re.search(r"\b(is not|is no|cannot be|needs|has|there is no)\b", lines[0]):
        return f"{said} does not say what is allowed"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--say", action="store_true", help="print one sentence of each option")
    options = parser.parse_args()
    faults, tried = [], 0
    for program, *verb in PROGRAMS:
        title = " ".join([program, *verb])
        listed = options_of(options.bin / program, verb)
        if not listed:
            faults.append(f"{title}: no option found in --help")
        for name, kind in listed:
            for value in wrong_values(name, kind):
                tried += 1
                wrong = complaint(options.bin / program, verb, name, value)
                if wrong:
                    faults.append(f"{title} {name}={value}: {wrong}")
            if options.say:
                ran = subprocess.run([options.bin / program, *verb, f"{name}={wrong_values(name, kind)[0]}"],
                                     capture_output=True, text=True)
                print(f"{title}: {ran.stderr.splitlines()[0]}")
    print("\n".join(faults))
    print(f"{tried} wrong values: {len(faults)} faults")
    return 1 if faults or tried < 300 else 0


if __name__ == "__main__":
    sys.exit(main())
