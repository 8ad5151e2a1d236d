// Text in XML that this project writes.
#pragma once

#include <string_view>

#include "fricid/base/code.hpp"

namespace fricid {

using Xml = Code<struct XmlLanguage>;

/// Text as an attribute with its quotes.
Xml xml_attribute(std::string_view text);

}  // namespace fricid
