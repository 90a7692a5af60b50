# Finds each foreign library once. A module names the ones that it uses under USES (they show in its headers) or HIDES.
if(COPRESENCE_TOOLS AND NOT COPRESENCE_SIMULATION)
  message(FATAL_ERROR "COPRESENCE_TOOLS needs COPRESENCE_SIMULATION, which is off.")
endif()
if((BUILD_TESTING OR COPRESENCE_BENCHMARKS) AND NOT COPRESENCE_TOOLS)
  message(FATAL_ERROR "BUILD_TESTING and COPRESENCE_BENCHMARKS need COPRESENCE_TOOLS, which is off.")
endif()
if(BUILD_TESTING AND NOT COPRESENCE_GATEWAY)
  message(FATAL_ERROR "BUILD_TESTING needs COPRESENCE_GATEWAY, which is off.")
endif()

# Both programs.
find_package(PkgConfig REQUIRED)
find_package(Python3 REQUIRED COMPONENTS Interpreter)  # Python3::Interpreter, which writes the man pages
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)                 # Eigen3::Eigen
find_package(tl-expected REQUIRED)                      # tl::expected
find_package(fmt REQUIRED)                              # fmt::fmt
find_package(spdlog REQUIRED)                           # spdlog::spdlog
find_package(CLI11 REQUIRED)                            # CLI11::CLI11
find_package(nlohmann_json REQUIRED)                    # nlohmann_json::nlohmann_json
find_package(tomlplusplus REQUIRED)                     # tomlplusplus::tomlplusplus
find_package(glfw3 REQUIRED)                            # glfw
find_package(OpenSSL 3 REQUIRED COMPONENTS SSL)          # OpenSSL::SSL
find_package(PNG REQUIRED)                              # PNG::PNG
find_package(ZLIB REQUIRED)                             # ZLIB::ZLIB
pkg_check_modules(EPOXY REQUIRED IMPORTED_TARGET epoxy)
pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)
pkg_check_modules(OPENNI2 REQUIRED IMPORTED_TARGET libopenni2)
pkg_check_modules(FREENECT REQUIRED IMPORTED_TARGET libfreenect)
pkg_check_modules(TURBOJPEG REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(FFMPEG REQUIRED IMPORTED_TARGET libavcodec libavutil)

find_path(ASIO_INCLUDE_DIR asio.hpp REQUIRED)
add_library(copresence_asio INTERFACE)
target_include_directories(copresence_asio SYSTEM INTERFACE ${ASIO_INCLUDE_DIR})
target_compile_definitions(copresence_asio INTERFACE ASIO_STANDALONE ASIO_NO_DEPRECATED)
target_link_libraries(copresence_asio INTERFACE Threads::Threads)
if(COPRESENCE_SANITIZE MATCHES thread)  # The thread sanitizer does not understand fences.
  target_compile_definitions(copresence_asio INTERFACE ASIO_DISABLE_FENCED_BLOCK)
endif()

if(COPRESENCE_GATEWAY)
  find_package(Boost 1.74 REQUIRED CONFIG)              # Boost::headers; Beast and its Asio need no library
  add_library(copresence_beast INTERFACE)
  target_link_libraries(copresence_beast INTERFACE Boost::headers OpenSSL::SSL Threads::Threads)
  target_compile_definitions(copresence_beast INTERFACE BOOST_ASIO_NO_DEPRECATED BOOST_ERROR_CODE_HEADER_ONLY)
  if(COPRESENCE_SANITIZE MATCHES thread)  # As for Asio above.
    target_compile_definitions(copresence_beast INTERFACE BOOST_ASIO_DISABLE_FENCED_BLOCK)
  endif()
endif()

if(COPRESENCE_SIMULATION)
  find_package(embree 4 QUIET)                          # embree; Debian 13 has version 4, Debian 12 version 3
  if(NOT embree_FOUND)
    find_package(embree 3 REQUIRED)
  endif()
endif()

if(COPRESENCE_TOOLS)
  find_package(OpenCV 4 REQUIRED COMPONENTS core imgproc imgcodecs calib3d aruco highgui)
  find_package(yaml-cpp REQUIRED)                       # yaml-cpp
  # OpenCV's headers cause many warnings in C++20 unless they are system headers.
  add_library(copresence_opencv INTERFACE)
  target_include_directories(copresence_opencv SYSTEM INTERFACE ${OpenCV_INCLUDE_DIRS})
  target_link_libraries(copresence_opencv INTERFACE opencv_core opencv_imgproc opencv_imgcodecs)
endif()

if(BUILD_TESTING)
  find_package(GTest REQUIRED)                          # GTest::gtest_main, GTest::gmock
  find_package(rapidcheck REQUIRED)                     # rapidcheck
  include(GoogleTest)
endif()
if(COPRESENCE_BENCHMARKS)
  find_package(benchmark REQUIRED)                      # benchmark::benchmark_main
endif()
