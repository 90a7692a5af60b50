#!/usr/bin/env python3
"""Benchmark of cameras that OpenNI2 opens through a fake libfreenect. Measures the CPU time per frame, opens and closes
a camera 1000 times, and unplugs and plugs it in 100 times.

  benchmarks/cameras.py                                        all benchmarks, about ten minutes
  benchmarks/cameras.py --benchmark_filter=stream/simulated    one benchmark; options go to Google Benchmark"""
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
