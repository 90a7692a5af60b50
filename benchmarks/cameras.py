#!/usr/bin/env python3
"""Cameras through OpenNI2 over a fake libfreenect: CPU per frame, 1000 times opened and closed, 100 times unplugged and
plugged in. Numbers only. Arguments go to the benchmark (--benchmark_filter=...)."""
import os
import pathlib
import subprocess
import sys
import tempfile

BUILD = pathlib.Path(__file__).resolve().parent.parent / "build/release"


def main():
    with tempfile.TemporaryDirectory() as bus:
        environment = dict(os.environ, COPRESENCE_FAKE_KINECTS=bus, LD_LIBRARY_PATH=str(BUILD / "tests/fake_freenect"))
        return subprocess.run([BUILD / "benchmarks/drivers_benchmark", *sys.argv[1:]], env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
