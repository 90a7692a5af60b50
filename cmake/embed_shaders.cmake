# Embeds shaders into a module, so that no program looks for files at run time:
#
#   embed_shaders(copresence_gl_renderer depth_mesh.vert depth_mesh.frag)
#
# makes "shaders/depth_mesh.vert.h" with copresence::shaders::depth_mesh_vert, a constexpr std::string_view.
function(embed_shaders target)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/embedded)
  set(headers)
  foreach(shader ${ARGN})
    set(source ${PROJECT_SOURCE_DIR}/shaders/${shader})
    set(header ${folder}/shaders/${shader}.h)
    string(REPLACE "." "_" symbol ${shader})
    add_custom_command(OUTPUT ${header}
      COMMAND ${CMAKE_COMMAND} -DSOURCE=${source} -DHEADER=${header} -DSYMBOL=${symbol}
              -P ${PROJECT_SOURCE_DIR}/cmake/embed_one_shader.cmake
      DEPENDS ${source} ${PROJECT_SOURCE_DIR}/cmake/embed_one_shader.cmake
      VERBATIM)
    list(APPEND headers ${header})
  endforeach()
  foreach(each ${target} ${target}_v3)
    if(TARGET ${each})
      target_sources(${each} PRIVATE ${headers})
      target_include_directories(${each} PRIVATE ${folder})
    endif()
  endforeach()
endfunction()
