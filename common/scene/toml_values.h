#pragma once

// A scene's values as TOML text. Of this room only.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/scene.h"

namespace copresence::scene {

/// Key and value as text; no value where the file is not to have the key.
using Entry = std::pair<std::string, std::optional<std::string>>;

/// All keys of one camera, in the order of docs/guide/scene_file.md. Two cameras say the same of a key exactly where these
/// texts are equal.
///
/// folder  the scene file's; recordings named relatively are written relative to it.
std::vector<Entry> entries(const Camera& camera, const std::filesystem::path& folder);

/// min and max of [clip].
std::array<std::pair<std::string, std::string>, 2> entries(const Box& clip);

/// `[x, y, z]`
std::string toml_text(const Eigen::Vector3d& v);

}  // namespace copresence::scene
