#pragma once

#include <string>

namespace fricid::friction::test {

/// The tables of all laws and modifiers in Markdown, from law_table() and modifier_table().
std::string law_docs();

/// `page` with what stands between its two marks replaced by law_docs(). The page is left as it is
/// when it has no marks.
std::string with_law_docs(const std::string& page);

/// Path of the page under the root of the sources.
inline constexpr const char* kLawDocsPage = "docs/friction_laws.md";

}  // namespace fricid::friction::test
