#pragma once

// The scene file being written: a new one, or one that people have written comments into.
//
// Thread: pure functions.

#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"
#include "common/scene/scene.h"

namespace copresence::scene {

/// The scene as a file's text, to lie at `path`: recordings in it are named relative to the folder of `path` where
/// the scene names them relatively. parse() reads the same scene back: numbers to the last bit, poses to 1e-11.
std::string to_toml(const Scene& scene, const std::filesystem::path& path);

/// `text` changed so that it says what `scene` says. Only values that differ are touched: comments, order and
/// layout of everything else stay. Cameras are told apart by name; new ones come last, those that `scene` does not
/// have are taken out. A text of a form that cannot be changed in place (cameras in inline tables, say) is written
/// anew, without its comments.
///
/// path    where the text is to lie; what relative recordings in it are relative to.
/// Fails   as parse() does where `text` is no scene file.
Result<std::string> rewrite(std::string_view text, const Scene& scene, const std::filesystem::path& path);

/// Writes the scene to `path`: as rewrite() of the file at `layout` where there is one, else anew. The file is
/// replaced whole or not at all.
/// Fails   kInvalid where `layout` is there but no scene file, or where what would be written could not be read again (a
///         name that is not UTF-8, say): the old file stays. kUnavailable where `path` cannot be written.
Result<void> save(const Scene& scene, const std::filesystem::path& path, const std::filesystem::path& layout);

}  // namespace copresence::scene
