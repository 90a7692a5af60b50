#pragma once

// Codecs accuracy8 and accuracy10: one plane whose codes are linear in 1/z over the stream's range.
// A code is the same number of disparity steps at every depth.
//
//   code = round((N - 1) (1/near - 1/z) / (1/near - 1/far)),  N = 256 or 1024
//
// Without video coding, the error is half a code, z² (1/near - 1/far) / (2 (N - 1)), plus half a
// unit of rounding. Parameters: near, far in the stream's unit. Source: thesis 3.3.3.1; Khoshelham
// and Elberink 2012 (form of the error).

#include <memory>

#include "common/depth/depth_format.h"
#include "common/depth/plane_codec.h"

namespace copresence::depth {

std::unique_ptr<PlaneEncoder> make_accuracy_encoder(const DepthFormat& format, PixelFormat picture);
/// Fails with kInvalid if the parameters are impossible.
Result<std::unique_ptr<PlaneDecoder>> make_accuracy_decoder(const DepthCodecDescription& description,
                                                            const DepthFormat& format);

}  // namespace copresence::depth
