#!/usr/bin/env python3
"""Each header must include what declares the names that it uses: itself, or through other headers of the project.

  tests/architecture/own_includes_test.py FOLDER

Headers of libraries often bring others along, but not in all versions. ./run check-headers compiles each header behind
precompiled headers of the libraries, so it cannot see such a missing include."""
import functools
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1]).resolve()
FOLDERS = ("common", "simulation", "capture_server", "render_client", "web_gateway", "tools", "tests",
           "benchmarks")

# Header of a library -> the names that it declares.
DECLARES = {
    "algorithm": r"std::(clamp|min_element|max_element|minmax_element|minmax|sort|copy|copy_n|fill|fill_n|any_of|"
                 r"all_of|none_of|find|find_if|count|count_if|transform|lower_bound|upper_bound|reverse|remove_if|"
                 r"ranges::[a-z_]+)\b",
    "array": r"std::(array\b|to_array)",
    "atomic": r"std::atomic",
    "bit": r"std::(bit_cast|bit_width|countl_zero|countr_zero|popcount|endian)\b",
    "bitset": r"std::bitset",
    "charconv": r"std::(from_chars|to_chars)",
    "chrono": r"std::chrono::",
    "cmath": r"std::(sqrt|hypot|exp|log|log2|pow|sin|cos|tan|atan2?|lround|lrint|floor|ceil|round|fmod|isfinite|"
             r"isnan|cbrt)\b",
    "complex": r"std::complex",
    "condition_variable": r"std::condition_variable",
    "cstdint": r"std::u?int(8|16|32|64|ptr)_t",
    "cstdio": r"std::(FILE|fopen|printf|fprintf|snprintf|remove)\b",
    "cstdlib": r"std::(getenv|exit|abort|strtol|system|EXIT_FAILURE)\b",
    "cstring": r"std::(memcpy|memset|memcmp|strlen|strcmp|strerror|memmove)\b",
    "deque": r"std::deque",
    "exception": r"std::(exception_ptr|current_exception|terminate)\b",
    "filesystem": r"std::filesystem",
    "fstream": r"std::(ifstream|ofstream|fstream)",
    "functional": r"std::(function|invoke|greater|less|plus|minus|reference_wrapper|ref|cref)\b",
    "future": r"std::(future|promise|async|packaged_task)\b",
    "initializer_list": r"std::initializer_list",
    "limits": r"std::numeric_limits",
    "list": r"std::list\b",
    "map": r"std::(multi)?map\b",
    "memory": r"std::(unique_ptr|shared_ptr|weak_ptr|make_unique|make_shared|enable_shared_from_this)",
    "mutex": r"std::(mutex|lock_guard|unique_lock|scoped_lock|call_once|once_flag|recursive_mutex)\b",
    "numbers": r"std::numbers::",
    "numeric": r"std::(accumulate|iota|reduce|inner_product|midpoint|gcd|lcm|partial_sum)\b",
    "optional": r"std::(optional|nullopt)",
    "queue": r"std::(queue|priority_queue)\b",
    "random": r"std::(mt19937|mt19937_64|minstd_rand|uniform_\w+|normal_distribution|bernoulli_distribution)",
    "set": r"std::(multi)?set\b",
    "shared_mutex": r"std::(shared_mutex|shared_lock)",
    "span": r"std::(span|as_bytes|as_writable_bytes)\b",
    "sstream": r"std::[io]?stringstream",
    "stop_token": r"std::(stop_token|stop_source|stop_callback)",
    "string": r"std::(string|to_string|getline|stoi|stod)\b",
    "string_view": r"std::string_view",
    "thread": r"std::(thread|jthread|this_thread)\b",
    "tuple": r"std::(tuple|make_tuple|tie|apply)\b",
    "unordered_map": r"std::unordered_map",
    "unordered_set": r"std::unordered_set",
    "utility": r"std::(exchange|index_sequence|make_index_sequence|swap|forward|in_place)\b",
    "variant": r"std::(variant|visit|monostate|holds_alternative|get_if)\b",
    "vector": r"std::vector",
    "Eigen/Core": r"Eigen::",
    "Eigen/Geometry": r"Eigen::(Isometry|Affine|Quaternion|AngleAxis|Translation|AlignedBox|Hyperplane)",
    "fmt/format.h": r"fmt::",
    "tl/expected.hpp": r"tl::(expected|unexpected)",
}
# These bring the others along by their own definition.
BRINGS = {
    "Eigen/Geometry": {"Eigen/Core"},
    "Eigen/LU": {"Eigen/Core"},
    "Eigen/Dense": {"Eigen/Core", "Eigen/Geometry"},
    "thread": {"stop_token"},
    "condition_variable": {"mutex", "stop_token"},
    "string": {"string_view"},
    "string_view": {"string"},
}
INCLUDE = re.compile(r'^\s*#\s*include\s+[<"]([^>"]+)[>"]', re.MULTILINE)
NOT_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.DOTALL)


@functools.cache
def included(header):
    """The libraries' headers that a header of the project brings along."""
    found = set()
    for name in INCLUDE.findall((ROOT / header).read_text()):
        if (ROOT / name).is_file():
            found |= included(name)
        else:
            found |= {name} | BRINGS.get(name, set())
    return found


def main():
    headers = sorted(path.relative_to(ROOT) for folder in FOLDERS for path in (ROOT / folder).rglob("*.h"))
    faults = []
    for header in headers:
        code = NOT_CODE.sub("", (ROOT / header).read_text())
        for declaring, names in DECLARES.items():
            used = re.search(names, code)
            if used and declaring not in included(header.as_posix()):
                faults.append(f"{header}: uses {used.group(0)} without <{declaring}>")
    print("\n".join(faults) or f"{len(headers)} headers, each includes what declares the names that it uses")
    return 1 if faults or not headers else 0


if __name__ == "__main__":
    sys.exit(main())
