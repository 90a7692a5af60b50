#include "render_client/display/overlay/overlay.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <cmath>

#include "render_client/display/overlay/panels.h"

namespace copresence::overlay {
namespace {

using std::chrono::steady_clock;

constexpr float kFontPixels = 13;    // The size for which ImGui's own font is drawn.
constexpr float kRowsPerFont = 900;  // At 1350 rows the font doubles, at 2250 it triples, and so on.

}  // namespace

struct Overlay::Interface {
  ImGuiContext* context = nullptr;
  steady_clock::time_point drawn_at{};
  std::vector<Area> panels;  // Of the last picture.
  bool is_dragged = false;   // Whether a button is held down that was pressed on a panel.
  bool was_pressed = false;  // Whether that button was pressed since the last picture.

  bool has_panel_at(ImVec2 point) const {
    return std::any_of(panels.begin(), panels.end(),
                       [&](const Area& panel) { return panel.contains(point); });
  }
};

Overlay::Overlay(gl::Context& context, std::vector<Row> keys)
    : interface_(std::make_unique<Interface>()), keys_(std::move(keys)) {
  assert(context.is_on_its_thread());
  assert(!ImGui::GetCurrentContext());
  IMGUI_CHECKVERSION();
  interface_->context = ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // The panels have fixed positions.
  io.LogFilename = nullptr;
  ImGui::GetStyle().WindowRounding = 4;
  ImGui_ImplOpenGL3_Init("#version 450");
}

Overlay::~Overlay() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext(interface_->context);
}

bool Overlay::take(const window::Event& event) {
  ImVec2& pointer = ImGui::GetIO().MousePos;
  if (const auto* move = std::get_if<window::MoveEvent>(&event)) {
    pointer = {static_cast<float>(move->x), static_cast<float>(move->y)};
    return interface_->is_dragged && (move->left || move->right || move->middle);
  }
  if (const auto* button = std::get_if<window::ButtonEvent>(&event)) {
    pointer = {static_cast<float>(button->x), static_cast<float>(button->y)};
    const bool is_taken = interface_->is_dragged || interface_->has_panel_at(pointer);
    interface_->is_dragged = button->pressed && is_taken;
    interface_->was_pressed |= interface_->is_dragged;
    return is_taken;
  }
  return std::holds_alternative<window::ScrollEvent>(event) && interface_->has_panel_at(pointer);
}

void Overlay::draw(int width, int height) {
  std::vector<Area>& panels = interface_->panels;
  panels.clear();
  const bool has_notices = !content_.notices.empty() || !content_.message.empty();
  if (width <= 0 || height <= 0 || (!has_notices && !lists_keys_ && !shows_figures_)) return;
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
  io.MouseDown[0] = interface_->is_dragged || std::exchange(interface_->was_pressed, false);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  if (has_notices) panels.push_back(draw_notices(content_, io.DisplaySize));
  if (shows_figures_) panels.push_back(draw_figures(content_, clicks_));
  if (lists_keys_) panels.push_back(draw_keys(keys_, io.DisplaySize));
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace copresence::overlay
