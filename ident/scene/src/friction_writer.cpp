#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "fricid/config/toml_file.hpp"
#include "fricid/data/friction_keys.hpp"
#include "friction_toml.hpp"

namespace fricid::scene {
namespace {

using config::toml_number;
using config::toml_text;
using data::find_row;
using data::FrictionKey;
using data::FrictionOwner;
using data::law_owner;
using data::list_bounds;
using data::modifier_owner;
using friction::Friction;
using friction::JointSpec;
using friction::LawInfo;
using friction::LawSpec;
using friction::ModifierSpec;
using friction::ParameterInfo;

std::string joined(std::size_t count, const std::function<std::string(std::size_t)>& item) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i ? ", " : "") + item(i);
  return "[" + text + "]";
}

// "key = value" for one owner; values[j] starts with its parameters.
void write_values(const FrictionOwner& owner, const std::vector<std::vector<double>>& values,
                  const std::function<void(const std::string&)>& emit) {
  for (const FrictionKey& key : owner.keys) {
    const std::string value = joined(values.size(), [&](std::size_t j) {
      const auto one = [&](std::size_t e) {
        return toml_number(values[j][static_cast<std::size_t>(key.members[e])]);
      };
      return key.family ? joined(key.members.size(), one) : one(0);
    });
    emit(fmt::format("{} = {}", key.key, value));
  }
}

std::string write_entry(const LawEntry& entry, const std::vector<std::string>& joint_names) {
  const LawInfo& row = *find_row(friction::law_table(), entry.spec.law);
  std::string text = fmt::format("\n[[friction.law]]\nlaw = {}\n", toml_text(entry.spec.law));
  text += fmt::format("joints = {}\n", joined(entry.joints.size(), [&](std::size_t j) {
                        return toml_text(joint_names[static_cast<std::size_t>(entry.joints[j])]);
                      }));
  if (row.has_elements) text += fmt::format("elements = {}\n", entry.spec.elements);
  const FrictionOwner law = law_owner(row, entry.spec.elements);
  write_values(law, entry.values, [&](const std::string& line) { text += line + "\n"; });

  std::size_t begin = law.parameters.size();
  for (const ModifierSpec& spec : entry.spec.modifiers) {
    const LawInfo& modifier_row = *find_row(friction::modifier_table(), spec.name);
    const FrictionOwner modifier = modifier_owner(modifier_row, spec.order);
    std::vector<std::vector<double>> values;
    for (const auto& all : entry.values)
      values.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(begin), all.end());
    std::string inside = modifier_row.has_elements ? fmt::format("order = {}", spec.order) : "";
    write_values(modifier, values,
                 [&](const std::string& item) { inside += (inside.empty() ? "" : ", ") + item; });
    text += fmt::format("{} = {{{}}}\n", spec.name, inside);
    begin += modifier.parameters.size();
  }
  return text;
}

bool same(const LawSpec& a, const LawSpec& b) {
  return a.law == b.law && a.elements == b.elements &&
         std::equal(a.modifiers.begin(), a.modifiers.end(), b.modifiers.begin(), b.modifiers.end(),
                    [](const ModifierSpec& x, const ModifierSpec& y) {
                      return x.name == y.name && x.order == y.order;
                    });
}

}  // namespace

std::string write_friction(const Friction& friction, const std::vector<std::string>& joint_names) {
  std::string text = "\n[friction]\nload = \"motor_torque\"\n";
  const std::vector<JointSpec>& joints = friction.model.joints();
  std::vector<int> next(joints.size());
  for (std::size_t j = 0; j < joints.size(); ++j)
    next[j] = friction.model.parameter_begin(static_cast<int>(j));

  // Laws in order of their position; joints that share one are written together.
  std::size_t most = 0;
  for (const JointSpec& joint : joints) most = std::max(most, joint.laws.size());
  for (std::size_t i = 0; i < most; ++i) {
    std::vector<LawEntry> entries;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].laws.size() <= i) continue;
      const LawSpec& spec = joints[j].laws[i];
      auto entry = std::find_if(entries.begin(), entries.end(),
                                [&](const LawEntry& e) { return same(e.spec, spec); });
      if (entry == entries.end()) {
        entries.push_back({.spec = spec, .joints = {}, .values = {}});
        entry = entries.end() - 1;
      }
      std::size_t count = friction::parameters_of_law(spec.law, spec.elements).size();
      for (const ModifierSpec& m : spec.modifiers)
        count += friction::parameters_of_modifier(m.name, m.order).size();
      const auto begin = friction.theta.begin() + next[j];
      entry->joints.push_back(static_cast<int>(j));
      entry->values.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(count));
      next[j] += static_cast<int>(count);
    }
    for (const LawEntry& entry : entries) text += write_entry(entry, joint_names);
  }
  return text;
}

std::string friction_template() {
  constexpr int kElements = 3;
  std::string text =
      "# Each [[friction.law]] adds one law to `joints` (all when absent). A value is a number "
      "for\n"
      "# all of them or an array with one per joint; for a law with `elements`, families take one\n"
      "# array per joint or the products k = {elements = [...], joints = [...]}. Modifiers are\n"
      "# tables inside a law; they apply in the order given below, the first innermost.\n";
  const auto describe = [&](const FrictionOwner& owner, std::string_view prefix, bool one_line) {
    std::string line;
    for (const FrictionKey& key : owner.keys) {
      const ParameterInfo& info = owner.parameters[static_cast<std::size_t>(key.members[0])];
      text += fmt::format("{}# {}: {}, {}{}\n", one_line ? "# " : "", key.key, info.meaning,
                          list_bounds(info), key.family ? ", one per element" : "");
      if (one_line) {
        line +=
            fmt::format("{}{} = {}", line.empty() ? "" : ", ", key.key, toml_number(info.typical));
      } else {
        text += fmt::format("{}{} = {}\n", prefix, key.key, toml_number(info.typical));
      }
    }
    return line;
  };
  for (const LawInfo& row : friction::law_table()) {
    const bool active = row.name == "lugre";
    const std::string_view prefix = active ? "" : "# ";
    const FrictionOwner law = law_owner(row, row.has_elements ? kElements : 0);
    text += fmt::format("\n# {}\n# Source: {}\n{}[[friction.law]]\n{}law = \"{}\"\n", row.equation,
                        row.source, prefix, prefix, row.name);
    if (row.has_elements) text += fmt::format("{}elements = {}\n", prefix, kElements);
    describe(law, prefix, false);
  }
  text += "\n# Modifiers, as further keys of a law:\n";
  for (const LawInfo& row : friction::modifier_table()) {
    text += fmt::format("# {}\n# Source: {}\n", row.equation, row.source);
    const FrictionOwner modifier = modifier_owner(row, 1);
    const std::string line = describe(modifier, "", true);
    text += fmt::format("# {} = {{{}{}}}\n", row.name, row.has_elements ? "order = 1, " : "", line);
  }
  return text;
}

}  // namespace fricid::scene
