#include "friction_toml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "fricid/base/error.hpp"
#include "fricid/base/text.hpp"
#include "toml_file.hpp"
#include "toml_reader.hpp"

namespace fricid::data {
namespace {

using friction::Friction;
using friction::JointSpec;
using friction::LawInfo;
using friction::LawSpec;
using friction::ModifierSpec;
using friction::ParameterInfo;

constexpr int kMostElements = 64;

const LawInfo* find_row(std::span<const LawInfo> rows, std::string_view name) {
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const LawInfo& info) { return info.name == name; });
  return row == rows.end() ? nullptr : &*row;
}

std::vector<std::string> names_of(std::span<const LawInfo> rows) {
  std::vector<std::string> names;
  for (const LawInfo& row : rows) names.emplace_back(row.name);
  return names;
}

// A law or a modifier with its parameters for a number of elements.
struct Owner {
  std::string name;
  std::vector<ParameterInfo> parameters;
  std::vector<FrictionKey> keys;
};

Owner make_owner(const LawInfo& row, int elements, bool modifier) {
  const auto parameters = [&](int count) {
    return modifier ? friction::parameters_of_modifier(row.name, count)
                    : friction::parameters_of_law(row.name, count);
  };
  Owner owner{.name = std::string(row.name), .parameters = parameters(elements), .keys = {}};
  owner.keys = friction_keys(owner.parameters,
                             row.has_elements ? parameters(elements + 1) : owner.parameters);
  return owner;
}

std::string unit_suffix(const ParameterInfo& info) {
  return info.unit == "1" ? "" : fmt::format(" {}", info.unit);
}

std::string bounds(const ParameterInfo& info) {
  return fmt::format("{:g} to {:g}{}", info.lower, info.upper, unit_suffix(info));
}

// Reads the values of one table for the joints it applies to: values[j][p].
class ValueReader {
 public:
  ValueReader(const toml::table& table, std::string section, std::string where,
              const std::vector<std::string>& joints)
      : table_(table), section_(std::move(section)), where_(std::move(where)), joints_(joints) {}

  std::vector<std::vector<double>> read(const Owner& owner) const {
    std::vector<std::vector<double>> values(joints_.size(),
                                            std::vector<double>(owner.parameters.size()));
    for (const FrictionKey& key : owner.keys) {
      const ParameterInfo& first = owner.parameters[static_cast<std::size_t>(key.members[0])];
      const toml::node* node = table_.get(key.key);
      if (!node)
        throw UserError("{}: {}.{} is missing; {} needs it: {}, allowed: {}", where_, section_,
                        key.key, owner.name, first.meaning, bounds(first));
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        for (std::size_t e = 0; e < key.members.size(); ++e) {
          const auto p = static_cast<std::size_t>(key.members[e]);
          const double value = entry(*node, key, j, e);
          check(*node, owner.parameters[p], j, value);
          values[j][p] = value;
        }
      }
    }
    return values;
  }

 private:
  // Value of element e of joint j: a number for all, an array over joints (of arrays over elements
  // for a family), or {elements, joints} for their products.
  double entry(const toml::node& node, const FrictionKey& key, std::size_t j, std::size_t e) const {
    if (const auto value = as_number(node)) return *value;
    if (const toml::array* array = node.as_array(); array && array->size() == joints_.size()) {
      const toml::node& of_joint = *array->get(j);
      if (const auto value = as_number(of_joint); value && !key.family) return *value;
      const toml::array* elements = of_joint.as_array();
      if (key.family && elements && elements->size() == key.members.size())
        if (const auto value = as_number(*elements->get(e))) return *value;
    }
    if (const toml::table* table = node.as_table(); table && key.family && table->size() == 2) {
      const auto elements = factor(table->get("elements"), key.members.size(), e);
      const auto joints = factor(table->get("joints"), joints_.size(), j);
      if (elements && joints) return *elements * *joints;
    }
    refuse_shape(node, key);
  }

  static std::optional<double> factor(const toml::node* node, std::size_t size, std::size_t index) {
    if (!node) return std::nullopt;
    if (const auto value = as_number(*node)) return value;
    const toml::array* array = node->as_array();
    return array && array->size() == size ? as_number(*array->get(index)) : std::nullopt;
  }

  [[noreturn]] void refuse_shape(const toml::node& node, const FrictionKey& key) const {
    const std::size_t n = joints_.size(), m = key.members.size();
    const std::string allowed =
        key.family ? fmt::format(
                         "a number, {} arrays (joints) of {} numbers (elements), or "
                         "{{elements = [{} numbers], joints = [{} numbers]}}",
                         n, m, m, n)
                   : fmt::format("a number, or an array of {} numbers, one per joint", n);
    throw UserError("{}: {}.{} = {}; allowed: {}", place(node, where_), section_, key.key,
                    found(node), allowed);
  }

  void check(const toml::node& node, const ParameterInfo& info, std::size_t j, double value) const {
    if (value >= info.lower && value <= info.upper) return;
    throw UserError("{}: {}.{} = {}{} (joint {}); allowed: {}", place(node, where_), section_,
                    info.symbol, value, unit_suffix(info), joints_[j], bounds(info));
  }

  const toml::table& table_;
  std::string section_, where_;
  const std::vector<std::string>& joints_;
};

