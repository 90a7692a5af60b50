# How every target of the project is compiled.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# From bin, tests and benchmarks to our own shared libraries and the private OpenNI2 folder (capture_server/drivers).
set(CMAKE_BUILD_RPATH "$ORIGIN/../lib/copresence")
set(CMAKE_INSTALL_RPATH "$ORIGIN/../lib/copresence")
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g")
if(COPRESENCE_SANITIZE)  # halves the time of a build; reports need line numbers only
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1")
endif()
# Lets ccache look into precompiled headers.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_CXX_FLAGS MATCHES "-fpch-preprocess")
  string(APPEND CMAKE_CXX_FLAGS " -fpch-preprocess")
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3")  # Without NDEBUG: asserts stay on in what users run.

add_library(copresence_rules INTERFACE)
add_library(copresence::rules ALIAS copresence_rules)
target_include_directories(copresence_rules INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(copresence_rules INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wno-sign-conversion
  $<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow>  # g++ 12 at -O3 reports one inside fmt's parser
  # g++ 14 at -O3 reports both inside std::optional and std::vector, where there is neither.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,13>>:-Wno-maybe-uninitialized>
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,13>>:-Wno-array-bounds>
  # The same result on every machine: the compiler may not fuse a multiplication and an addition.
  -ffp-contract=off
  # Nothing here reads errno or floating-point exceptions. Without these flags g++ does not vectorise loops that compare
  # or take roots.
  -fno-trapping-math -fno-math-errno)
if(COPRESENCE_WERROR)
  target_compile_options(copresence_rules INTERFACE -Werror)
endif()

# COPRESENCE_ARCH=portable: the programs run on every x86-64-v2 processor. Modules marked FAST (cmake/module.cmake) are
# built a second time for x86-64-v3, and the loader takes those where the processor has AVX2. Both give the same
# results:
#   -mno-fma                 Eigen uses fused multiplications wherever the compiler offers them
#   EIGEN_MAX_ALIGN_BYTES    Eigen's types have one layout, although vectors have 16 bytes in one and 32 in the other
set(COPRESENCE_TWINS OFF)
set(arch ${COPRESENCE_ARCH})
if(arch STREQUAL "portable")
  set(arch "")
  if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
    set(COPRESENCE_TWINS ON)
    target_compile_options(copresence_rules INTERFACE
      -march=$<IF:$<BOOL:$<TARGET_PROPERTY:COPRESENCE_V3>>,x86-64-v3,x86-64-v2> -mno-fma -fno-semantic-interposition
      $<$<CXX_COMPILER_ID:GNU>:-Wno-psabi>)  # no vector of eight numbers crosses from one library to another
    target_compile_definitions(copresence_rules INTERFACE EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MAX_STATIC_ALIGN_BYTES=16)
  endif()
elseif(arch STREQUAL "auto")
  # Not "native": g++ 12 warns about its own AVX-512 headers, and an x86-64-v3 binary also runs on the lab's other
  # machines.
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

if(COPRESENCE_UNITY)  # where sources of types with members from anonymous namespaces look like headers to g++
  target_compile_options(copresence_rules INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()

if(COPRESENCE_SANITIZE)
  target_compile_options(copresence_rules INTERFACE
    -fsanitize=${COPRESENCE_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)  # g++ 12 then reports one inside std::regex (GCC bug 105562)
  target_link_options(copresence_rules INTERFACE -fsanitize=${COPRESENCE_SANITIZE})
endif()
if(COPRESENCE_FUZZ)
  target_compile_options(copresence_rules INTERFACE -fsanitize=fuzzer-no-link)
endif()
