#include "common/wire/transport/name_lookup.h"

#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace copresence::wire {
namespace {

using asio::ip::tcp;
using Work = asio::executor_work_guard<asio::io_context::executor_type>;

}  // namespace

struct NameLookup::Shared {
  std::mutex mutex;
  /// Keeps the io_context running. Empty after a cancellation.
  std::optional<Work> work;
  /// Used on the io_context's thread only.
  Done done;
};

NameLookup::NameLookup(asio::io_context& io, std::string host, std::uint16_t port, Done done)
    : shared_(std::make_shared<Shared>()) {
  shared_->work.emplace(io.get_executor());
  shared_->done = std::move(done);
  std::thread([shared = shared_, host = std::move(host), port] {
    asio::io_context own;
    asio::error_code error;
    const auto found =
        tcp::resolver(own).resolve(host, std::to_string(port), tcp::resolver::numeric_service, error);
    std::vector<tcp::endpoint> endpoints(found.begin(), found.end());
    std::lock_guard lock(shared->mutex);
    if (!shared->work) return;
    asio::post(shared->work->get_executor(), [shared, error, endpoints = std::move(endpoints)]() mutable {
      if (const Done ready = std::exchange(shared->done, nullptr)) ready(error, std::move(endpoints));
    });
    shared->work.reset();
  }).detach();
}

NameLookup::~NameLookup() {
  shared_->done = nullptr;
  std::lock_guard lock(shared_->mutex);
  shared_->work.reset();
}

}  // namespace copresence::wire