// A law on some joints, as one [[friction.law]] says it.
struct Entry {
  LawSpec spec;
  std::vector<int> joints;
  std::vector<std::vector<double>> values;  ///< per joint: law, then its modifiers
};

class EntryReader {
 public:
  EntryReader(const toml::table& table, std::string section, std::string where,
              const std::vector<std::string>& joint_names)
      : table_(table),
        section_(std::move(section)),
        where_(std::move(where)),
        joint_names_(joint_names) {}

  Entry read() {
    Entry entry;
    TomlReader fields(table_, section_, where_, joint_names_);
    fields("law", entry.spec.law, required(text("name of a friction law")));
    const LawInfo* row = find_row(friction::law_table(), entry.spec.law);
    if (!row)
      throw UserError("{}: {}.law = \"{}\"; allowed: {}", line_of("law"), section_, entry.spec.law,
                      fmt::join(names_of(friction::law_table()), ", "));
    entry.joints = read_joints(fields);
    std::vector<std::string> joints;
    for (const int j : entry.joints) joints.push_back(joint_names_[static_cast<std::size_t>(j)]);

    entry.spec.elements = read_count(fields, *row, "elements");
    const Owner law = make_owner(*row, entry.spec.elements, false);
    entry.values = ValueReader(table_, section_, where_, joints).read(law);
    for (const FrictionKey& key : law.keys) fields.allow(key.key);

    for (const LawInfo& modifier : friction::modifier_table()) {
      fields.allow(modifier.name);
      if (table_.contains(modifier.name)) read_modifier(modifier, joints, entry);
    }
    fields.refuse_unknown();
    return entry;
  }

 private:
  std::string line_of(std::string_view key) const { return place(*table_.get(key), where_); }

  std::vector<int> read_joints(TomlReader& fields) const {
    std::vector<std::string> names = joint_names_;
    fields("joints", names, text("joints that have it"));
    std::vector<int> joints;
    for (const std::string& name : names) {
      const auto found = std::find(joint_names_.begin(), joint_names_.end(), name);
      const int joint = static_cast<int>(found - joint_names_.begin());
      if (found == joint_names_.end())
        throw UserError("{}: {}.joints has \"{}\"; allowed: {}", line_of("joints"), section_, name,
                        fmt::join(joint_names_, ", "));
      if (std::find(joints.begin(), joints.end(), joint) != joints.end())
        throw UserError("{}: {}.joints has \"{}\" twice", line_of("joints"), section_, name);
      joints.push_back(joint);
    }
    return joints;
  }

  static int read_count(TomlReader& fields, const LawInfo& row, std::string_view key) {
    int count = row.has_elements ? 1 : 0;
    if (row.has_elements) fields(key, count, number("", 1, kMostElements, "number of elements"));
    return count;
  }

  void read_modifier(const LawInfo& row, const std::vector<std::string>& joints,
                     Entry& entry) const {
    const std::string section = fmt::format("{}.{}", section_, row.name);
    const toml::node& node = *table_.get(row.name);
    const std::string where = place(node, where_);
    if (!node.is_table())
      throw UserError("{}: {} = {}; allowed: a table of its parameters", where, section,
                      found(node));
    TomlReader fields(*node.as_table(), section, where, joint_names_);
    const int order = std::max(1, read_count(fields, row, "order"));
    const Owner modifier = make_owner(row, order, true);
    const auto values = ValueReader(*node.as_table(), section, where, joints).read(modifier);
    for (const FrictionKey& key : modifier.keys) fields.allow(key.key);
    fields.refuse_unknown();

    entry.spec.modifiers.push_back({.name = std::string(row.name), .order = order});
    for (std::size_t j = 0; j < values.size(); ++j)
      entry.values[j].insert(entry.values[j].end(), values[j].begin(), values[j].end());
  }

  const toml::table& table_;
  std::string section_, where_;
  const std::vector<std::string>& joint_names_;
};

std::string joined(std::size_t count, const std::function<std::string(std::size_t)>& item) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i ? ", " : "") + item(i);
  return "[" + text + "]";
}

