#!/usr/bin/env python3
"""Checks that the programs run on a processor without AVX2 and give the same results there.

- No program, and no shared library outside of glibc-hwcaps, holds an instruction on 32-byte vectors.
- Simulated recordings and the results of every FAST module (fast_paths.cpp) are the same with and without AVX2. The
  loader's tunables hide AVX2 (man ld.so, GLIBC_TUNABLES).

  tests/packaging/portable_test.py --build build/release"""
import argparse
import hashlib
import os
import pathlib
import subprocess
import sys
import tempfile

WITHOUT_AVX2 = {**os.environ, "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2"}
FAST_FOLDER = "glibc-hwcaps"


def output_of(*command, environment=None):
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=300, env=environment).stdout


def has_wide_vectors(path):
    with subprocess.Popen(["objdump", "-d", "--no-show-raw-insn", path], stdout=subprocess.PIPE, text=True) as objdump:
        found = any("%ymm" in line or "%zmm" in line for line in objdump.stdout)
        objdump.kill()
    return found


def loads_fast_library(program, environment=None):
    return FAST_FOLDER in output_of("ldd", program, environment=environment)


def simulated_recording(program, folder, environment):
    output_of(program, "room", "--cameras", "1", "--frames", "3", "--out", folder, environment=environment)
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    build = parser.parse_args().build.resolve()
    faults = []

    base = [*(build / "bin").iterdir(), *(path for path in (build / "lib/copresence").rglob("*.so*")
                                         if FAST_FOLDER not in path.parts and not path.is_symlink())]
    faults += [f"{path} holds instructions of AVX" for path in base if has_wide_vectors(path)]

    fast_paths = build / "tests/fast_paths"
    if loads_fast_library(fast_paths, WITHOUT_AVX2):
        faults.append("the loader takes the fast libraries although AVX2 is hidden")
    if not loads_fast_library(fast_paths):
        print("\n".join(faults) or "this processor has no AVX2, nothing to compare")
        return 1 if faults else 77

    fast, slow = (output_of(fast_paths, environment=environment).splitlines() for environment in (None, WITHOUT_AVX2))
    if len(fast) < 10 or any("failed" in line for line in fast):
        faults.append(f"fast_paths computes too little: {fast}")
    faults += [f"with AVX2 \"{a}\", without \"{b}\"" for a, b in zip(fast, slow) if a != b]

    with tempfile.TemporaryDirectory() as temporary:
        folders = [pathlib.Path(temporary) / name for name in ("fast", "slow")]
        fast, slow = (simulated_recording(build / "bin/simulate_kinect", folder, environment)
                      for folder, environment in zip(folders, (None, WITHOUT_AVX2)))
    if fast != slow:
        faults.append(f"simulate_kinect writes other bytes without AVX2: {fast}, {slow}")
    print("\n".join(faults) or f"{len(base)} files without AVX, and the same results with it")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
