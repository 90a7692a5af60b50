# Headers that most sources include are parsed once. The developers' presets do without: a missing include shows.
function(add_precompiled_headers target)
  add_library(${target} OBJECT ${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp)
  target_link_libraries(${target} PRIVATE copresence::rules Eigen3::Eigen fmt::fmt tl::expected)
  target_precompile_headers(${target} PRIVATE ${PROJECT_SOURCE_DIR}/cmake/precompiled.h)
endfunction()
function(use_precompiled_headers target headers)
  target_link_libraries(${target} PRIVATE Eigen3::Eigen fmt::fmt tl::expected)
  target_precompile_headers(${target} REUSE_FROM ${headers})
endfunction()
if(COPRESENCE_PRECOMPILED)
  add_precompiled_headers(copresence_headers)
  if(COPRESENCE_TWINS)
    add_precompiled_headers(copresence_headers_v3)
    set_target_properties(copresence_headers_v3 PROPERTIES COPRESENCE_V3 ON)
  endif()
endif()

# A module is a folder that is a target: a library whose headers compile alone and which names what it depends on.
#
#   add_module(depth FAST HEADERS a.h PRIVATE b.h SOURCES a.cpp b.cpp USES copresence::frame HIDES copresence_opencv)
#
# makes the library copresence_depth with the alias copresence::depth. HEADERS may be included by others, PRIVATE
# ones only by the module itself and by its tests and benchmarks. USES are public (other modules, libraries whose types
# show in the headers), HIDES are private. A module without SOURCES is header-only.
#
# FAST is for modules with loops over pixels: in a portable build they are shared libraries, built for x86-64-v2 and, as
# copresence_depth_v3, for x86-64-v3. SHARED is for modules with state that FAST modules use: one copy in a program. All
# other modules are static libraries.
#
# UNITY is for modules of many small sources: with COPRESENCE_UNITY, eight of them are compiled at a time. The sources
# may not define a name twice then, not even in anonymous namespaces; those that do are listed under ALONE.
function(add_module name)
  cmake_parse_arguments(MODULE "FAST;SHARED;UNITY" "" "HEADERS;PRIVATE;SOURCES;ALONE;USES;HIDES" ${ARGN})
  set(target copresence_${name})
  if(MODULE_SOURCES)
    set(kind STATIC)
    if(COPRESENCE_TWINS AND (MODULE_FAST OR MODULE_SHARED))
      set(kind SHARED)
    endif()
    add_library(${target} ${kind} ${MODULE_SOURCES} ${MODULE_ALONE})
    if(COPRESENCE_UNITY AND MODULE_UNITY)
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON)
      set_source_files_properties(${MODULE_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
    target_link_libraries(${target} PUBLIC copresence::rules ${MODULE_USES} PRIVATE ${MODULE_HIDES})
    if(COPRESENCE_PRECOMPILED)
      use_precompiled_headers(${target} copresence_headers)
    endif()
    if(kind STREQUAL "SHARED")
      put_private_library(${target} "" "$ORIGIN")
      if(MODULE_FAST)
        add_v3_twin(${target})
      endif()
    endif()
    set(scope PUBLIC)
  else()
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE copresence::rules ${MODULE_USES})
    set(scope INTERFACE)
  endif()
  target_sources(${target} ${scope} FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}
    FILES ${MODULE_HEADERS} ${MODULE_PRIVATE})
  set_target_properties(${target} PROPERTIES COPRESENCE_PRIVATE "${MODULE_PRIVATE}")
  add_library(copresence::${name} ALIAS ${target})
endfunction()

# Our shared libraries lie in lib/copresence, those for x86-64-v3 where glibc's loader looks for them: in
# lib/copresence/glibc-hwcaps/x86-64-v3 (man ld.so).
function(put_private_library target subfolder path_to_others)
  set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/copresence/${subfolder}
    BUILD_RPATH "${path_to_others}" INSTALL_RPATH "${path_to_others}" DEFINE_SYMBOL "")
  target_link_options(${target} PRIVATE LINKER:-Bsymbolic-functions)
  install(TARGETS ${target} LIBRARY DESTINATION lib/copresence/${subfolder})
endfunction()

# The same library for x86-64-v3. Programs link the base only.
function(add_v3_twin target)
  get_target_property(sources ${target} SOURCES)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  get_target_property(unity ${target} UNITY_BUILD)
  add_library(${target}_v3 SHARED ${sources})
  target_link_libraries(${target}_v3 PRIVATE ${libraries})
  set_target_properties(${target}_v3 PROPERTIES OUTPUT_NAME ${target} COPRESENCE_V3 ON
    UNITY_BUILD ${unity})
  if(COPRESENCE_PRECOMPILED)
    use_precompiled_headers(${target}_v3 copresence_headers_v3)
  endif()
  put_private_library(${target}_v3 glibc-hwcaps/x86-64-v3 "$ORIGIN/../..")
  add_dependencies(${target} ${target}_v3)
