# Embeds shaders into a module, so that no program looks for files at run time:
#
#   embed_shaders(copresence_gl_renderer depth_mesh.vert depth_mesh.frag)
#
# makes "shaders/depth_mesh.vert.h" with copresence::shaders::depth_mesh_vert, a constexpr std::string_view.
# The build step: cmake -DFOLDER=... -P embed_shaders.cmake SHADER...
if(CMAKE_SCRIPT_MODE_FILE STREQUAL CMAKE_CURRENT_LIST_FILE)
  math(EXPR last "${CMAKE_ARGC} - 1")
  foreach(i RANGE 4 ${last})
    get_filename_component(name ${CMAKE_ARGV${i}} NAME)
    string(REPLACE "." "_" symbol ${name})
    file(READ ${CMAKE_ARGV${i}} text)
    file(WRITE ${FOLDER}/${name}.h "// Made from shaders/ by cmake/embed_shaders.cmake.
#pragma once

#include <string_view>

namespace copresence::shaders {
inline constexpr std::string_view ${symbol} = R\"glsl(${text})glsl\";
}  // namespace copresence::shaders
")
  endforeach()
  return()
endif()

set(embed_shaders_script ${CMAKE_CURRENT_LIST_FILE})
function(embed_shaders target)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/embedded)
  list(TRANSFORM ARGN PREPEND ${PROJECT_SOURCE_DIR}/shaders/ OUTPUT_VARIABLE sources)
  list(TRANSFORM ARGN REPLACE "(.+)" "${folder}/shaders/\\1.h" OUTPUT_VARIABLE headers)
  add_custom_command(OUTPUT ${headers}
    COMMAND ${CMAKE_COMMAND} -DFOLDER=${folder}/shaders -P ${embed_shaders_script} ${sources}
    DEPENDS ${sources} ${embed_shaders_script} COMMENT "Embedding shaders into ${target}" VERBATIM)
  foreach(each ${target} ${target}_v3)
    if(TARGET ${each})
      target_sources(${each} PRIVATE ${headers})
      target_include_directories(${each} PRIVATE ${folder})
    endif()
  endforeach()
endfunction()
