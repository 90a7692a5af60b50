#pragma once

// Converts the values of a scene to TOML text. Private to this module. Thread: pure functions.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/scene/scene.h"

namespace copresence::scene {

/// True if a camera's source is the path of a file. False for an empty source, and for a source
/// with any scheme, such as `openni:` or `simulated:`.
bool is_path(std::string_view source);

/// A key and its value as TOML text. Without a value, the file must not have the key.
using Entry = std::pair<std::string, std::optional<std::string>>;

/// Returns all keys of one camera, in the order of docs/guide/scene_file.md. Two cameras have the
/// same value of a key exactly if these texts are equal. `folder` is the folder of the scene file.
/// Paths in `camera` are relative to the working directory, paths in the text are relative to
/// `folder`.
std::vector<Entry> entries(const Camera& camera, const std::filesystem::path& folder);

/// Returns a path as TOML text. A relative path in `path` is relative to the working directory, one
/// in the text is relative to `folder`.
std::string path_text(const std::string& path, const std::filesystem::path& folder);

/// Returns `min` and `max` of the table [clip].
std::array<std::pair<std::string, std::string>, 2> entries(const Box& clip);

/// Returns the text `[x, y, z]`.
std::string toml_text(const Eigen::Vector3d& v);

}  // namespace copresence::scene
