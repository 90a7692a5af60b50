#pragma once

// A server with one encoder and several clients, each behind a link of a given rate, delay and jitter. Time
// is injected: a minute takes milliseconds. Windows and encoder demand are the real ones; sockets and threads
// are left out.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "common/wire/flow_control/client_window.h"
#include "common/wire/flow_control/encoder_demand.h"

namespace copresence::wire {

/// A path to a client and back.
struct Link {
  double megabits_per_second = 0;  ///< towards the client; 0: no limit
  Duration delay{};                ///< one way, each way
  Duration jitter{};               ///< a random further delay up to this, each way; order is kept
};

struct Stream {
  Duration period = std::chrono::microseconds(33333);
  std::size_t frame_bytes = 34000;  ///< 8.2 Mbit/s, as two minutes of the demo's first camera
  double keyframe = 2.5;            ///< times frame_bytes
};

class SimulatedNetwork {
 public:
  struct Arrival {
    Duration at;  ///< since the start
    Duration delay;
    bool keyframe;
  };

  class Client {
   public:
    /// Frames a second between two instants since the start.
    double rate(Duration begin, Duration end) const {
      return static_cast<double>(count(begin, end, [](const Arrival&) { return true; })) /
             std::chrono::duration<double>(end - begin).count();
    }
    double keyframes_per_second(Duration begin, Duration end) const {
      return static_cast<double>(count(begin, end, [](const Arrival& a) { return a.keyframe; })) /
             std::chrono::duration<double>(end - begin).count();
    }
    /// Of the frames that arrive in a span, `share` have at most this delay; an hour where none arrives.
    Duration delay(Duration begin, Duration end, double share = 0.5) const {
      std::vector<Duration> delays;
      for (const Arrival& arrival : arrivals_) {
        if (arrival.at >= begin && arrival.at < end) delays.push_back(arrival.delay);
      }
      if (delays.empty()) return std::chrono::hours(1);
      std::sort(delays.begin(), delays.end());
      return delays[std::min(delays.size() - 1,
                             static_cast<std::size_t>(share * static_cast<double>(delays.size())))];
    }
    const std::vector<Arrival>& arrivals() const { return arrivals_; }
    const ClientWindow& window() const { return *window_; }

   private:
    friend class SimulatedNetwork;
    template <class Predicate>
    std::ptrdiff_t count(Duration begin, Duration end, const Predicate& predicate) const {
      return std::count_if(arrivals_.begin(), arrivals_.end(), [&](const Arrival& arrival) {
        return arrival.at >= begin && arrival.at < end && predicate(arrival);
      });
    }
    struct Queued {
      std::uint64_t sequence;
      double bytes_left;
      Instant sent_at;
      bool keyframe;
    };
    Link link_;
    std::unique_ptr<ClientWindow> window_;  // none before it joined
    std::deque<Queued> queue_;
    std::deque<std::pair<Instant, Queued>> on_the_way_;
    std::deque<std::pair<Instant, std::uint64_t>> acknowledgements_;
    std::vector<Arrival> arrivals_;
  };

  explicit SimulatedNetwork(Stream stream = {}) : stream_(stream), demand_(stream.period) {}

  Client& join(const Link& link) {
    clients_.push_back(std::make_unique<Client>());
    clients_.back()->link_ = link;
    clients_.back()->window_ = std::make_unique<ClientWindow>(stream_.period);
    return *clients_.back();
  }
  void change(Client& client, const Link& link) { client.link_ = link; }
  void leave(Client& client) { client.window_.reset(); }
  void change(const Stream& stream) { stream_ = stream; }

  Duration now() const { return now_ - Instant{}; }
  std::uint64_t frames_encoded() const { return frames_encoded_; }

  void run_for(Duration duration) {
    for (const Instant end = now_ + duration; now_ < end; now_ += kStep) step();
  }

 private:
  static constexpr std::chrono::milliseconds kStep{1};

  void step() {
    for (const auto& client : clients_) {
      if (client->window_) carry(*client);
    }
    if (now_ < next_capture_) return;
    next_capture_ += stream_.period;
    ++captured_;
    update();
    if (!demand_.wants_frame(now_)) return;
    const bool keyframe = demand_.take_keyframe_request(now_);
    const auto bytes = static_cast<std::size_t>(static_cast<double>(stream_.frame_bytes) *
                                                (keyframe ? stream_.keyframe : 1));
    ++frames_encoded_;
    for (const auto& client : clients_) {
      if (!client->window_) continue;
      if (!client->window_->can_accept(keyframe, now_)) {
        client->window_->skip(1);
        continue;
      }
      client->window_->sent(captured_, bytes, now_);
      client->queue_.push_back({captured_, static_cast<double>(bytes), now_, keyframe});
    }
    demand_.sent(keyframe, bytes, now_);
    update();
  }

  void carry(Client& client) {
    const Link& link = client.link_;
    double budget = link.megabits_per_second > 0 ? link.megabits_per_second * 1e6 / 8 / 1000 : 1e18;
    while (!client.queue_.empty() && budget > 0) {
      const double carried = std::min(budget, client.queue_.front().bytes_left);
      client.queue_.front().bytes_left -= carried;
      budget -= carried;
      if (client.queue_.front().bytes_left > 0) break;
      Instant due = now_ + one_way(link);
      if (!client.on_the_way_.empty()) due = std::max(due, client.on_the_way_.back().first);
      client.on_the_way_.emplace_back(due, client.queue_.front());
      client.queue_.pop_front();
    }
    for (; !client.on_the_way_.empty() && client.on_the_way_.front().first <= now_;
         client.on_the_way_.pop_front()) {
      const auto& frame = client.on_the_way_.front().second;
      client.arrivals_.push_back({now(), now_ - frame.sent_at, frame.keyframe});
      Instant due = now_ + one_way(link);
      if (!client.acknowledgements_.empty()) due = std::max(due, client.acknowledgements_.back().first);
      client.acknowledgements_.emplace_back(due, frame.sequence);
    }
    bool acknowledged = false;
    for (; !client.acknowledgements_.empty() && client.acknowledgements_.front().first <= now_;
         client.acknowledgements_.pop_front()) {
      EXPECT_TRUE(client.window_->acknowledge(client.acknowledgements_.front().second, now_));
      acknowledged = true;
    }
    if (acknowledged) update();
  }

  Duration one_way(const Link& link) {
    if (link.jitter == Duration::zero()) return link.delay;
    return link.delay +
           Duration(std::uniform_int_distribution<Duration::rep>(0, link.jitter.count())(random_));
  }

  void update() {
    EncoderDemand::Clients clients;
    for (const auto& client : clients_) {
      if (client->window_) clients.add(*client->window_);
    }
    demand_.update(clients);
  }

  Stream stream_;
  EncoderDemand demand_;
  std::vector<std::unique_ptr<Client>> clients_;
  Instant now_{}, next_capture_{};
  std::uint64_t captured_ = 0, frames_encoded_ = 0;
  std::mt19937_64 random_{1};
};

}  // namespace copresence::wire