endfunction()

# Tests are half of what is compiled. Their common headers are parsed once (tests/support), and -O1 is fast enough for
# them.
function(compile_as_test target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  target_link_libraries(${target} PRIVATE copresence::rules Eigen3::Eigen fmt::fmt tl::expected GTest::gmock)
endfunction()

# Tests of code that reads what others wrote: files, streams, messages. ./run test-parsers runs them under sanitizers.
if(BUILD_TESTING)
  add_custom_target(parser_tests)
endif()

# One test program for one module. LABEL is unit (below a second, no hardware, no GL, no network), gl (headless EGL) or
# pipeline (real processes over loopback). SERIAL ones run beside no other: they measure time. PARSER ones belong to
# parser_tests; their label is unit.parser, which `ctest -L unit` finds, too.
#
#   add_module_test(depth LABEL unit SOURCES depth_codec_test.cpp USES copresence::depth)
function(add_module_test name)
  cmake_parse_arguments(TEST "SERIAL;PARSER" "LABEL;TIMEOUT" "SOURCES;USES;ENVIRONMENT" ${ARGN})
  if(NOT TEST_TIMEOUT)
    set(TEST_TIMEOUT 120)
  endif()
  if(COPRESENCE_SANITIZE)
    math(EXPR TEST_TIMEOUT "5 * ${TEST_TIMEOUT}")
  endif()
  set(target ${name}_test)
  add_executable(${target} ${TEST_SOURCES})
  compile_as_test(${target})
  target_precompile_headers(${target} REUSE_FROM copresence_test_headers)
  target_link_libraries(${target} PRIVATE ${TEST_USES} GTest::gtest_main)
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(TEST_PARSER)
    add_dependencies(parser_tests ${target})
    string(APPEND TEST_LABEL .parser)
  endif()
  set(environment)
  if(TEST_ENVIRONMENT)
    set(environment ENVIRONMENT ${TEST_ENVIRONMENT})
  elseif(TEST_LABEL STREQUAL "gl" AND COPRESENCE_SANITIZE MATCHES "address")
    set(environment ENVIRONMENT ASAN_OPTIONS=detect_leaks=0)  # Mesa and LLVM keep memory to the end
  endif()
  gtest_discover_tests(${target} DISCOVERY_MODE PRE_TEST WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    PROPERTIES LABELS ${TEST_LABEL} TIMEOUT ${TEST_TIMEOUT} RUN_SERIAL ${TEST_SERIAL} ${environment})
endfunction()

# One benchmark program for one module: numbers only, never a verdict.
function(add_module_benchmark name)
  cmake_parse_arguments(BENCHMARK "" "" "SOURCES;USES" ${ARGN})
  set(target ${name}_benchmark)
  add_executable(${target} ${BENCHMARK_SOURCES})
  target_link_libraries(${target} PRIVATE copresence::rules ${BENCHMARK_USES} benchmark::benchmark_main)
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/benchmarks)
  set_property(GLOBAL APPEND PROPERTY COPRESENCE_BENCHMARK_TARGETS ${target})
endfunction()

# One fuzz function (LLVMFuzzerTestOneInput) with its corpus, a folder of inputs. The fuzz preset makes NAME_fuzz with
# libFuzzer:  build/fuzz/tests/NAME_fuzz -max_total_time=60 FOLDER.  Everywhere else the corpus and its near
# neighbours are replayed as a unit test.
#
#   add_fuzz_target(message SOURCES message_fuzz.cpp CORPUS message_corpus USES copresence::wire)
function(add_fuzz_target name)
  cmake_parse_arguments(FUZZ "" "CORPUS" "SOURCES;USES" ${ARGN})
  set(target ${name}_fuzz)
  add_executable(${target} ${FUZZ_SOURCES})
  target_link_libraries(${target} PRIVATE copresence::rules ${FUZZ_USES})
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(COPRESENCE_FUZZ)
    target_link_options(${target} PRIVATE -fsanitize=fuzzer)
  else()
    target_sources(${target} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/replay_corpus.cpp)
    add_test(NAME ${name}_corpus COMMAND ${target} ${CMAKE_CURRENT_SOURCE_DIR}/${FUZZ_CORPUS})
    set_tests_properties(${name}_corpus PROPERTIES LABELS unit.parser TIMEOUT 120)
    add_dependencies(parser_tests ${target})
  endif()
endfunction()
