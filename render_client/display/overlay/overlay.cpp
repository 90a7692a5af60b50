#include "render_client/display/overlay/overlay.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <cmath>
#include <optional>

#include "common/gl/canvas.h"
#include "render_client/display/overlay/panels.h"

namespace copresence::overlay {
namespace {

using std::chrono::steady_clock;

constexpr float kFontPixels = 13;    // The size for which ImGui's own font is drawn.
constexpr float kRowsPerFont = 900;  // At 1350 rows the font doubles, at 2250 it triples, and so on.

}  // namespace

struct Overlay::Interface {
  ImGuiContext* context = nullptr;
  std::optional<gl::Canvas> canvas;  // It has the panels.
  std::vector<Area> panels;
  steady_clock::time_point drawn_at{};
  bool is_stale = true;      // Whether the panels must be drawn again.
  bool is_dragged = false;   // Whether a button is held down that was pressed on a panel.
  bool was_pressed = false;  // Whether that button was pressed since the panels were drawn.

  bool has_panel_at(ImVec2 point) const {
    return std::any_of(panels.begin(), panels.end(),
                       [&](const Area& panel) { return panel.contains(point); });
  }

  /// Moves the pointer. The panels under it change.
  void point_at(double x, double y) {
    ImVec2& pointer = ImGui::GetIO().MousePos;
    is_stale |= has_panel_at(pointer);
    pointer = {static_cast<float>(x), static_cast<float>(y)};
    is_stale |= has_panel_at(pointer);
  }

  void copy_panels(std::uint32_t framebuffer) const {
    for (const Area& panel : panels) {
      const int left = static_cast<int>(std::max(panel.min.x, 0.0F)),
                top = static_cast<int>(std::max(panel.min.y, 0.0F));
      const int right = std::min(static_cast<int>(panel.max.x), canvas->width());
      const int bottom = std::min(static_cast<int>(panel.max.y), canvas->height());
      if (left >= right || top >= bottom) continue;
      canvas->copy(left, canvas->height() - bottom, right - left, bottom - top, framebuffer);
    }
  }
};

Overlay::Overlay(gl::Context& context, std::vector<Row> keys)
    : context_(context), interface_(std::make_unique<Interface>()), keys_(std::move(keys)) {
  assert(context.is_on_its_thread());
  assert(!ImGui::GetCurrentContext());
  IMGUI_CHECKVERSION();
  interface_->context = ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // The panels have fixed positions.
  io.LogFilename = nullptr;
  ImGui::GetStyle().Colors[ImGuiCol_WindowBg].w = ImGui::GetStyle().Colors[ImGuiCol_PopupBg].w = 1;
  ImGui_ImplOpenGL3_Init("#version 450");
}

Overlay::~Overlay() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext(interface_->context);
}

void Overlay::set_content(Content content) {
  content_ = std::move(content);
  interface_->is_stale = true;
}

void Overlay::toggle_keys() {
  lists_keys_ = !lists_keys_;
  interface_->is_stale = true;
}

void Overlay::toggle_figures() {
  shows_figures_ = !shows_figures_;
  interface_->is_stale = true;
}

bool Overlay::take(const window::Event& event) {
  if (const auto* move = std::get_if<window::MoveEvent>(&event)) {
    interface_->point_at(move->x, move->y);
    return interface_->is_dragged && (move->left || move->right || move->middle);
  }
  const ImVec2& pointer = ImGui::GetIO().MousePos;
  if (const auto* button = std::get_if<window::ButtonEvent>(&event)) {
    interface_->point_at(button->x, button->y);
    const bool is_taken = interface_->is_dragged || interface_->has_panel_at(pointer);
    interface_->is_stale |= is_taken;
    interface_->is_dragged = button->pressed && is_taken;
    interface_->was_pressed |= interface_->is_dragged;
    return is_taken;
  }
  return std::holds_alternative<window::ScrollEvent>(event) && interface_->has_panel_at(pointer);
}

void Overlay::draw(std::uint32_t framebuffer, int width, int height) {
  if (width <= 0 || height <= 0) return;
  std::optional<gl::Canvas>& canvas = interface_->canvas;
  const bool fits = canvas && canvas->width() == width && canvas->height() == height;
  if (interface_->is_stale || !fits) {
    if (!fits) canvas.emplace(context_, width, height);
    draw_panels(width, height);
  }
  interface_->copy_panels(framebuffer);
}

void Overlay::draw_panels(int width, int height) {
  std::vector<Area>& panels = interface_->panels;
  panels.clear();
  interface_->is_stale = false;
  const bool has_notices = !content_.notices.empty() || !content_.message.empty();
  if (!has_notices && !lists_keys_ && !shows_figures_) return;
  ImGuiIO& io = ImGui::GetIO();
  if (io.Fonts->Fonts.empty()) {
    ImFontConfig font;
    font.SizePixels = kFontPixels * std::max(1.0F, std::round(static_cast<float>(height) / kRowsPerFont));
    io.Fonts->AddFontDefault(&font);
  }
  const auto now = steady_clock::now();
  io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  io.DeltaTime = std::clamp(std::chrono::duration<float>(now - interface_->drawn_at).count(), 1e-4F, 1.0F);
  interface_->drawn_at = now;
  io.MouseDown[0] = interface_->is_dragged || interface_->was_pressed;
  // The panels are drawn again after a short click, without the button.
  interface_->is_stale = std::exchange(interface_->was_pressed, false) && !interface_->is_dragged;
  for (int pass = 0; pass < 2; ++pass) {  // The first pass measures the panels.
    panels.clear();
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    if (has_notices) panels.push_back(draw_notices(content_, io.DisplaySize));
    if (shows_figures_) draw_figures(content_, panels, clicks_);
    if (lists_keys_) panels.push_back(draw_keys(keys_, io.DisplaySize));
    ImGui::Render();
  }
  interface_->canvas->begin();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace copresence::overlay
