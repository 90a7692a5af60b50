#!/usr/bin/env python3
"""Checks the dependencies of modules. Reads every #include and, if a build folder is given, what each target links.

  tests/architecture/layers_test.py FOLDER [BUILD]

A module may use only modules below it, and each foreign library has one home module. The table here is the
table in docs/internals/architecture.md. A module's private headers are included only by itself, its tests and its
benchmarks. A .cpp file includes its own header first."""
import dataclasses
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1]).resolve()

# module -> modules that it may include and link; itself always
EDGE_TYPES = {"common/frame", "common", "common/text"}
MODULES = {
    "common": set(),  # result.h, executor.h
    "common/frame": {"common"},
    "common/text": {"common"},
    "common/file": {"common"},
    "common/toml": {"common", "common/text"},
    **{f"common/{name}": EDGE_TYPES for name in ("flow", "command_line", "depth", "color", "bitstream", "gl")},
    "common/tls": {"common", "common/text"},
    "common/wire": EDGE_TYPES | {"common/tls"},
    "common/matroska": EDGE_TYPES | {"common/file"},
    "common/scene": EDGE_TYPES | {"common/toml"},
    "common/video": EDGE_TYPES | {"common/bitstream"},
    "common/window": EDGE_TYPES | {"common/gl"},
    "simulation/scene": EDGE_TYPES,
    "simulation/truth": EDGE_TYPES | {"simulation/scene"},
    "simulation/sensor": EDGE_TYPES | {"simulation/scene", "simulation/truth"},
    "capture_server/recording": EDGE_TYPES | {"common/file"},
    "capture_server/drivers/contract": EDGE_TYPES | {"common/flow"},
    "capture_server/drivers/primesense": EDGE_TYPES | {"capture_server/drivers/contract"},
    "capture_server/drivers/installed": EDGE_TYPES | {"capture_server/drivers/contract"},
    "capture_server/drivers/kinect_v1": EDGE_TYPES | {"capture_server/drivers/contract"},
    "capture_server/drivers/simulated": EDGE_TYPES | {"capture_server/drivers/contract", "common/flow",
                                                       "simulation/scene", "simulation/truth", "simulation/sensor"},
    "capture_server/sensor": EDGE_TYPES | {"common/flow", "capture_server/drivers/contract",
                                           "capture_server/recording"},
    "capture_server/diagnosis": EDGE_TYPES | {"capture_server/drivers/contract", "capture_server/sensor"},
    "capture_server/registration": EDGE_TYPES,
    "capture_server/hole_filling": EDGE_TYPES | {"common/gl"},
    "capture_server/temporal_filter": EDGE_TYPES,
    "capture_server/encoding": EDGE_TYPES | {"common/color", "common/depth", "common/scene", "common/video",
                                             "capture_server/hole_filling", "capture_server/registration",
                                             "capture_server/sensor", "capture_server/temporal_filter"},
    "capture_server/recorder": EDGE_TYPES | {"common/flow", "capture_server/recording", "capture_server/sensor"},
    "capture_server/supervisor": EDGE_TYPES | {"common/flow"},
    "render_client/stream": EDGE_TYPES | {"common/flow", "common/tls", "common/wire"},
    "render_client/background_memory": EDGE_TYPES,
    "render_client/session": EDGE_TYPES | {"common/bitstream", "common/file", "common/matroska", "common/wire",
                                           "render_client/stream"},
    "render_client/camera_setup": EDGE_TYPES | {"common/scene"},
    "render_client/decoding": EDGE_TYPES | {"common/color", "common/depth", "common/scene", "common/video",
                                            "render_client/camera_setup"},
    "render_client/color_matching": EDGE_TYPES | {"common/flow", "render_client/camera_setup"},
    "render_client/pacing": EDGE_TYPES | {"common/flow", "render_client/camera_setup"},
    "render_client/viewpoint": EDGE_TYPES,
    "render_client/renderer": EDGE_TYPES | {"common/gl", "render_client/viewpoint"},
    "render_client/moving_surfaces": EDGE_TYPES | {"render_client/renderer"},
    "render_client/display/overlay": EDGE_TYPES | {"common/gl", "common/window"},
    "render_client/display": EDGE_TYPES | {"common/gl", "common/window", "render_client/display/overlay",
                                           "render_client/renderer", "render_client/viewpoint"},
    # Compiled to WebAssembly. It takes the sources of the modules that a frame passes from the wire to the mesh.
    "web/native": EDGE_TYPES | {"common/bitstream", "common/color", "common/depth", "common/wire",
                                "render_client/background_memory", "render_client/camera_setup",
                                "render_client/color_matching", "render_client/decoding", "render_client/renderer"},
    "render_client/film": EDGE_TYPES | {"common/bitstream", "common/color", "common/file", "common/matroska",
                                        "common/video", "render_client/display"},
    "render_client/statistics": EDGE_TYPES | {"render_client/renderer", "common/flow", "common/wire",
                                              "render_client/stream", "render_client/viewpoint"},
    "web_gateway/forwarding": EDGE_TYPES | {"common/wire"},
    "web_gateway/page": EDGE_TYPES,
    "web_gateway/web": EDGE_TYPES | {"common/wire", "web_gateway/forwarding", "web_gateway/page"},
}
# The programs put the modules together: pipeline, settings, main.
PROGRAMS = {"capture_server": ("common", "capture_server"), "render_client": ("common", "render_client"),
            "web_gateway": ("common", "web_gateway")}
