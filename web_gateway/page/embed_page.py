#!/usr/bin/env python3
"""Embeds the files of a folder into a C++ source, each also compressed by gzip where that is smaller.

  embed_page.py FOLDER OUTPUT.cpp [--built]

The compressed files lie beside the output. The assembler copies all files into the object file, which is much faster
than compiling them as arrays."""
import gzip
import hashlib
import pathlib
import sys

CONTENT_TYPES = {
    ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8", ".wasm": "application/wasm", ".json": "application/json",
    ".webmanifest": "application/manifest+json", ".svg": "image/svg+xml", ".png": "image/png", ".ico": "image/x-icon",
    ".txt": "text/plain; charset=utf-8", ".map": "application/json",
}

EMBEDDED = """__asm__(
    ".pushsection .rodata\\n"
    ".balign 16\\n"
    ".global {symbol}\\n{symbol}:\\n"
    ".incbin \\"{path}\\"\\n"
    ".global {symbol}_end\\n{symbol}_end:\\n"
    ".byte 0\\n"
    ".popsection\\n");
extern "C" {{
__attribute__((visibility("hidden"))) extern const unsigned char {symbol}[], {symbol}_end[];
}}
"""


def embedded(symbol, path):
    return EMBEDDED.format(symbol=symbol, path=path.as_posix())


def main():
    folder, output = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    blobs, rows = [], []
    for number, path in enumerate(sorted(path for path in folder.rglob("*") if path.is_file())):
        content_type = CONTENT_TYPES.get(path.suffix)
        if content_type is None:
            sys.exit(f"{path}: embed_page.py does not know the content type of {path.suffix or 'no suffix'}")
        content = path.read_bytes()
        symbol = f"copresence_page_{number}"
        blobs.append(embedded(symbol, path))
        compressed = gzip.compress(content, 9, mtime=0)
        gzip_span = "{}"
        if len(compressed) < len(content):
            packed = output.with_name(f"{number}.gz")
            packed.write_bytes(compressed)
            blobs.append(embedded(f"{symbol}_gzip", packed))
            gzip_span = f"{{{symbol}_gzip, {symbol}_gzip_end}}"
        etag = hashlib.sha256(content).hexdigest()[:32]
        name = "/" + path.relative_to(folder).as_posix()
        rows.append(f'      File{{"{name}", "{content_type}", "\\"{etag}\\"",\n'
                    f"           {{{symbol}, {symbol}_end}}, {gzip_span}}},")
    output.write_text("// Made by web_gateway/page/embed_page.py.\n"
                      '#include "web_gateway/page/page_table.h"\n\n#include <array>\n\n' + "".join(blobs) +
                      "\nnamespace copresence::page {\n\n"
                      f"const bool kIsBuilt = {'true' if '--built' in sys.argv[3:] else 'false'};\n\n"
                      "std::span<const File> all_files() {\n  static const std::array files{\n" + "\n".join(rows) +
                      "\n  };\n  return files;\n}\n\n}  // namespace copresence::page\n")


if __name__ == "__main__":
    main()
