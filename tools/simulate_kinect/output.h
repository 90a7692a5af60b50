#pragma once

// What simulate_kinect leaves beside the recordings: the scene file and pictures of the truth.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/frame/camera_model.h"
#include "common/frame/rigid3.h"
#include "common/result.h"
#include "simulation/truth/true_camera.h"

namespace copresence::simulate_kinect {

/// The scene file for cameras camera0, camera1, ... of one model, addresses from 127.0.0.1:7001 on, each with
/// its recording beside the file as source.
std::string scene_toml(const CameraModel& model, std::span<const Rigid3> poses, const std::string& made_by);

/// Fails  kUnavailable when the file cannot be written whole.
Result<void> write_text(const std::filesystem::path& path, const std::string& text);

/// depth_NNNN.png (16 bits, 0.1 mm) and color_NNNN.png in an existing folder.
/// Fails  kUnavailable when they cannot be written.
Result<void> write_truth(const std::filesystem::path& folder, int frame, const simulation::TrueView& view);

}  // namespace copresence::simulate_kinect
