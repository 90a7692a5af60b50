// Replaces libFuzzer where it is missing. Runs a fuzz function on each file of a corpus, on each
// prefix of the file, and on the file with each single bit flipped. Large files are cut and flipped
// at evenly spaced places. Only a crash is a failure.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

constexpr std::size_t kVariations = 4096;  // Number of variations of each kind and file.

// The copy has exactly the input's size, so that the address sanitizer notices a read past the end.
void run(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::uint8_t> input(data, data + size);
  LLVMFuzzerTestOneInput(input.data(), input.size());
}

void replay(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  run(bytes.data(), bytes.size());
  const std::size_t size_step = std::max<std::size_t>(bytes.size() / kVariations, 1);
  for (std::size_t size = 0; size < bytes.size(); size += size_step) run(bytes.data(), size);
  const std::size_t bit_step =
      std::max<std::size_t>(8 * bytes.size() / kVariations, 1) | 1;  // odd: reaches all bits
  for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += bit_step) {
    const auto mask = static_cast<std::uint8_t>(1u << bit % 8);
    bytes[bit / 8] ^= mask;
    run(bytes.data(), bytes.size());
    bytes[bit / 8] ^= mask;
  }
}

}  // namespace

int main(int argc, char** argv) {
  int files = 0;
  for (int i = 1; i < argc; ++i) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(argv[i], error)) {
      if (!entry.is_regular_file()) continue;
      replay(entry.path());
      ++files;
    }
  }
  std::printf("%d files replayed\n", files);
  return files > 0 ? 0 : 1;
}
