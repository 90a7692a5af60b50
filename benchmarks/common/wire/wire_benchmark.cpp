// Measures sending a frame: packing and unpacking its head, and the transfer from send() to
// receive() over the loopback interface.

#include <benchmark/benchmark.h>

#include <thread>

#include "tests/common/wire/sample_messages.h"
#include "tests/common/wire/served.h"

namespace copresence::wire {
namespace {

void encode_frame_head(benchmark::State& state) {
  const FrameHead head = sample_frame_head();
  for (auto _ : state) benchmark::DoNotOptimize(encode(head));
}
BENCHMARK(encode_frame_head);

void decode_frame_head(benchmark::State& state) {
  const FrameHeadMessage message = encode(sample_frame_head());
  for (auto _ : state) {
    benchmark::DoNotOptimize(wire::decode_frame_head(std::span(message).last<kFrameHeadBytes>(), 188));
  }
}
BENCHMARK(decode_frame_head);

void welcome_round_trip(benchmark::State& state) {
  for (auto _ : state) {
    const Bytes message = encode(sample_welcome());
    benchmark::DoNotOptimize(decode_welcome(std::span(message).subspan(kHeaderBytes)));
  }
}
BENCHMARK(welcome_round_trip);

/// Sends 30 frames a second to all clients, so that both ends sleep between frames. The measured
/// time ends when the last client has the frame's last byte. The CPU time is that of all threads
/// per frame.
void loopback(benchmark::State& state) {
  const auto bytes = static_cast<std::size_t>(state.range(0)) * 2 / 3;  // For depth.
  const tls::RoomKey room_key(std::array<std::uint8_t, tls::RoomKey::kBytes>{1, 2, 3});
  const tls::RoomKey* const key = state.range(2) ? &room_key : nullptr;
  Served served(key);
  std::vector<FrameClient> clients;
  for (int i = 0; i < state.range(1); ++i) {
    auto client = served.client(key);
    if (!client) return state.SkipWithError(client.error().what.c_str());
    clients.push_back(std::move(*client));
  }
  for (auto _ : state) {
    state.PauseTiming();
    std::this_thread::sleep_for(std::chrono::milliseconds(33));
    state.ResumeTiming();
    if (!served.capture_when_wanted(bytes)) return state.SkipWithError("no client has room");
    Duration latency{};
    for (FrameClient& client : clients) {
      const auto received = client.receive({});
      if (!received) return state.SkipWithError(received.error().what.c_str());
      latency = received->received_at - received->sent_at;
    }
    state.SetIterationTime(std::chrono::duration<double>(latency).count());
  }
  state.SetBytesProcessed(state.iterations() * state.range(0) * state.range(1));
}
BENCHMARK(loopback)
    ->ArgNames({"bytes", "clients", "encrypted"})
    ->Args({20'000, 1, 0})
    ->Args({20'000, 1, 1})
    ->Args({100'000, 1, 0})
    ->Args({100'000, 1, 1})
    ->Args({100'000, 4, 0})
    ->Args({100'000, 4, 1})
    ->Iterations(60)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseManualTime();

}  // namespace
}  // namespace copresence::wire
