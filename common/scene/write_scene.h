#pragma once

// Writes the scene file. An existing file keeps comments and layout. Thread: pure functions.

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"
#include "common/scene/scene.h"

namespace copresence::scene {

/// Returns the text of a new scene file at `path`. Relative paths of recordings are written
/// relative to the folder of `path`. Reading gives the same scene: numbers to the last bit, poses
/// to 1e-11.
std::string to_toml(const Scene& scene, const std::filesystem::path& path);

/// Changes the text of a scene file to describe `scene`. Equal values, comments and the order of
/// entries stay unchanged. Cameras are identified by name: new cameras are appended, and cameras
/// that `scene` lacks are removed. A text that cannot be changed in place, for example with cameras
/// in inline tables, is replaced by to_toml(). `path` is the path of the resulting file; relative
/// paths of recordings are relative to its folder. Fails as parse() does if `text` is not a scene
/// file.
Result<std::string> rewrite(std::string_view text, const Scene& scene, const std::filesystem::path& path);

/// Writes the scene to `path`. If there is a file at `layout`, the result is rewrite() of that
/// file, otherwise to_toml(). A failure leaves the old file at `path` unchanged. Fails with
/// kInvalid if the file at `layout` is not a scene file. Fails with kInvalid, too, if the result
/// could not be read again, for example because a name is not UTF-8. Fails with kUnavailable if
/// `path` cannot be written.
Result<void> save(const Scene& scene, const std::filesystem::path& path, const std::filesystem::path& layout);

}  // namespace copresence::scene
