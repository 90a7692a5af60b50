#!/usr/bin/env python3
"""Runs the reference compiler on every shader, because a driver may accept code that other drivers reject. A shader
whose class passes constants to it has sample values in a line `// checked with: -DNAME=VALUE ...`."""
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(sys.argv[1])
SKIPPED = 77


def main():
    validator = shutil.which("glslangValidator")
    if not validator:
        print("*** SKIPPED, NOT TESTED: no glslangValidator here, install glslang-tools ***")
        return SKIPPED
    shaders = sorted(p for p in (ROOT / "shaders").iterdir() if p.suffix in (".comp", ".vert", ".frag"))
    faults = 0
    for shader in shaders:
        samples = re.search(r"^// checked with: (.*)$", shader.read_text(), re.MULTILINE)
        # -D works with linking only
        options = ["-l", *samples.group(1).split()] if samples else []
        run = subprocess.run([validator, *options, shader], capture_output=True, text=True)
        if run.returncode:
            faults += 1
            print(run.stdout.strip())
    print(f"{len(shaders)} shaders, {faults} with faults")
    return 1 if faults or not shaders else 0


if __name__ == "__main__":
    sys.exit(main())
