#pragma once

// The images of a set, decoded: depth in metres' parts, whatever way the set stores it, and colour.
//
// Thread: free functions; concurrent calls are safe.

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::record {

/// How a set stores depth; found out from its first image.
enum class DepthCoding {
  kWhole,             ///< 16-bit numbers, in parts of a metre
  kSwapped,           ///< the same with the two bytes of each number exchanged
  kKinectDisparity,   ///< a Kinect's raw 11-bit disparities, as NYU's and fakenect's PGM files hold them
  kSwappedDisparity,  ///< the same with exchanged bytes
  kFloat,             ///< floating-point numbers (TIFF, PFM)
};

/// Largest side of an image, pixels.
inline constexpr int kLargestSide = 4096;

/// A depth image as stored: CV_16UC1 or CV_32FC1. An odd width or height is made even by leaving out the last column or
/// row: a recording's sizes are even.
/// Fails  as pictures::load(); kCorrupt: it does not decode; kInvalid: not one channel of 16 bits or floats, or larger
///        than kLargestSide.
Result<cv::Mat> read_depth(const std::filesystem::path& path);

/// Depth is smooth: of two ways to read its bytes the smoother one is right.
DepthCoding find_coding(const cv::Mat& first, const std::filesystem::path& path);

/// The middle of all measured values, in the numbers that `--depth-scale` divides; metres for kKinectDisparity.
/// 0 where nothing was measured.
double median_depth(const cv::Mat& stored, DepthCoding coding);

/// Depth in `unit`. `per_metre` is what one metre is in the file, and without meaning for disparities. 65535, infinities
/// and what is not above zero are holes. Depth beyond the unit's range becomes a hole and is counted in `too_far`.
DepthImage convert_depth(const cv::Mat& stored, DepthCoding coding, double per_metre, DepthUnit unit,
                         std::uint64_t& too_far);

struct ColorPicture {
  cv::Mat bgr;                           ///< 8 bits, as its camera was held, of even size
  std::vector<std::uint8_t> jpeg_as_is;  ///< the file where a recording can hold it unchanged, else empty
};

/// Fails  as read_depth(), but for the number of channels and bits.
Result<ColorPicture> read_color(const std::filesystem::path& path);

/// Width and height as stored, before a column or a row is left out. Fails as pictures::read_header().
Result<bool> is_odd(const std::filesystem::path& path);

}  // namespace copresence::record