EVERYTHING = ("tests", "benchmarks", "tools")

# Foreign header -> modules that may include it. Tests, benchmarks and tools are free.
HOMES = {
    r"libav|libsw|x264": {"common/video"},
    r"asio": {"common/wire"},
    r"openssl/": {"common/tls"},
    r"epoxy/|EGL/|GL/": {"common/gl", "common/window"},
    r"GLFW/": {"common/window"},
    r"imgui|backends/imgui": {"render_client/display/overlay"},
    r"toml\+\+": {"common/toml"},
    r"OpenNI\.h|Oni.*\.h|PS1080\.h|PrimeSense\.h|Driver/": {
        "capture_server/sensor", "capture_server/diagnosis", "capture_server/drivers/contract"},
    r"libfreenect": {"capture_server/drivers/kinect_v1"},
    r"embree": {"simulation/truth"},
    r"opencv": set(),  # the two programs start in a sixth of the time without it: docs/decisions/0003-libraries.md
    r"turbojpeg": {"capture_server/recording"},
    r"png\.h": {"render_client/display"},
    r"zlib\.h": {"common/bitstream"},
    r"boost/": {"web_gateway/web"},
    r"CLI/": {"common/command_line", "capture_server", "render_client", "web_gateway"},
    r"spdlog": {"capture_server", "capture_server/recorder", "render_client", "web_gateway"},
    r"nlohmann": {"capture_server/recording", "render_client/statistics", "web_gateway/forwarding"},
}


# Linked library -> modules that may link it.
LIBRARY_HOMES = {
    "PkgConfig::FFMPEG": {"common/video"},
    "copresence_asio": {"common/wire"},
    "OpenSSL::SSL": {"common/tls"},
    "PkgConfig::EPOXY": {"common/gl", "common/window"},
    "glfw": {"common/window"},
    "PkgConfig::IMGUI": {"render_client/display/overlay"},
    "tomlplusplus::tomlplusplus": {"common/toml"},
    "PkgConfig::OPENNI2": {"capture_server/sensor", "capture_server/diagnosis", "capture_server/drivers/contract",
                           "capture_server"},
    "PkgConfig::FREENECT": {"capture_server/drivers/kinect_v1"},
    "embree": {"simulation/truth"},
    "copresence_opencv": set(),
    "yaml-cpp": set(),
    "PkgConfig::TURBOJPEG": {"capture_server/recording"},
    "PNG::PNG": {"render_client/display"},
    "ZLIB::ZLIB": {"common/bitstream"},
    "copresence_beast": {"web_gateway/web"},
    "spdlog::spdlog": {"capture_server", "capture_server/recorder", "render_client", "web_gateway"},
    "nlohmann_json::nlohmann_json": {"capture_server/recording", "render_client/statistics",
                                     "web_gateway/forwarding"},
}
# Program -> folders of modules and foreign libraries that it must not link, not even through others.
NOT_IN_PROGRAM = {
    "capture_server": ({"simulation", "common/window", "render_client"}, {"embree", "glfw", "copresence_opencv"}),
    "render_client": ({"simulation", "capture_server"},
                      {"embree", "copresence_opencv", "PkgConfig::OPENNI2", "PkgConfig::FREENECT"}),
    # It decodes nothing.
    "web_gateway": ({"simulation", "capture_server", "render_client", "common/video", "common/depth", "common/color",
                     "common/gl", "common/window"},
                    {"embree", "copresence_opencv", "glfw", "PkgConfig::FFMPEG", "PkgConfig::EPOXY",
                     "PkgConfig::OPENNI2", "PkgConfig::FREENECT"}),
}
PROJECT_FOLDERS = r"(common|simulation|capture_server|render_client|web_gateway|web|tests|benchmarks|tools)/"


@dataclasses.dataclass
class Target:
    folder: pathlib.Path
    links: list
    private_headers: set


