#pragma once

// Writes the scene file and the ground truth of simulate_kinect.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/truth/true_camera.h"

namespace copresence::simulate_kinect {

/// The scene file for cameras camera0, camera1, ... with the same intrinsics. Addresses begin at
/// 127.0.0.1:7001. The source of each camera is its recording in the scene file's folder.
std::string scene_toml(const CameraModel& model, std::span<const Rigid3> poses, const std::string& made_by);

/// Fails with kUnavailable if the file cannot be written.
Result<void> write_text(const std::filesystem::path& path, const std::string& text);

/// Writes depth_NNNN.png (16 bits, 0.1 mm) and color_NNNN.png to an existing folder.
/// Fails with kUnavailable if a file cannot be written.
Result<void> write_truth(const std::filesystem::path& folder, int frame, const simulation::TrueView& view);

}  // namespace copresence::simulate_kinect
