// OpenGL functions found at run time, without its header.
#pragma once

#include <type_traits>

#include "fricid/base/error.hpp"
#include "fricid/film/gl_context.hpp"

namespace fricid::film {

// <GL/gl.h>
inline constexpr unsigned kSrcAlpha = 0x0302, kOneMinusSrcAlpha = 0x0303, kFrontAndBack = 0x0408,
                          kLighting = 0x0B50, kBlend = 0x0BE2, kScissorTest = 0x0C11;

/// Sets a pointer to the function of that name.
/// @throws UserError naming a function that this OpenGL lacks
template <class Call>
void find_call(const GlLookup& function, Call*& call, const char* name) {
  static_assert(std::is_function_v<Call>);
  call = reinterpret_cast<Call*>(function(name));
  if (!call) throw UserError("this OpenGL has no {}; arms need a compatibility profile", name);
}

}  // namespace fricid::film
