#pragma once

#include <memory>

#include "fricid/film/gl_context.hpp"

namespace fricid::film {

std::unique_ptr<GlContext> make_osmesa_context(int width, int height);
std::unique_ptr<GlContext> make_egl_context(int width, int height);

}  // namespace fricid::film
