#include "render_client/pacing/nearest_instants.h"

#include <algorithm>
#include <cassert>

namespace copresence::pacing {
namespace {

// Choices whose spans differ by less than 1 / kJitterShare of a period count as equally good.
constexpr int kJitterShare = 8;

/// The newest frame up to `end` of each delivering camera. No other choice that ends there spans
/// less.
struct Candidate {
  Instant end;
  Duration span{};
};

bool takes_part(const CameraOffer& offer) {
  return offer.delivers && !offer.captured.empty();
}

std::optional<std::size_t> latest_until(const CameraOffer& offer, Instant end) {
  const auto after = std::upper_bound(offer.captured.begin(), offer.captured.end(), end);
  if (after == offer.captured.begin()) return std::nullopt;
  return static_cast<std::size_t>(after - offer.captured.begin()) - 1;
}

std::optional<Candidate> ending_at(std::span<const CameraOffer> offers, Instant end) {
  Instant earliest = end;
  for (const CameraOffer& offer : offers) {
    if (!takes_part(offer)) continue;
    const auto frame = latest_until(offer, end);
    if (!frame) return std::nullopt;
    earliest = std::min(earliest, offer.captured[*frame]);
  }
  return Candidate{end, end - earliest};
}

Candidate best_of(const std::vector<Candidate>& candidates, Duration period) {
  const auto narrowest =
      std::min_element(candidates.begin(), candidates.end(),
                       [](const Candidate& a, const Candidate& b) { return a.span < b.span; });
  const Duration limit = std::max(period / 2, narrowest->span + period / kJitterShare);
  const Duration wanted = narrowest->span <= period / 2 ? period / 2 : limit;
  Candidate best = *narrowest;
  for (const Candidate& candidate : candidates) {
    if (candidate.span <= wanted && candidate.end > best.end) best = candidate;
  }
  return best;
}

}  // namespace

FrameChoice nearest_instants(std::span<const CameraOffer> offers, Duration period, Instant now) {
  assert(period > Duration::zero());
  FrameChoice choice;
  choice.frames.resize(offers.size());

  // A frame that has waited for half a period must be shown, so the choice must not end before it.
  Instant reach = Instant::min();
  for (const CameraOffer& offer : offers) {
    if (!offer.has_fresh()) continue;
    const Instant deadline = offer.fresh_since + period / 2;
    if (!choice.at_latest || deadline < *choice.at_latest) choice.at_latest = deadline;
    if (now >= deadline) reach = std::max(reach, offer.captured[offer.first_is_on_view ? 1 : 0]);
  }

  std::vector<Candidate> candidates, reaching;
  for (const CameraOffer& offer : offers) {
    if (!takes_part(offer)) continue;
    for (const Instant end : offer.captured) {
      const auto candidate = ending_at(offers, end);
      if (!candidate) continue;
      candidates.push_back(*candidate);
      if (end >= reach) reaching.push_back(*candidate);
    }
  }
  if (!reaching.empty()) candidates = reaching;

  std::optional<Instant> end;
  if (!candidates.empty()) {
    const Candidate best = best_of(candidates, period);
    end = best.end;
    choice.skew = best.span;
  }
  for (std::size_t i = 0; i < offers.size(); ++i) {
    const CameraOffer& offer = offers[i];
    if (offer.captured.empty()) continue;
    choice.frames[i] = takes_part(offer) && end ? latest_until(offer, *end) : offer.captured.size() - 1;
    if (*choice.frames[i] > 0 || !offer.first_is_on_view) choice.is_new = true;
  }
  return choice;
}

}  // namespace copresence::pacing
