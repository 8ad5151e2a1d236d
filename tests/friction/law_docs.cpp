#include "law_docs.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "fricid/friction/robot_friction.hpp"

namespace fricid::friction::test {
namespace {

// a bar would end the cell of a table
std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

// Two members of a numbered family that differ in their number only.
bool alike(const ParameterInfo& a, const ParameterInfo& b) {
  return a.stem() == b.stem() && a.role == b.role && a.lower == b.lower && a.upper == b.upper &&
         a.typical == b.typical && a.scale == b.scale && a.meaning == b.meaning;
}

const char* searched(Scale scale) {
  return scale == Scale::kLog ? "log" : scale == Scale::kLinear ? "linear" : "constant";
}

// One row per parameter, members of a family that are alike in one.
std::string parameter_table(const std::vector<ParameterInfo>& parameters) {
  if (parameters.empty()) return "No parameters.\n";
  std::string table =
      "| parameter | unit | bounds | typical | searched | meaning |\n|---|---|---|---|---|---|\n";
  for (std::size_t i = 0, end; i < parameters.size(); i = end) {
    const ParameterInfo& p = parameters[i];
    for (end = i + 1; end < parameters.size() && alike(p, parameters[end]);) ++end;
    std::string symbols = fmt::format("`{}`", p.symbol);
    if (end > i + 1) symbols += fmt::format(" .. `{}`", parameters[end - 1].symbol);
    table +=
        fmt::format("| {} | {} | {:.4g} .. {:.4g} | {:.4g} | {} | {} |\n", symbols, cell(p.unit),
                    p.lower, p.upper, p.typical, searched(p.scale), cell(p.meaning));
  }
  return table;
}

std::string claims(const Claims& c) {
  std::string text;
  const auto add = [&](bool claimed, const char* word) {
    if (claimed) text += (text.empty() ? "" : ", ") + std::string(word);
  };
  add(c.odd, "odd");
  add(c.dissipative, "dissipative");
  add(c.contracts, "contracting");
  add(c.semigroup, "two half steps equal one");
  add(c.settles, "settling");
  return text.empty() ? "none" : text;
}

std::string section(const LawInfo& info, const std::vector<ParameterInfo>& parameters) {
  return fmt::format("### {}\n\n    {}\n\nSource: {}. Claims: {}.\n\n{}\n", info.name,
                     info.equation, info.source, claims(info.claims), parameter_table(parameters));
}

}  // namespace

std::string law_docs() {
  std::string text = "\n## Laws\n\n";
  for (const LawInfo& law : law_table()) {
    text += section(law, parameters_of_law(law.name, 1));
    if (law.has_elements)
      text += fmt::format(
          "This is for elements = 1. The numbered parameters grow with elements = 1 .. {}: {} in "
          "all "
          "for 4, {} for {}.\n\n",
          law.most_elements, parameters_of_law(law.name, 4).size(),
          parameters_of_law(law.name, std::min(16, law.most_elements)).size(),
          std::min(16, law.most_elements));
  }
  text +=
      "## Laws of the whole robot\n\n"
      "One network sees all joints at once. The tables are for two joints and elements = 1.\n\n";
  for (const LawInfo& law : robot_law_table()) {
    text += section(law, parameters_of_robot_law(law.name, {2, 1}));
    text += fmt::format("{} parameters in all for 6 joints and elements = 32, the most.\n\n",
                        parameters_of_robot_law(law.name, {6, 32}).size());
  }
  text += "## Modifiers\n\n";
  for (const LawInfo& modifier : modifier_table()) {
    text += section(modifier, parameters_of_modifier(modifier.name, 1));
    if (modifier.has_elements)
      text += fmt::format("For several terms the numbered parameters repeat; order = 1 .. {}.\n\n",
                          modifier.most_elements);
  }
  return text;
}

std::string with_law_docs(const std::string& page) {
  const std::string begin = "<!-- from the table: begin -->\n",
                    end = "<!-- from the table: end -->";
  const auto from = page.find(begin), to = page.find(end);
  if (from == std::string::npos || to == std::string::npos) return page;
  return page.substr(0, from + begin.size()) + law_docs() + page.substr(to);
}

}  // namespace fricid::friction::test
