#include "tools/depth_bench/depth_recording.h"

#include <stop_token>

#include "capture_server/sensor/source.h"
#include "capture_server/temporal_filter/depth_filter.h"

namespace copresence::depth_bench {

Result<DepthRecording> load(const std::filesystem::path& recording, const DepthRange& range, int frames,
                            temporal_filter::Mode temporal_filter) {
  const auto source = sensor::open_source(recording.string(), {sensor::SourceSettings::Pace::kFast, false});
  if (!source) return fail(source.error());
  const sensor::SensorDescription& description = (*source)->description();
  DepthRecording loaded;
  loaded.format = {description.depth.width, description.depth.height, description.unit, range};
  loaded.levels = description.levels;
  if (const auto checked = depth::check(loaded.format); !checked) return fail(checked.error());
  temporal_filter::DepthFilter filter(loaded.format.width, loaded.format.height, loaded.format.unit,
                                      loaded.format.noise);
  const DepthRangeUnits units = loaded.format.units();
  while (frames == 0 || static_cast<int>(loaded.depth.size()) < frames) {
    auto frame = (*source)->next({});
    if (!frame) {
      if (frame.error().code == ErrorCode::kEndOfStream && !loaded.depth.empty()) break;
      return fail(frame.error());
    }
    StateImage states(frame->depth.width(), frame->depth.height(), DepthState::kMeasured);
    for (std::size_t i = 0; i < states.pixels().size(); ++i) {
      if (units.contains(frame->depth.data()[i])) continue;
      frame->depth.data()[i] = 0;
      states.data()[i] = DepthState::kHole;
    }
    if (temporal_filter == temporal_filter::Mode::kAuto) filter.apply(frame->depth, states);
    loaded.depth.push_back(std::move(frame->depth));
    loaded.states.push_back(std::move(states));
  }
  return loaded;
}

}  // namespace copresence::depth_bench
