#!/usr/bin/env python3
"""Reads every #include of the project: rooms may use what lies below them and nothing beside them, and each foreign
library has one home. The table here is the table in docs/internals/architecture.md. A .cpp includes its own header before all
else, so that every header is known to compile alone (cmake/module.cmake tries those that have none)."""
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])

# room -> rooms it may include (itself always)
EDGE_TYPES = {"common/frame", "common", "common/text"}
ROOMS = {
    "common": set(),  # result.h
    "common/frame": {"common"},
    "common/text": {"common"},
    **{f"common/{room}": EDGE_TYPES for room in ("flow", "scene", "command_line", "depth", "color", "bitstream", "wire", "gl")},
    "common/video": EDGE_TYPES | {"common/bitstream"},
    "common/window": EDGE_TYPES | {"common/gl"},
    "simulation": EDGE_TYPES,
    "capture_server/recording": EDGE_TYPES,
    "capture_server/drivers/contract": EDGE_TYPES | {"common/flow"},
    "capture_server/drivers/primesense": EDGE_TYPES | {"capture_server/drivers/contract"},
    "capture_server/drivers/installed": EDGE_TYPES | {"capture_server/drivers/contract"},
    "capture_server/drivers/kinect_v1": EDGE_TYPES | {"capture_server/drivers/contract"},
    "capture_server/drivers/simulated": EDGE_TYPES | {"capture_server/drivers/contract", "common/flow", "simulation"},
    "capture_server/sensor": EDGE_TYPES | {"common/flow", "capture_server/drivers/contract"},
    "capture_server/registration": EDGE_TYPES,
    "capture_server/hole_filling": EDGE_TYPES | {"common/gl"},
    "render_client/renderer": EDGE_TYPES | {"common/gl"},
    "render_client/viewpoint": EDGE_TYPES,
    "render_client/pacing": EDGE_TYPES,
    "render_client/color_matching": EDGE_TYPES,
}
# the programs put the rooms together: pipeline, settings, main
PROGRAMS = {"capture_server": ("common", "capture_server"), "render_client": ("common", "render_client")}
EVERYTHING = ("tests", "benchmarks", "tools")

# foreign header -> rooms it may show up in (tests, benchmarks and tools are free)
HOMES = {
    r"libav|libsw|x264": {"common/video"},
    r"asio": {"common/wire"},
    r"epoxy/|EGL/|GL/": {"common/gl", "common/window"},
    r"GLFW/": {"common/window"},
    r"toml\+\+": {"common/scene"},
    r"OpenNI\.h|Oni.*\.h|PS1080\.h|PrimeSense\.h|Driver/": {"capture_server/sensor", "capture_server/drivers/contract"},
    r"libfreenect": {"capture_server/drivers/kinect_v1"},
    r"embree": {"simulation"},
    r"opencv": set(),  # the two programs start in a sixth of the time without it: docs/decisions/0003-libraries.md
    r"turbojpeg": {"capture_server/recording"},
    r"png\.h": {"render_client"},
    r"CLI/": {"common/command_line", "capture_server", "render_client"},
    r"spdlog": {"capture_server", "render_client"},
    r"nlohmann": {"capture_server/recording", "render_client"},
}


def room_of(path):
    folder = path.parent
    while folder != pathlib.Path("."):
        name = folder.as_posix()
        if name in ROOMS or name in PROGRAMS or name.split("/")[0] in EVERYTHING:
            return name
        folder = folder.parent
    return None


def main():
    faults = []
    sources = [p for top in ("common", "simulation", "capture_server", "render_client")
               for p in (ROOT / top).rglob("*") if p.suffix in (".h", ".cpp")]
    for source in sources:
        path = source.relative_to(ROOT)
        room = room_of(path)
        if room is None:
            faults.append(f"{path}: lies in no room that this test knows")
            continue
        text = source.read_text()
        own = source.with_suffix(".h")
        if source.suffix == ".cpp" and own.exists():
            first = re.search(r'^\s*#include\s+[<"]([^>"]+)[>"]', text, re.MULTILINE)
            if not first or first.group(1) != own.relative_to(ROOT).as_posix():
                faults.append(f"{path}: its first include is not its own header")
        for number, line in enumerate(text.splitlines(), 1):
            match = re.match(r'\s*#include\s+[<"]([^>"]+)[>"]', line)
            if not match:
                continue
            header = match.group(1)
            where = f"{path}:{number}: {room} includes {header}"
            if re.match(r"(common|simulation|capture_server|render_client|tests|benchmarks|tools)/", header):
                target = room_of(pathlib.Path(header))
                if room in PROGRAMS:
                    allowed = header.startswith(tuple(f"{top}/" for top in PROGRAMS[room]))
                else:
                    allowed = target == room or target in ROOMS[room]
                if not allowed:
                    faults.append(f"{where}, but may use only {sorted(ROOMS.get(room, PROGRAMS.get(room)))}")
            for pattern, homes in HOMES.items():
                if re.match(pattern, header) and room not in homes:
                    faults.append(f"{where}, which belongs to {sorted(homes)}")
    print("\n".join(faults) if faults else f"{len(sources)} files, every include points downward")
    return 1 if faults or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
