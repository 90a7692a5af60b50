#include "common/scene/write_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "common/scene/toml_entries.h"
#include "common/text/text_file.h"
#include "common/toml/parse_toml.h"

namespace copresence::scene {
namespace {

namespace fs = std::filesystem;

// Collects changes to a text. All positions refer to the original text.
class EditedText {
 public:
  explicit EditedText(std::string_view text) : text_(text) {
    lines_.push_back(0);
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') lines_.push_back(i + 1);
    }
  }

  void replace(const toml::node& value, const std::string& by) {
    edits_.push_back({offset(value.source().begin), offset(value.source().end), by});
  }
  void remove_lines(std::uint32_t first, std::uint32_t last) {
    edits_.push_back({start_of(first), start_of(last + 1), ""});
  }
  void insert_after(std::uint32_t line, const std::string& new_line) {
    const std::size_t at = start_of(line + 1);
    const bool is_cut = at == text_.size() && !text_.empty() && text_.back() != '\n';
    edits_.push_back({at, at, (is_cut && !was_cut_ ? "\n" : "") + new_line + "\n"});
    was_cut_ = was_cut_ || is_cut;
  }
  void append(const std::string& lines) { insert_after(static_cast<std::uint32_t>(lines_.size()), lines); }

  /// Returns the first of the comment lines directly above `line`, or `line` if there are none.
  std::uint32_t first_of_comment_above(std::uint32_t line) const {
    while (line > 1 && text_.substr(start_of(line - 1)).starts_with('#')) --line;
    return line;
  }

