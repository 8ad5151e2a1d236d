// Text in XML that this project writes.
#pragma once

#include <string_view>

#include "fricid/base/code.hpp"

namespace fricid {

using Xml = Code<struct XmlLanguage>;

/// Text as an attribute with its quotes.
Xml xml_attribute(std::string_view text);

/// Text as a comment, which it cannot end.
Xml xml_comment(std::string_view text);

}  // namespace fricid
