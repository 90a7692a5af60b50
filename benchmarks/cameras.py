#!/usr/bin/env python3
"""Cameras through OpenNI2 over a fake libfreenect: CPU per frame, 1000 times opened and closed, 100 times unplugged and
plugged in. Numbers only.

  benchmarks/cameras.py                                        all, about ten minutes
  benchmarks/cameras.py --benchmark_filter=stream/simulated    some; further options go to Google Benchmark"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

BUILD = pathlib.Path(__file__).resolve().parent.parent / "build/release"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    _, passed_on = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as bus:
        environment = dict(os.environ, COPRESENCE_FAKE_KINECTS=bus, LD_LIBRARY_PATH=str(BUILD / "tests/fake_freenect"))
        return subprocess.run([BUILD / "benchmarks/drivers_benchmark", *passed_on], env=environment).returncode


if __name__ == "__main__":
    sys.exit(main())
