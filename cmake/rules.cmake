# What every target of the project compiles with.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_VERIFY_INTERFACE_HEADER_SETS ON)
# From bin, tests and benchmarks to the private OpenNI2 folder, see capture_server/drivers.
set(CMAKE_BUILD_RPATH "$ORIGIN/../lib/copresence")
set(CMAKE_INSTALL_RPATH "$ORIGIN/../lib/copresence")
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g")
# Lets a compiler cache look into the tests' precompiled header.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_FLAGS MATCHES "-fpch-preprocess")
  string(APPEND CMAKE_CXX_FLAGS " -fpch-preprocess")
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3")  # asserts stay on: a broken promise of the caller is never silent

add_library(copresence_rules INTERFACE)
add_library(copresence::rules ALIAS copresence_rules)
target_include_directories(copresence_rules INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(copresence_rules INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wno-sign-conversion
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>  # g++ 12 at -O3 sees one inside fmt's own parser
  # One result for one input, whatever the instruction set: no fused multiply-add behind our back.
  -ffp-contract=off
  # Nobody here looks at floating-point exceptions; believing in them keeps loops with comparisons from using vectors.
  -fno-trapping-math -fno-math-errno)
if(COPRESENCE_WERROR)
  target_compile_options(copresence_rules INTERFACE -Werror)
endif()
set(arch ${COPRESENCE_ARCH})
if(arch STREQUAL "auto")
  # Not "native": g++ 12 warns about its own AVX-512 headers, and a v3 binary runs on the lab's other machines too.
  set(arch "")
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND EXISTS /proc/cpuinfo)
    file(READ /proc/cpuinfo cpuinfo)
    if(cpuinfo MATCHES " avx2 " AND cpuinfo MATCHES " fma " AND cpuinfo MATCHES " bmi2 ")
      set(arch x86-64-v3)
    endif()
  endif()
endif()
if(arch)
  target_compile_options(copresence_rules INTERFACE -march=${arch})
endif()
if(COPRESENCE_SANITIZE)
  target_compile_options(copresence_rules INTERFACE
    -fsanitize=${COPRESENCE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)  # g++ 12 then sees one inside std::regex (GCC bug 105562)
  target_link_options(copresence_rules INTERFACE -fsanitize=${COPRESENCE_SANITIZE})
endif()
if(COPRESENCE_FUZZ)
  target_compile_options(copresence_rules INTERFACE -fsanitize=fuzzer-no-link)
endif()
