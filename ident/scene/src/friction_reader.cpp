#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "fricid/base/error.hpp"
#include "fricid/config/toml_file.hpp"
#include "fricid/config/toml_reader.hpp"
#include "fricid/data/friction_keys.hpp"
#include "friction_toml.hpp"

namespace fricid::scene {
namespace {

using config::as_number;
using config::found;
using config::place;
using config::TomlReader;
using data::find_row;
using data::FrictionKey;
using data::FrictionOwner;
using data::law_owner;
using data::list_bounds;
using data::list_names;
using data::modifier_owner;
using data::unit_suffix;
using friction::Friction;
using friction::JointSpec;
using friction::LawInfo;
using friction::LawSpec;
using friction::ParameterInfo;

// Reads the values of one table for the joints it applies to: values[j][p].
class ValueReader {
 public:
  ValueReader(const toml::table& table, std::string section, std::string where,
              const std::vector<std::string>& joints)
      : table_(table), section_(std::move(section)), where_(std::move(where)), joints_(joints) {}

  std::vector<std::vector<double>> read(const FrictionOwner& owner) const {
    std::vector<std::vector<double>> values(joints_.size(),
                                            std::vector<double>(owner.parameters.size()));
    for (const FrictionKey& key : owner.keys) {
      const ParameterInfo& first = owner.parameters[static_cast<std::size_t>(key.members[0])];
      const toml::node* node = table_.get(key.key);
      if (!node)
        throw UserError("{}: {}.{} is missing; {} needs it: {}, allowed: {}", where_, section_,
                        key.key, owner.name, first.meaning, list_bounds(first));
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
                    info.symbol, value, unit_suffix(info), joints_[j], list_bounds(info));
  }

  const toml::table& table_;
  std::string section_, where_;
  const std::vector<std::string>& joints_;
};

class EntryReader {
 public:
  EntryReader(const toml::table& table, std::string section, std::string where,
              const std::vector<std::string>& joint_names)
      : table_(table),
        section_(std::move(section)),
        where_(std::move(where)),
        joint_names_(joint_names) {}

  LawEntry read() {
    LawEntry entry;
    TomlReader fields(table_, section_, where_, joint_names_);
    fields("law", entry.spec.law, required(text("name of a friction law")));
    const LawInfo* row = find_row(friction::law_table(), entry.spec.law);
    if (!row)
      throw UserError("{}: {}.law = \"{}\"; allowed: {}", line_of("law"), section_, entry.spec.law,
                      list_names(friction::law_table()));
    entry.joints = read_joints(fields);
    std::vector<std::string> joints;
    for (const int j : entry.joints) joints.push_back(joint_names_[static_cast<std::size_t>(j)]);

    entry.spec.elements = read_count(fields, *row, "elements");
    const FrictionOwner law = law_owner(*row, entry.spec.elements);
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
    if (row.has_elements)
      fields(key, count, number("", 1, row.most_elements, "number of elements"));
    return count;
  }

  void read_modifier(const LawInfo& row, const std::vector<std::string>& joints,
                     LawEntry& entry) const {
    const std::string section = fmt::format("{}.{}", section_, row.name);
    const toml::node& node = *table_.get(row.name);
    const std::string where = place(node, where_);
    if (!node.is_table())
      throw UserError("{}: {} = {}; allowed: a table of its parameters", where, section,
                      found(node));
    TomlReader fields(*node.as_table(), section, where, joint_names_);
    const int order = std::max(1, read_count(fields, row, "order"));
    const FrictionOwner modifier = modifier_owner(row, order);
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

}  // namespace

Friction read_friction(const toml::table& table, const std::string& where,
                       const std::vector<std::string>& joint_names) {
  std::string load = "motor_torque";
  TomlReader fields(table, "friction", where, joint_names);
  fields("load", load, choice("motor_torque", "load of load-dependent laws"));
  fields.allow("law");
  fields.refuse_unknown();

  const toml::node* laws = table.get("law");
  if (!laws) return {};  // sizes from the effort limits: see friction_by_effort
  const toml::array* array = laws ? laws->as_array() : nullptr;
  if (!array || array->empty() || !array->is_homogeneous(toml::node_type::table))
    throw UserError("{}: friction.law = {}; allowed: tables [[friction.law]]", place(*laws, where),
                    found(*laws));

  std::vector<JointSpec> joints(joint_names.size());
  std::vector<std::vector<double>> theta(joint_names.size());
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::table& law = *array->get(i)->as_table();
    const LawEntry entry =
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

}  // namespace fricid::scene
