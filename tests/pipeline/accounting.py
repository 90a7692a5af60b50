#!/usr/bin/env python3
"""Runs one capture_server for each source and one client for all of them. Checks that every frame is counted:

  captured by the server = recorded + left out of the recording           (--record counts those left out)
  captured since the client connected = received + dropped by cause       (no frame is "unaccounted")
  received = decoded + not decodable
  decoded = shown + replaced before a view                                (except two per camera at the end)

  tests/pipeline/accounting.py                          ten minutes on the two recordings of the demo
  tests/pipeline/accounting.py --seconds 6              as the test does
  tests/pipeline/accounting.py --seconds 600 a.oni b.oni 'simulated:room?camera=0' 'simulated:room?camera=1'
  tests/pipeline/accounting.py --fake-kinects           ten minutes on two Kinects (fake) and the two recordings

Prints the sums. The exit code is 0 if all are right."""
import argparse
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FRAMES_A_SECOND = 30
KINECTS = ("A00000000000001A", "B00000000000002B")
IN_HAND = 2  # decoded frames of a camera that may be neither shown nor replaced when the client ends


def end(process, within_s=5.0):
    try:
        return process.wait(within_s)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()


def recorded(log):
    found = re.search(r"\.oni: (\d+) frames, [\d.]+ MB, (\d+) left out", log)
    return (int(found.group(1)), int(found.group(2))) if found else None


def account(camera):
    """Returns a message for each wrong sum."""
    drops, faults = camera["drops"], []
    dropped = drops["encoder_busy"] + drops["window_full"]
    if drops["unaccounted"] or camera["frames_captured"] != camera["frames_received"] + dropped:
        faults.append("captured is not received + dropped")
    if camera["frames_received"] != camera["frames_decoded"] + drops["decode_error"]:
        faults.append("received is not decoded + not decodable")
    held = camera["frames_decoded"] - camera["frames_shown"] - camera["frames_unshown"]
    if not 0 <= held <= IN_HAND:
        faults.append(f"decoded is not shown + unshown: {held} in hand")
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sources", nargs="*", default=[str(ROOT / f"data/recordings/camera{i}.oni") for i in (0, 1)])
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--port", type=int, default=7930)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--record", type=pathlib.Path,
                        help="folder for recordings of all servers, about 2 MB a second each "
                             "[a temporary one, for runs up to a minute]")
    parser.add_argument("--fake-kinects", action="store_true",
                        help="two more servers on Kinects of the fake libfreenect (tests/support/fake_freenect)")
    parser.add_argument("--sync", action="store_true", help="the client runs with --sync")
    options = parser.parse_args()
    frames = int(options.seconds * FRAMES_A_SECOND)
    faults = []
    sources = [*options.sources,
               *([f"openni:freenect://{kinect}" for kinect in KINECTS] if options.fake_kinects else [])]

    with tempfile.TemporaryDirectory() as temporary:
        folder = options.record or (pathlib.Path(temporary) if options.seconds <= 60 else None)
        bus = pathlib.Path(temporary) / "bus"
        bus.mkdir()
        for kinect in KINECTS:
            (bus / kinect).touch()
        environment = dict(os.environ)
        if options.fake_kinects:
            environment.update(COPRESENCE_FAKE_KINECTS=str(bus),
                               LD_LIBRARY_PATH=str(options.bin.parent / "tests/fake_freenect"))
        logs, servers = [], []
        for index, source in enumerate(sources):
            command = [options.bin / "capture_server", "--source", source, "--name", f"camera{index}",
                       "--listen", f"127.0.0.1:{options.port + index}", "--frames", str(frames)]
            if source.endswith(".oni"):
                command.append("--loop")
            if folder:
                command += ["--record", folder / f"account{index}.oni"]
            logs.append(pathlib.Path(temporary) / f"server{index}.log")
            servers.append(subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=logs[-1].open("w"),
                                            env=environment))
        stats = pathlib.Path(temporary) / "stats.json"
        connect = [word for index in range(len(servers)) for word in ("--connect", f"127.0.0.1:{options.port + index}")]
        begin = time.monotonic()
        client = subprocess.Popen([options.bin / "render_client", *connect, "--headless", "--size", "640x360",
                                   "--stats", stats, *(["--sync"] if options.sync else [])],
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for index, server in enumerate(servers):
            try:
                # A recording plays slower where there are fewer cores than it wants.
                code = server.wait(3 * options.seconds + 30)
            except subprocess.TimeoutExpired:
                code = f"none after {3 * options.seconds + 30:.0f} s"
                server.kill()
            if code != 0:
                faults.append(f"server {index} ended with {code}: {logs[index].read_text()[-300:]}")
        seconds = time.monotonic() - begin
        client.send_signal(signal.SIGTERM)
        if end(client) != 0:
            faults.append("the client failed")

        for index, log in enumerate(logs):
            if not folder:
                break
            written = recorded(log.read_text())
            if not written or sum(written) != frames:
                faults.append(f"server {index} captured {frames} frames, its recording knows of {written}")
            else:
                print(f"server {index}: captured {frames} = {written[0]} recorded + {written[1]} left out")
        statistics = json.loads(stats.read_text())
    for camera in statistics["cameras"]:
        drops = camera["drops"]
        print(f"{camera['name']}: captured {camera['frames_captured']} = {camera['frames_received']} received + "
              f"{drops['encoder_busy']} encoder busy + {drops['window_full']} window full + {drops['unaccounted']} "
              f"unaccounted; {camera['frames_decoded']} decoded + {drops['decode_error']} not; "
              f"{camera['frames_shown']} shown + {camera['frames_unshown']} unshown; pictures {camera['pictures']}")
        faults += [f"{camera['name']}: {fault}" for fault in account(camera)]
        if camera["frames_captured"] < 0.8 * frames:
            faults.append(f"{camera['name']}: the client saw only {camera['frames_captured']} of {frames} "
                          "frames captured")
    skew = statistics["view"]["skew_ms"]
    print(f"{seconds:.0f} s, {statistics['view']['frames']} views, skew p50 {skew['p50']:.1f}, p95 {skew['p95']:.1f}, "
          f"p99 {skew['p99']:.1f} ms: {len(faults)} faults")
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
