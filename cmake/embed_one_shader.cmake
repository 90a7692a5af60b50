# Writes one shader as a header. Run by embed_shaders() with SOURCE, HEADER and SYMBOL.
file(READ ${SOURCE} text)
file(WRITE ${HEADER} "// Made from shaders/ by cmake/embed_shaders.cmake.
#pragma once

#include <string_view>

namespace copresence::shaders {
inline constexpr std::string_view ${SYMBOL} = R\"glsl(${text})glsl\";
}  // namespace copresence::shaders
")
