#include "common/depth/levels/quantized_codec.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/depth/levels/code_map.h"
#include "common/depth/levels/codebook.h"

namespace copresence::depth {
namespace {

class QuantizedEncoder final : public PlaneEncoder {
 public:
  QuantizedEncoder(const DepthFormat& format, bool adaptive)
      : range_(format.units()),
        adaptive_(adaptive),
        frame_pixels_(1.0 * format.width * format.height),
        table_(range_, format.unit, format.noise),
        none_(table_),
        code_of_depth_(65536, kUnknown) {}

  DepthCodecDescription description() const override {
    return {adaptive_ ? "adaptive" : "quantized", PixelFormat::kGray10, {}};
  }

  void set_lossless(bool lossless) override { lossless_ = lossless; }

  void set_bits_per_frame(std::optional<double> bits) override { bits_per_frame_ = bits; }

  void set_sensor_levels(std::span<const std::uint16_t> levels) override {
    for (const std::uint16_t level : levels) {
      if (range_.contains(level)) advertised_.push_back(level);
    }
  }

  Result<void> encode(const DepthImage& depth, const StateImage& states, PlanarDepth& out) override {
    const Codebook earlier = table_;
    if (adaptive_) {
      if (!out.keyframe && has_scene_moved(depth, states)) out.keyframe = true;
      frames_since_layout_ = out.keyframe ? 0 : frames_since_layout_ + 1;
      if (out.keyframe) count(depth, states);
    }
    if (out.keyframe) lay_out();
    out.picture = Picture::uninitialised(PixelFormat::kGray10, depth.width(), depth.height());
    if (!write(depth, states, out.picture)) {
      learn(depth, states);
      write(depth, states, out.picture);
    }
    if (even_ && lossless_) {
      return fail(
          ErrorCode::kUnsupported,
          "this sensor has more than 1024 depth levels within the range, too many for lossless depth: "
          "choose a --depth-qp above 0, or a smaller --range");
    }
    table_.write_change(out.keyframe ? none_ : earlier, out.table);
    return {};
  }

 private:
  static constexpr std::uint16_t kUnknown = 0x8000;  // Flag in code_of_depth_: the depth is not a level.

  // Writes every pixel's code. Returns false if a measured pixel's depth is not a level yet.
  bool write(const DepthImage& depth, const StateImage& states, Picture& picture) const {
    const std::uint16_t* const z = depth.data();
    const DepthState* const state = states.data();
    std::uint16_t* const out = picture.plane10().data();
    const std::size_t size = depth.pixels().size();
    // The image is processed in blocks that stay in the cache. The lookups of a block come first,
    // so that the rest can use vector instructions.
    constexpr std::size_t kBlock = 256;
    int unknown = 0;
    for (std::size_t first = 0; first < size; first += kBlock) {
      const std::size_t end = std::min(size, first + kBlock);
      look_up(code_of_depth_.data(), z + first, out + first, end - first);
      std::uint16_t met = 0;
      for (std::size_t i = first; i < end; ++i) {
        const auto measured =
            static_cast<std::uint16_t>(-static_cast<int>(state[i] == DepthState::kMeasured));
        met = static_cast<std::uint16_t>(met | (out[i] & measured));
        out[i] = static_cast<std::uint16_t>(out[i] & (kUnknown - 1));
      }
      unknown |= met & kUnknown;
    }
    return unknown == 0;
  }

  void learn(const DepthImage& depth, const StateImage& states) {
    std::vector<std::uint16_t> fresh;
    for (std::size_t i = 0; i < depth.pixels().size(); ++i) {
      std::uint16_t& code = code_of_depth_[depth.data()[i]];
      if (!(code & kUnknown) || states.data()[i] != DepthState::kMeasured) continue;
      code = 0;  // Prevents adding the level twice.
      fresh.push_back(depth.data()[i]);
    }
    const bool full = static_cast<std::size_t>(table_.count()) + fresh.size() > Codebook::kCodes;
    if (full && !advertised_.empty()) {
      // There are too many advertised and other levels for the codes. From now on, use only levels
      // that appear in frames.
      advertised_.clear();
      levels_.clear();
      std::fill(code_of_depth_.begin(), code_of_depth_.end(), kUnknown);
      return learn(depth, states);
    }
    const bool anew = full || table_.count() == 0;
    levels_.insert(levels_.end(), fresh.begin(), fresh.end());
    if (anew) return lay_out();
    for (const std::uint16_t level : fresh) table_.insert(level);
    index();
  }

