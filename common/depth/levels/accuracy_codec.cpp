#include "common/depth/levels/accuracy_codec.h"

#include <algorithm>
#include <cmath>

#include "common/depth/levels/code_map.h"

namespace copresence::depth {
namespace {

int codes_of(PixelFormat picture) {
  return picture == PixelFormat::kGray10 ? 1024 : 256;
}

class AccuracyEncoder final : public PlaneEncoder {
 public:
  AccuracyEncoder(const DepthFormat& format, PixelFormat picture)
      : range_(format.units()), picture_(picture) {
    const double near = 1.0 / range_.near, far = 1.0 / range_.far;
    code_of_depth_.resize(65536, 0);
    for (int z = range_.near; z <= range_.far; ++z) {
      const double code = (codes_of(picture) - 1) * (near - 1.0 / z) / (near - far);
      code_of_depth_[z] = static_cast<std::uint16_t>(std::lround(code));
    }
  }

  DepthCodecDescription description() const override {
    return {picture_ == PixelFormat::kGray10 ? "accuracy10" : "accuracy8",
            picture_,
            {{"near", range_.near}, {"far", range_.far}}};
  }

  Result<void> encode(const DepthImage& depth, const StateImage&, PlanarDepth& out) override {
    out.picture = Picture::uninitialised(picture_, depth.width(), depth.height());
    write_codes(code_of_depth_, depth, out.picture);
    return {};
  }

 private:
  DepthRangeUnits range_;
  PixelFormat picture_;
  std::vector<std::uint16_t> code_of_depth_;
};

class AccuracyDecoder final : public PlaneDecoder {
 public:
  AccuracyDecoder(DepthRangeUnits range, DepthRangeUnits allowed, int codes) {
    const double near = 1.0 / range.near, far = 1.0 / range.far;
    for (int code = 0; code < codes; ++code) {
      const double z = 1 / (near - (near - far) * code / (codes - 1));
      depth_of_code_.push_back(
          static_cast<std::uint16_t>(std::lround(std::clamp<double>(z, allowed.near, allowed.far))));
    }
  }

  Result<void> decode(const PlanarDepth& in, const StateImage&, DepthImage& out) override {
    read_codes(depth_of_code_, in.picture, out);
    return {};
  }

 private:
  std::vector<std::uint16_t> depth_of_code_;
};

}  // namespace

std::unique_ptr<PlaneEncoder> make_accuracy_encoder(const DepthFormat& format, PixelFormat picture) {
  return std::make_unique<AccuracyEncoder>(format, picture);
}

Result<std::unique_ptr<PlaneDecoder>> make_accuracy_decoder(const DepthCodecDescription& description,
                                                            const DepthFormat& format) {
  const auto range = described_range(description);
  if (!range) return fail(range.error());
  return std::make_unique<AccuracyDecoder>(*range, format.units(), codes_of(description.format));
}

}  // namespace copresence::depth
