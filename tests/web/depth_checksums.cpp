// Decodes a capture_server's stream as render_client does, and prints a line for each frame: its
// sequence and the CRC-32 of its little-endian depth image.
//
//   depth_checksums HOST:PORT FRAMES

#include <zlib.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "common/wire/frame_client.h"
#include "render_client/decoding/frame_decoding.h"

int main(int argc, char** argv) {
  using namespace copresence;
  if (argc != 3) return 2;
  auto client = wire::FrameClient::connect(argv[1], std::chrono::seconds(5), {});
  if (!client) {
    std::fprintf(stderr, "%s\n", client.error().what.c_str());
    return 1;
  }
  auto decoding = decoding::FrameDecoding::open(client->description()).value();
  for (int left = std::atoi(argv[2]); left > 0; --left) {
    const auto received = client->receive({});
    if (!received) return 0;  // The stream is over.
    decoding::FrameDecoding::Durations durations;
    const auto frame = decoding.decode(received->frame, durations);
    if (!frame) {
      std::fprintf(stderr, "%s\n", frame.error().what.c_str());
      client->request_keyframe();
      continue;
    }
    const auto pixels = frame->depth.pixels();
    const auto crc =
        crc32_z(0, reinterpret_cast<const unsigned char*>(pixels.data()), pixels.size() * sizeof pixels[0]);
    std::printf("%llu %lu\n", static_cast<unsigned long long>(frame->metadata.sequence), crc);
    std::fflush(stdout);
  }
}