  // Returns the levels for the codebook, ascending. Unless coding is lossless, adaptive omits
  // advertised levels that have not appeared.
  std::vector<std::uint16_t> levels_to_hold() const {
    std::vector<std::uint16_t> levels = levels_;
    if (!adaptive_ || lossless_) levels.insert(levels.end(), advertised_.begin(), advertised_.end());
    std::sort(levels.begin(), levels.end());
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    return levels.size() <= Codebook::kCodes ? levels : levels_;
  }

  void lay_out() {
    std::sort(levels_.begin(), levels_.end());
    even_ = levels_.size() > Codebook::kCodes;
    if (even_) {
      table_.assign_evenly(adaptive_ ? DepthRangeUnits{levels_.front(), levels_.back()} : range_);
    } else if (adaptive_ && !lossless_) {
      table_.assign(levels_, spacing(levels_, pixels_of(levels_)));
    } else {
      const std::vector<std::uint16_t> levels = levels_to_hold();
      table_.assign(levels, table_.sensor_spacing(levels));
    }
    index();
  }

  // Makes the histogram of the measured pixels, for adaptive's spacing.
  void count(const DepthImage& depth, const StateImage& states) {
    std::fill(pixels_.begin(), pixels_.end(), 0u);
    for (std::size_t i = 0; i < depth.pixels().size(); i += kSampling) {
      if (states.data()[i] == DepthState::kMeasured) ++pixels_[depth.data()[i]];
    }
  }

  std::vector<std::uint32_t> pixels_of(std::span<const std::uint16_t> levels) const {
    std::vector<std::uint32_t> pixels;
    for (const std::uint16_t level : levels) pixels.push_back(pixels_[level]);
    return pixels;
  }

  // Returns the distances of adaptive's levels in lossy coding, for the frame counted last.
  //
  // With scene_spacing(), the levels of a surface that enters later get up to four times fewer
  // codes per step than the others. At the same QP, the surface's error is then four times larger.
  // The rate controller cannot compensate for that, and every keyframe with new spacing costs bits.
  // So with a bitrate, all levels have equal spacing. It is two codes per step if the codes suffice
  // for the scene. Otherwise, and at scarce bitrates, the codes are even over the whole range, like
  // those of accuracy10.
  std::vector<double> spacing(std::span<const std::uint16_t> levels,
                              std::span<const std::uint32_t> pixels) const {
    if (!bits_per_frame_) return table_.scene_spacing(levels, pixels);
    const auto first =
        std::find_if(pixels.begin(), pixels.end(), [](std::uint32_t count) { return count > 0; });
    const bool is_near = first != pixels.end() &&
                         levels[static_cast<std::size_t>(first - pixels.begin())] < table_.nearest_double();
    const bool scarce = *bits_per_frame_ < kScarceBits * frame_pixels_;
    return scarce || is_near ? table_.even_spacing(levels) : table_.double_spacing(levels);
  }

  // Returns true if a keyframe with new spacing is worthwhile. The codes at this frame's depths
  // must become finer by kWorthwhileBits on average. Only some frames are tested, so that the
  // codebook changes rarely.
  bool has_scene_moved(const DepthImage& depth, const StateImage& states) {
    if (even_ || lossless_ || frames_since_layout_ < kFramesBetweenLayouts ||
        frames_since_layout_ % kFramesBetweenLooks != 0) {
      return false;
    }
    count(depth, states);
    Codebook laid_out = table_;
    std::vector<std::uint16_t> levels = levels_;
    std::sort(levels.begin(), levels.end());
    const std::vector<std::uint32_t> pixels = pixels_of(levels);
    laid_out.assign(levels, spacing(levels, pixels));
    // Sum of the bits by which each pixel's code spacing would grow, and the number of pixels.
    double finer = 0, all = 0;
    int now = 0, then = 0;  // Codes of the previous level in both codebooks.
    std::size_t level = 0;
    for (int code_now = 0, code_then = 0; level < levels.size(); ++level, ++code_now, ++code_then) {
      while (table_.levels()[code_now] == 0) ++code_now;
      while (laid_out.levels()[code_then] == 0) ++code_then;
      if (level > 0)
        finer += pixels[level] * std::log2(static_cast<double>(code_then - then) / (code_now - now));
      all += pixels[level];
      now = code_now;
      then = code_then;
    }
    return finer > kWorthwhileBits * all;
  }

