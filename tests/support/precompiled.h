#pragma once

// What most tests include, parsed once instead of by each: cmake/module.cmake puts it before every one of them. A test names what it
// uses nevertheless.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <vector>
