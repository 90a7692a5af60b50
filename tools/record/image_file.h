#pragma once

// Reads depth and colour images of the formats that public data sets use.
// Thread: free functions; concurrent calls are safe.

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "common/frame/depth_unit.h"
#include "common/frame/image.h"
#include "common/result.h"

namespace copresence::record {

/// How images store depth. The first image of a folder determines it for all images.
enum class DepthCoding {
  kWhole,             ///< 16-bit integers.
  kSwapped,           ///< 16-bit integers with exchanged bytes.
  kKinectDisparity,   ///< Raw 11-bit disparities of a Kinect, as in PGM files of NYU and fakenect.
  kSwappedDisparity,  ///< Raw disparities with exchanged bytes.
  kFloat,             ///< Floating-point numbers (TIFF, PFM).
};

/// Largest side of an image, pixels.
inline constexpr int kLargestSide = 4096;

/// Reads a depth image as stored: CV_16UC1 or CV_32FC1. Recordings need even sizes, so the last
/// column or row of an odd size is left out.
/// Fails as pictures::load() does, and with kCorrupt if the image cannot be decoded. Fails with
/// kInvalid if it is larger than kLargestSide, or does not have one channel of 16 bits or floats.
Result<cv::Mat> read_depth(const std::filesystem::path& path);

/// Recognises the coding. Depth is smooth, so the byte order with the smoother image is right.
DepthCoding find_coding(const cv::Mat& first, const std::filesystem::path& path);

/// Median of all measured pixels: metres for disparities, otherwise pixel values. 0 if none.
double median_depth(const cv::Mat& stored, DepthCoding coding);

/// Converts depth to `unit`. `per_metre` is the pixel value of one metre; disparities ignore it.
/// Holes are 65535, infinity, NaN and values up to 0. Depth beyond the range of the unit becomes a
/// hole and is counted in `too_far`.
DepthImage convert_depth(const cv::Mat& stored, DepthCoding coding, double per_metre, DepthUnit unit,
                         std::uint64_t& too_far);

struct ColorPicture {
  cv::Mat bgr;  ///< Pixels of 8 bits per channel; upright, of even size.
  std::vector<std::uint8_t>
      jpeg_as_is;  ///< The JPEG file if a recording can contain it unchanged, otherwise empty.
};

/// Fails as read_depth() does, but accepts any number of channels and bits.
Result<ColorPicture> read_color(const std::filesystem::path& path);

/// True if the stored width or height is odd. Fails as pictures::read_header() does.
Result<bool> is_odd(const std::filesystem::path& path);

}  // namespace copresence::record