// "key = value" for one owner; values[j] starts with its parameters.
void write_values(const Owner& owner, const std::vector<std::vector<double>>& values,
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

std::string write_entry(const Entry& entry, const std::vector<std::string>& joint_names) {
  const LawInfo& row = *find_row(friction::law_table(), entry.spec.law);
  std::string text = fmt::format("\n[[friction.law]]\nlaw = {}\n", toml_text(entry.spec.law));
  text += fmt::format("joints = {}\n", joined(entry.joints.size(), [&](std::size_t j) {
                        return toml_text(joint_names[static_cast<std::size_t>(entry.joints[j])]);
                      }));
  if (row.has_elements) text += fmt::format("elements = {}\n", entry.spec.elements);
  const Owner law = make_owner(row, entry.spec.elements, false);
  write_values(law, entry.values, [&](const std::string& line) { text += line + "\n"; });

  std::size_t begin = law.parameters.size();
  for (const ModifierSpec& spec : entry.spec.modifiers) {
    const LawInfo& modifier_row = *find_row(friction::modifier_table(), spec.name);
    const Owner modifier = make_owner(modifier_row, spec.order, true);
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

std::vector<FrictionKey> friction_keys(const std::vector<ParameterInfo>& now,
                                       const std::vector<ParameterInfo>& one_more) {
  // The bases of families are what one more element adds, less its number.
  std::vector<std::string> bases;
  for (const ParameterInfo& info : one_more) {
    const auto same_symbol = [&](const ParameterInfo& p) { return p.symbol == info.symbol; };
    if (std::any_of(now.begin(), now.end(), same_symbol)) continue;
    bases.emplace_back(info.symbol.substr(0, info.symbol.find_last_not_of("0123456789") + 1));
  }

  std::vector<FrictionKey> keys;
  for (std::size_t p = 0; p < now.size(); ++p) {
    const std::string symbol(now[p].symbol);
    const std::size_t end = symbol.find_last_not_of("0123456789") + 1;
    const std::string base = symbol.substr(0, end);
    const bool family =
        end < symbol.size() && std::find(bases.begin(), bases.end(), base) != bases.end();
    const std::string name = family ? base : symbol;
    const auto known = std::find_if(keys.begin(), keys.end(),
                                    [&](const FrictionKey& key) { return key.key == name; });
    if (known != keys.end()) {
      known->members.push_back(static_cast<int>(p));
    } else {
      keys.push_back({.key = name, .members = {static_cast<int>(p)}, .family = family});
    }
  }
  return keys;
}

Friction read_friction(const toml::table& table, const std::string& where,
                       const std::vector<std::string>& joint_names) {
  std::string load = "motor_torque";
  TomlReader fields(table, "friction", where, joint_names);
  fields("load", load, choice("motor_torque", "torque that load-dependent laws see"));
  fields.allow("law");
  fields.refuse_unknown();

  const toml::node* laws = table.get("law");
  const toml::array* array = laws ? laws->as_array() : nullptr;
  if (!array || array->empty() || !array->is_homogeneous(toml::node_type::table))
    throw UserError("{}: friction.law is missing; allowed: tables [[friction.law]]",
                    laws ? place(*laws, where) : where);

  std::vector<JointSpec> joints(joint_names.size());
  std::vector<std::vector<double>> theta(joint_names.size());
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::table& law = *array->get(i)->as_table();
    const Entry entry =
        EntryReader(law, fmt::format("friction.law[{}]", i + 1), place(law, where), joint_names)
            .read();
    for (std::size_t j = 0; j < entry.joints.size(); ++j) {
      const auto joint = static_cast<std::size_t>(entry.joints[j]);
      joints[joint].laws.push_back(entry.spec);
      theta[joint].insert(theta[joint].end(), entry.values[j].begin(), entry.values[j].end());
    }
  }

  Friction result{.model = friction::RobotFriction(std::move(joints)), .theta = {}};
  for (const auto& values : theta)
    result.theta.insert(result.theta.end(), values.begin(), values.end());
  return result;
}

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
    std::vector<Entry> entries;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].laws.size() <= i) continue;
      const LawSpec& spec = joints[j].laws[i];
      auto entry = std::find_if(entries.begin(), entries.end(),
                                [&](const Entry& e) { return same(e.spec, spec); });
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
    for (const Entry& entry : entries) text += write_entry(entry, joint_names);
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
  const auto describe = [&](const Owner& owner, std::string_view prefix, bool one_line) {
    std::string line;
    for (const FrictionKey& key : owner.keys) {
      const ParameterInfo& info = owner.parameters[static_cast<std::size_t>(key.members[0])];
      text += fmt::format("{}# {}: {}, {}{}\n", one_line ? "# " : "", key.key, info.meaning,
                          bounds(info), key.family ? ", one per element" : "");
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
    const Owner law = make_owner(row, row.has_elements ? kElements : 0, false);
    text += fmt::format("\n# {}\n# Source: {}\n{}[[friction.law]]\n{}law = \"{}\"\n", row.equation,
                        row.source, prefix, prefix, row.name);
    if (row.has_elements) text += fmt::format("{}elements = {}\n", prefix, kElements);
    describe(law, prefix, false);
  }
  text += "\n# Modifiers, as further keys of a law:\n";
  for (const LawInfo& row : friction::modifier_table()) {
    text += fmt::format("# {}\n# Source: {}\n", row.equation, row.source);
    const Owner modifier = make_owner(row, 1, true);
    const std::string line = describe(modifier, "", true);
    text += fmt::format("# {} = {{{}{}}}\n", row.name, row.has_elements ? "order = 1, " : "", line);
  }
  return text;
}

}  // namespace fricid::data
