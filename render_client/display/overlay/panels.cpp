#include "render_client/display/overlay/panels.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>

namespace copresence::overlay {
namespace {

constexpr std::size_t kMostNotices = 8;
constexpr float kMargin = 12;  // Pixels between a panel and the border of the picture.
constexpr float kColumnPixels = 3, kGraphColumns = 40;
constexpr float kLeastGraphMs = 20;  // The least height of a graph.
constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav |
                                    ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing;
// Colours of the stages, in the order of a frame's way.
constexpr std::array kStageColors = {IM_COL32(102, 194, 165, 255), IM_COL32(252, 141, 98, 255),
                                     IM_COL32(141, 160, 203, 255), IM_COL32(231, 138, 195, 255),
                                     IM_COL32(166, 216, 84, 255),  IM_COL32(255, 217, 47, 255),
                                     IM_COL32(229, 196, 148, 255), IM_COL32(179, 179, 179, 255)};

ImU32 stage_color(std::size_t stage) {
  return kStageColors[stage % kStageColors.size()];
}

void write(const std::string& text) {
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
}

void write_rows(const char* name, const std::vector<Row>& rows) {
  if (rows.empty() || !ImGui::BeginTable(name, 2, ImGuiTableFlags_SizingFixedFit)) return;
  for (const Row& row : rows) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    write(row.name);
    ImGui::TableNextColumn();
    write(row.value);
  }
  ImGui::EndTable();
}

/// Begins a panel whose point `pivot` (0 to 1 along each axis) is at `position`.
void begin(const char* name, ImVec2 position, ImVec2 pivot) {
  ImGui::SetNextWindowPos(position, ImGuiCond_Always, pivot);
  ImGui::Begin(name, nullptr, kPanel);
}

/// Returns the area of the panel or tooltip that is being drawn.
Area area() {
  const ImVec2 min = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  return {min, {min.x + size.x, min.y + size.y}};
}

Area end() {
  const Area panel = area();
  ImGui::End();
  return panel;
}

float total(const std::vector<float>& stages) {
  return std::accumulate(stages.begin(), stages.end(), 0.0F);
}

/// Returns the height of all graphs in milliseconds.
float graph_height_ms(const Figures& figures) {
  float height = kLeastGraphMs;
  for (const CameraLine& camera : figures.cameras) {
    for (const auto& stages : camera.stages_ms) height = std::max(height, total(stages));
  }
  return height;
}

/// Draws a bar for each interval, with the stages upon each other. The newest bar is at the right.
/// Appends the area of a tooltip with the newest numbers if the pointer is on the graph.
void draw_graph(const CameraLine& camera, const Figures& figures, float height_ms,
                std::vector<Area>& panels) {
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 size{kColumnPixels * kGraphColumns, 2 * ImGui::GetTextLineHeight()};
  ImDrawList& canvas = *ImGui::GetWindowDrawList();
  const float bottom = corner.y + size.y;
  float left = corner.x + size.x - kColumnPixels * static_cast<float>(camera.stages_ms.size());
  for (const auto& stages : camera.stages_ms) {
    float below = bottom;
    for (std::size_t i = 0; i < stages.size(); ++i) {
      const float above = below - stages[i] / height_ms * size.y;
      if (below - above > 0.2F)
        canvas.AddRectFilled({left, above}, {left + kColumnPixels, below}, stage_color(i));
      below = above;
    }
    left += kColumnPixels;
  }
  canvas.AddLine({corner.x, bottom}, {corner.x + size.x, bottom}, ImGui::GetColorU32(ImGuiCol_Border));
  ImGui::Dummy(size);
  if (camera.stages_ms.empty() || !ImGui::IsItemHovered()) return;
  std::vector<Row> rows;
  for (std::size_t i = 0; i < figures.stages.size(); ++i)
    rows.push_back({figures.stages[i], std::to_string(camera.stages_ms.back()[i]).substr(0, 5) + " ms"});
  ImGui::BeginTooltip();
  write_rows("stages", rows);
  panels.push_back(area());
  ImGui::EndTooltip();
}

void draw_cameras(const Figures& figures, std::vector<Area>& panels) {
  const int columns = static_cast<int>(figures.headings.size()) + 1;
  if (!ImGui::BeginTable("cameras", columns, ImGuiTableFlags_SizingFixedFit)) return;
  const float height_ms = graph_height_ms(figures);
  for (const std::string& heading : figures.headings) ImGui::TableSetupColumn(heading.c_str());
  ImGui::TableSetupColumn(("stages, 0 to " + std::to_string(static_cast<int>(height_ms)) + " ms").c_str());
  ImGui::TableHeadersRow();
  for (const CameraLine& camera : figures.cameras) {
    ImGui::TableNextRow();
    for (const std::string& cell : camera.cells) {
      ImGui::TableNextColumn();
      write(cell);
    }
    ImGui::TableNextColumn();
    draw_graph(camera, figures, height_ms, panels);
  }
  ImGui::EndTable();
  for (std::size_t i = 0; i < figures.stages.size(); ++i) {
    if (i > 0) ImGui::SameLine();
    ImGui::PushStyleColor(ImGuiCol_Text, stage_color(i));
    write(figures.stages[i]);
    ImGui::PopStyleColor();
  }
}

void draw_switches(const std::vector<Switch>& switches, std::vector<int>& clicks) {
  if (!switches.empty()) ImGui::Separator();
  for (const Switch& each : switches) {
    const std::string label =
        each.key + "  " + each.name + ": " + each.state + "##" + std::to_string(each.id);
    if (ImGui::SmallButton(label.c_str())) clicks.push_back(each.id);
  }
}

}  // namespace

Area draw_notices(const Content& content, ImVec2 size) {
  begin("notices", {size.x / 2, size.y - kMargin}, {0.5F, 1});
  ImGui::PushTextWrapPos(std::max(100.0F, size.x - 4 * kMargin));
  const std::size_t count = std::min(content.notices.size(), kMostNotices);
  for (std::size_t i = 0; i < count; ++i) write(content.notices[i]);
  if (content.notices.size() > count)
    write("and " + std::to_string(content.notices.size() - count) + " more");
  if (!content.message.empty()) write(content.message);
  ImGui::PopTextWrapPos();
  return end();
}

Area draw_keys(const std::vector<Row>& keys, ImVec2 size) {
  begin("keys", {size.x - kMargin, kMargin}, {1, 0});
  write_rows("list", keys);
  return end();
}

void draw_figures(const Content& content, std::vector<Area>& panels, std::vector<int>& clicks) {
  begin("figures", {kMargin, kMargin}, {0, 0});
  std::vector<Area> tooltips;
  draw_cameras(content.figures, tooltips);
  write_rows("view", content.figures.view);
  draw_switches(content.switches, clicks);
  panels.push_back(end());
  panels.insert(panels.end(), tooltips.begin(), tooltips.end());
}

}  // namespace copresence::overlay
