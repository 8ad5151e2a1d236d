#include "fricid/film/gl_context.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "fricid/base/error.hpp"

namespace fricid::film {
namespace {

TEST(GlBackend, NamesGoBothWays) {
  for (const GlBackend backend : {GlBackend::kEgl, GlBackend::kOsmesa})
    EXPECT_EQ(backend_of(name_of(backend)), backend);
  EXPECT_THROW(backend_of("vulkan"), UserError);
}

TEST(GlContext, EnvironmentChooses) {
  setenv("FRICID_GL", "osmesa", 1);
  EXPECT_EQ(make_gl_context()->backend(), GlBackend::kOsmesa);
}

TEST(GlContext, AProcessKeepsItsKind) {
  make_gl_context(GlBackend::kOsmesa);
  EXPECT_EQ(make_gl_context(GlBackend::kOsmesa)->backend(), GlBackend::kOsmesa);
  EXPECT_THROW(make_gl_context(GlBackend::kEgl), UserError);
}

TEST(GlContext, OsmesaDrawsByTheProcessor) {
  const auto context = make_gl_context(GlBackend::kOsmesa);
  EXPECT_TRUE(draws_by_processor(context->functions())) << context->renderer();
  const GlLookup other = [](const char*) {
    return reinterpret_cast<void*>(
        +[](unsigned) { return reinterpret_cast<const unsigned char*>("a GPU"); });
  };
  EXPECT_FALSE(draws_by_processor(other));
}

TEST(GlContext, UnknownNamesAreRefused) { EXPECT_THROW(make_gl_context("metal"), UserError); }

}  // namespace
}  // namespace fricid::film
