#pragma once

// Writes the views of a headless run as a film. Thread: one thread at a time.

#include <memory>
#include <string>

#include "common/frame/image.h"
#include "common/frame/rgbd_frame.h"
#include "common/result.h"

namespace copresence::film {

class Film {
 public:
  virtual ~Film() = default;

  /// Adds a view. `time` is the time since the film's beginning and must never decrease. Requires
  /// views of the film's size. Fails with kUnavailable if the file cannot be written.
  virtual Result<void> add(const Image<Rgba8>& view, Duration time) = 0;

  /// Completes the film. Call it last.
  virtual Result<void> finish() = 0;
};

/// Returns whether the path is that of a Matroska file, and not of a folder.
bool is_film_file(const std::string& path);

/// A path that ends in .mkv is a Matroska file with H.264, which an existing file is replaced by.
/// Other paths are folders, which are created. They get the pictures 000000.png, 000001.png and so
/// on, one for each view. `width` and `height` are even. Fails if the file or folder cannot be
/// made, and with kUnsupported without libx264.
Result<std::unique_ptr<Film>> open_film(const std::string& path, int width, int height,
                                        double views_per_second);

}  // namespace copresence::film