  std::string apply() {
    // Changes at the same position keep the order of the calls.
    std::stable_sort(edits_.begin(), edits_.end(),
                     [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
    std::string out;
    std::size_t done = 0;
    for (const Edit& edit : edits_) {
      if (edit.begin > done) out += text_.substr(done, edit.begin - done);
      out += edit.text;
      done = std::max(done, edit.end);
    }
    return out += text_.substr(done);
  }

 private:
  struct Edit {
    std::size_t begin, end;
    std::string text;
  };

  std::size_t start_of(std::uint32_t line) const {
    return line >= 1 && line <= lines_.size() ? lines_[line - 1] : text_.size();
  }
  // toml++ counts columns in characters, not in bytes.
  std::size_t offset(const toml::source_position& place) const {
    std::size_t at = start_of(place.line);
    for (std::uint32_t column = 1; column < place.column && at < text_.size(); ++column) {
      do ++at;
      while (at < text_.size() && (static_cast<unsigned char>(text_[at]) & 0xC0) == 0x80);
    }
    return at;
  }

  std::string_view text_;
  std::vector<std::size_t> lines_;  // Position at which each line begins.
  std::vector<Edit> edits_;
  bool was_cut_ = false;
};

std::uint32_t last_line(const toml::table& table) {
  std::uint32_t last = table.source().end.line;
  for (const auto& [key, value] : table) last = std::max(last, value.source().end.line);
  return last;
}

std::string camera_block(const Camera& camera, const fs::path& folder) {
  std::string text = "\n[[camera]]";
  for (const auto& [key, value] : entries(camera, folder)) {
    if (value) text += fmt::format("\n{} = {}", key, *value);
  }
  return text;
}

std::string clip_block(const Box& clip) {
  std::string text = "\n[clip]";
  for (const auto& [key, value] : entries(clip)) text += fmt::format("\n{} = {}", key, value);
  return text;
}

void rewrite_camera(EditedText& text, const toml::table& table, const Camera& from, const Camera& to,
                    const fs::path& folder) {
  const auto before = entries(from, folder), after = entries(to, folder);
  std::uint32_t line = table.source().end.line;  // Missing keys are inserted after this line.
  for (std::size_t i = 0; i < after.size(); ++i) {
    const auto& [key, value] = after[i];
    const auto found = table.find(key);
    if (found == table.end()) {
      if (value) text.insert_after(line, fmt::format("{} = {}", key, *value));
      continue;
    }
    line = found->second.source().end.line;
    if (value == before[i].second) continue;
    if (value) {
      text.replace(found->second, *value);
    } else {
      text.remove_lines(found->first.source().begin.line, line);
    }
  }
}

void rewrite_clip(EditedText& text, const toml::table& root, const Scene& before, const Scene& after) {
  const auto found = root.find("clip");
  if (found == root.end()) {
    if (after.clip) text.append(clip_block(*after.clip));
    return;
  }
  const toml::table& table = *found->second.as_table();
  if (!after.clip) return text.remove_lines(found->first.source().begin.line, last_line(table));
  const auto from = entries(*before.clip), to = entries(*after.clip);
  for (std::size_t i = 0; i < to.size(); ++i) {
    if (from[i].second != to[i].second) text.replace(*table.get(to[i].first), to[i].second);
  }
}

// Reading normalises the vector, which may change the last digit.
bool is_same_up(const Scene& a, const Scene& b) {
  return a.up.isApprox(b.up, 1e-12);
}

// Changes a key of the whole file. A new key becomes the file's first one.
void rewrite_root(EditedText& text, const toml::table& root, std::string_view name,
                  const std::string& value) {
  if (const toml::node* node = root.get(name)) return text.replace(*node, value);
  std::uint32_t first = root.get("camera")->source().begin.line;
  for (const auto& [key, node] : root) first = std::min(first, key.source().begin.line);
  text.insert_after(text.first_of_comment_above(first) - 1, fmt::format("{} = {}", name, value));
}

void rewrite_key(EditedText& text, const toml::table& root, const Scene& before, const Scene& after,
                 const fs::path& folder) {
  if (before.key == after.key) return;
  if (!after.key.empty()) return rewrite_root(text, root, "key", path_text(after.key, folder));
  const std::uint32_t line = root.get("key")->source().begin.line;
  text.remove_lines(line, line);
}

bool say_the_same(const Scene& a, const Scene& b, const fs::path& folder) {
  if (a.cameras.size() != b.cameras.size() || !is_same_up(a, b)) return false;
  if (path_text(a.key, folder) != path_text(b.key, folder)) return false;
  if (a.clip.has_value() != b.clip.has_value() || (a.clip && entries(*a.clip) != entries(*b.clip)))
    return false;
  return std::all_of(a.cameras.begin(), a.cameras.end(), [&](const Camera& camera) {
    const Camera* other = b.find(camera.name);
    if (!other) return false;
    // Reading takes the nearest rotation, which may change the last digit of a pose.
    Camera posed = *other;
    if (posed.world_from_camera && camera.world_from_camera &&
        posed.world_from_camera->matrix().isApprox(camera.world_from_camera->matrix(), 1e-9)) {
      posed.world_from_camera = camera.world_from_camera;
    }
    if (posed.color && camera.color &&
        posed.color->color_from_depth.matrix().isApprox(camera.color->color_from_depth.matrix(), 1e-9)) {
      posed.color->color_from_depth = camera.color->color_from_depth;
    }
    return entries(camera, folder) == entries(posed, folder);
  });
}

// Checks that the text can be read again before it replaces a file.
Result<void> check_readable(const std::string& text, const Scene& scene, const fs::path& path) {
  const auto again = parse(text, path);
  if (!again) {
    return fail(ErrorCode::kInvalid, fmt::format("{}: is not written, since it could not be read again: {}",
                                                 path.string(), again.error().what));
  }
  const bool has_all = std::all_of(scene.cameras.begin(), scene.cameras.end(),
                                   [&](const Camera& camera) { return again->find(camera.name); });
  if (has_all && again->cameras.size() == scene.cameras.size()) return {};
  return fail(ErrorCode::kInvalid,
              fmt::format("{}: is not written, since its cameras' names would change", path.string()));
}

}  // namespace

std::string to_toml(const Scene& scene, const fs::path& path) {
  std::string text =
      fmt::format("# Metres; camera frames are x right, y down, z forward.\nup = {}\n", toml_text(scene.up));
  if (!scene.key.empty()) text += fmt::format("key = {}\n", path_text(scene.key, path.parent_path()));
  for (const Camera& camera : scene.cameras) text += camera_block(camera, path.parent_path()) + "\n";
  if (scene.clip) text += clip_block(*scene.clip) + "\n";
  return text;
}

Result<std::string> rewrite(std::string_view text, const Scene& scene, const fs::path& path) {
  const auto before = parse(text, path);
  if (!before) return fail(before.error());
  const auto root = parse_toml(text, path);
  if (!root) return fail(root.error());
  const fs::path folder = path.parent_path();

  EditedText edited(text);
  if (!is_same_up(*before, scene)) rewrite_root(edited, *root, "up", toml_text(scene.up));
  rewrite_key(edited, *root, *before, scene, folder);
  for (const auto& entry : *root->get_as<toml::array>("camera")) {
    const toml::table& table = *entry.as_table();
    const Camera& from = *before->find(table["name"].ref<std::string>());
    if (const Camera* to = scene.find(from.name)) {
      rewrite_camera(edited, table, from, *to, folder);
    } else {
      edited.remove_lines(table.source().begin.line, last_line(table));
    }
  }
  for (const Camera& camera : scene.cameras) {
    if (!before->find(camera.name)) edited.append(camera_block(camera, folder));
  }
  rewrite_clip(edited, *root, *before, scene);

  const std::string in_place = edited.apply();
  const auto after = parse(in_place, path);
  return after && say_the_same(*after, scene, folder) ? in_place : to_toml(scene, path);
}

Result<void> save(const Scene& scene, const fs::path& path, const fs::path& layout) {
  std::string text;
  if (std::error_code ignored; fs::exists(layout, ignored)) {
    const auto old = text::read_text_file(layout, "a scene file");
    if (!old) return fail(old.error());
    auto rewritten = rewrite(*old, scene, path);
    if (!rewritten) return fail(rewritten.error());
    text = std::move(*rewritten);
  } else {
    text = to_toml(scene, path);
  }
  if (auto readable = check_readable(text, scene, path); !readable) return readable;
  // If the path is a symbolic link, replace its target. The target keeps its permissions.
  std::error_code ignored, problem;
  const fs::path target = fs::exists(path, ignored) ? fs::canonical(path, ignored) : path;
  const auto rights = fs::status(target, ignored).permissions();
  const fs::path unfinished = target.string() + ".new";
  std::ofstream file(unfinished, std::ios::binary);
  file << text << std::flush;
  if (file && rights != fs::perms::unknown && fs::exists(target, ignored)) {
    fs::permissions(unfinished, rights, ignored);
  }
  if (file) fs::rename(unfinished, target, problem);
  if (!file || problem) {
    fs::remove(unfinished, ignored);
    return fail(
        ErrorCode::kUnavailable,
        fmt::format(
            "{}: cannot be written; is the folder there, may you write in it, and is the disk not full?",
            path.string()));
  }
  return {};
}

}  // namespace copresence::scene
