#pragma once

// Of this room only.

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace copresence::scene {

/// All of a file. Fails (kNotFound) where it is none; `as` says in the sentence what it was to be: "a scene file".
Result<std::string> read_text_file(const std::filesystem::path& path, std::string_view as);

}  // namespace copresence::scene
