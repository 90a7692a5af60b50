#pragma once

// The values of a scene as TOML text. Private to this module. Thread: pure functions.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/scene/scene.h"

namespace copresence::scene {

/// True if a camera's source is the path of a file. False for an empty source and for one with a
/// scheme, such as `openni:` or `simulated:`, whatever the scheme is.
bool is_path(std::string_view source);

/// A key and its value as TOML text; no value if the file must not have the key.
using Entry = std::pair<std::string, std::optional<std::string>>;

/// All keys of one camera, in the order of docs/guide/scene_file.md. Two cameras have the same
/// value of a key exactly if these texts are equal.
///
/// folder  of the scene file; paths that are relative to the working directory are written relative
///         to it.
std::vector<Entry> entries(const Camera& camera, const std::filesystem::path& folder);

/// `min` and `max` of [clip].
std::array<std::pair<std::string, std::string>, 2> entries(const Box& clip);

/// `[x, y, z]`
std::string toml_text(const Eigen::Vector3d& v);

}  // namespace copresence::scene
