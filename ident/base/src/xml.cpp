#include "fricid/base/xml.hpp"

#include <string>

#include "fricid/base/names.hpp"

namespace fricid {

Xml xml_attribute(std::string_view text) {
  std::string result = "\"";
  for (const char c : printable(text))
    result += c == '&'   ? std::string("&amp;")
              : c == '<' ? std::string("&lt;")
              : c == '"' ? std::string("&quot;")
                         : std::string(1, c);
  return Xml(Vouched{result + "\""});
}

Xml xml_comment(std::string_view text) {
  std::string result;
  for (const char c : printable(text)) {
    if (c == '-' && result.ends_with('-')) result += ' ';
    result += c;
  }
  return Xml(Vouched{"<!-- " + result + " -->"});
}

}  // namespace fricid