def module_of(path):
    folder = path.parent
    while folder != pathlib.Path("."):
        name = folder.as_posix()
        if name in MODULES or name in PROGRAMS or name.split("/")[0] in EVERYTHING:
            return name
        folder = folder.parent
    return None


def may_use(module, path):
    """True if files of the module may use what lies at the path."""
    if module in PROGRAMS:
        return path.as_posix().startswith(tuple(f"{top}/" for top in PROGRAMS[module]))
    used = module_of(path)
    return used == module or used in MODULES[module]


def read_targets(build):
    """Targets by name, from what cmake/target_list.cmake wrote."""
    targets = {}
    for line in (build / "targets.tsv").read_text().splitlines():
        name, folder, links, private = line.split("\t")
        links = [re.sub("^copresence::", "copresence_", link) for link in links.split(";") if link]
        headers = {pathlib.Path(header).resolve().relative_to(ROOT).as_posix()
                   for header in private.split(";") if header}
        targets[name] = Target(pathlib.Path(folder).resolve().relative_to(ROOT), links, headers)
    return targets


def link_faults(targets):
    for name, target in targets.items():
        module = module_of(target.folder / "file")
        if module is None or module.split("/")[0] in EVERYTHING:
            continue
        for link in target.links:
            if link in LIBRARY_HOMES:
                if module not in LIBRARY_HOMES[link]:
                    yield f"{name} ({module}) links {link}, which belongs to {sorted(LIBRARY_HOMES[link])}"
            elif link in targets and module_of(targets[link].folder / "file"):
                used = targets[link].folder / "file"
                if module_of(used) not in PROGRAMS and not may_use(module, used):
                    yield f"{name} ({module}) links {link} of {module_of(used)}"
    for program, (folders, libraries) in NOT_IN_PROGRAM.items():
        ways, new = {program: program}, [program]
        while new:
            name = new.pop()
            for link in targets[name].links if name in targets else []:
                if link not in ways:
                    ways[link] = f"{ways[name]} -> {link}"
                    new.append(link)
        for name, way in sorted(ways.items()):
            folder = targets[name].folder.as_posix() if name in targets else ""
            if name in libraries or any(f"{folder}/".startswith(f"{excluded}/") for excluded in folders):
                yield f"{program} must not link {name}: {way}"


def private_header_faults(targets):
    homes = {header: pathlib.Path(module_of(target.folder / "file") or target.folder)
             for target in targets.values() for header in target.private_headers}
    for top in ("common", "simulation", "capture_server", "render_client", "web_gateway", *EVERYTHING):
        for source in (path for path in (ROOT / top).rglob("*") if path.suffix in (".h", ".cpp")):
            path = source.relative_to(ROOT)
            mirrored = path.relative_to(path.parts[0]) if path.parts[0] in ("tests", "benchmarks") else path
            for header in re.findall(r'^\s*#include\s+"([^"]+)"', source.read_text(), re.MULTILINE):
                home = homes.get(header)
                if home and home not in mirrored.parents:
                    yield f"{path} includes {header}, which is private to {home}"


def include_faults(path):
    module = module_of(path)
    if module is None:
        yield f"{path}: lies in no module that this test knows"
        return
    source = ROOT / path
    text = source.read_text()
    own = source.with_suffix(".h")
    if source.suffix == ".cpp" and own.exists():
        first = re.search(r'^\s*#include\s+[<"]([^>"]+)[>"]', text, re.MULTILINE)
        if not first or first.group(1) != own.relative_to(ROOT).as_posix():
            yield f"{path}: its first include is not its own header"
    for number, line in enumerate(text.splitlines(), 1):
        match = re.match(r'\s*#include\s+[<"]([^>"]+)[>"]', line)
        if not match:
            continue
        header = match.group(1)
        where = f"{path}:{number}: {module} includes {header}"
        if re.match(PROJECT_FOLDERS, header) and not may_use(module, pathlib.Path(header)):
            yield f"{where}, but may use only {sorted(MODULES.get(module, PROGRAMS.get(module)))}"
        for pattern, homes in HOMES.items():
            if re.match(pattern, header) and module not in homes:
                yield f"{where}, which belongs to {sorted(homes)}"


def main():
    sources = [path.relative_to(ROOT)
               for top in ("common", "simulation", "capture_server", "render_client", "web_gateway", "web")
               for path in (ROOT / top).rglob("*") if path.suffix in (".h", ".cpp")]
    faults = [fault for path in sources for fault in include_faults(path)]
    if len(sys.argv) > 2:
        targets = read_targets(pathlib.Path(sys.argv[2]))
        faults += [*link_faults(targets), *private_header_faults(targets)]
    print("\n".join(faults) or f"{len(sources)} files, every include and every link points downward")
    return 1 if faults or not sources else 0


if __name__ == "__main__":
    sys.exit(main())
