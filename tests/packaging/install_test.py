#!/usr/bin/env python3
"""Installs a build into a temporary folder, moves that folder elsewhere, and runs the programs from there.
They must find their drivers and shared libraries and load nothing of the build. The man pages must be valid.

  tests/packaging/install_test.py --build build/release"""
import argparse
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAMS = ("calibrate", "capture_server", "depth_bench", "record", "render_client", "simulate_kinect", "view_bench",
            "web_gateway")
UDEV_RULE = "lib/udev/rules.d/70-copresence-cameras.rules"


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, timeout=120)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    build = parser.parse_args().build.resolve()
    faults = []

    def expect(condition, what):
        if not condition:
            faults.append(what)

    with tempfile.TemporaryDirectory() as temporary:
        prefix, moved = pathlib.Path(temporary) / "first", pathlib.Path(temporary) / "moved here"
        installed = run("cmake", "--install", build, "--prefix", prefix)
        expect(installed.returncode == 0, f"cmake --install: {installed.stderr}")
        prefix.rename(moved)
        expect((moved / UDEV_RULE).is_file(), f"{UDEV_RULE} is not installed")
        for program in PROGRAMS:
            path = moved / "bin" / program
            if not path.is_file():
                faults.append(f"{program} is not installed")
                continue
            version = run(path, "--version")
            expect(version.returncode == 0 and version.stdout.startswith(program), f"{program} --version: {version}")
            loaded = run("ldd", path).stdout
            expect(str(build) not in loaded, f"{program} loads libraries of the build")
            expect("not found" not in loaded, f"{program} does not find all libraries: {loaded}")
            page = moved / "share/man/man1" / f"{program}.1"
            expect(page.is_file() and ".SH OPTIONS" in page.read_text(), f"{program} has no man page with options")
            if shutil.which("mandoc"):
                checked = run("mandoc", "-T", "lint", "-W", "error", page)
                expect(checked.returncode == 0, f"the man page of {program}: {checked.stdout}")
        if not faults:
            server = moved / "bin/capture_server"
            listed = run(server, "--list").stdout
            expect("simulated:room?camera=0" in listed, f"the installed drivers are not found: {listed}")
            played = run(server, "--source", ROOT / "data/recordings/camera0.oni", "--pace", "fast",
                         "--listen", "127.0.0.1:0")
            expect(played.returncode == 0, f"a recording: {played.stderr}")
    print("\n".join(faults) or "the installed programs run")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