  // Maps every depth to the code of its nearest level.
  void index() {
    const auto levels = table_.levels();
    int code = -1, next = -1;  // Codes of the last level at or below z, and of the first level above.
    const auto find_next = [&] {
      do ++next;
      while (next < Codebook::kCodes && levels[next] == 0);
    };
    find_next();
    if (next == Codebook::kCodes) return;
    for (int z = range_.near; z <= range_.far; ++z) {
      while (next < Codebook::kCodes && levels[next] <= z) {
        code = next;
        find_next();
      }
      const bool upper = code < 0 || (next < Codebook::kCodes && levels[next] - z < z - levels[code]);
      const int nearest = upper ? next : code;
      const bool is_level = even_ || levels[nearest] == z;
      code_of_depth_[z] = static_cast<std::uint16_t>(nearest | (is_level ? 0 : kUnknown));
    }
  }

  static constexpr std::size_t kSampling = 13;  // Counts every 13th pixel.
  // Minimum number of frames between adaptive's own keyframes.
  static constexpr int kFramesBetweenLayouts = 30;
  static constexpr int kFramesBetweenLooks = 10;
  // Bits per pixel below which a bitrate is scarce: 0.9 Mbit/s for 640x480 pixels at 30 frames per
  // second.
  static constexpr double kScarceBits = 0.1;
  // Minimum gain for a keyframe, in bits per pixel. Half a bit reduces the error by about 6 %.
  static constexpr double kWorthwhileBits = 0.5;

  DepthRangeUnits range_;
  bool adaptive_;
  double frame_pixels_;  // Number of pixels of a frame.
  Codebook table_;
  const Codebook none_;
  std::vector<std::uint16_t> advertised_;  // Levels that the sensor advertises.
  std::vector<std::uint16_t> levels_;      // Other levels that appeared, in any order.
  // Number of pixels by depth, in the frame counted last.
  std::vector<std::uint32_t> pixels_ = std::vector<std::uint32_t>(65536);
  std::optional<double> bits_per_frame_;
  int frames_since_layout_ = 0;
  std::vector<std::uint16_t> code_of_depth_;
  bool lossless_ = false;
  bool even_ = false;  // True if too many levels appeared.
};

class QuantizedDecoder final : public PlaneDecoder {
 public:
  explicit QuantizedDecoder(const DepthFormat& format)
      : table_(format.units(), format.unit, format.noise),
        none_(table_),
        depth_of_code_(table_.depth_of_code()) {}

  Result<void> decode(const PlanarDepth& in, const StateImage&, DepthImage& out) override {
    if (in.keyframe) table_ = none_;
    if (in.keyframe || !in.table.empty()) {
      if (const auto read = table_.read_change(in.table); !read) return fail(read.error());
      depth_of_code_ = table_.depth_of_code();
    }
    read_codes(depth_of_code_, in.picture, out);
    return {};
  }

 private:
  Codebook table_;
  const Codebook none_;
  std::vector<std::uint16_t> depth_of_code_;
};

}  // namespace

std::unique_ptr<PlaneEncoder> make_quantized_encoder(const DepthFormat& format) {
  return std::make_unique<QuantizedEncoder>(format, false);
}

std::unique_ptr<PlaneEncoder> make_adaptive_encoder(const DepthFormat& format) {
  return std::make_unique<QuantizedEncoder>(format, true);
}

std::unique_ptr<PlaneDecoder> make_quantized_decoder(const DepthFormat& format) {
  return std::make_unique<QuantizedDecoder>(format);
}

}  // namespace copresence::depth
