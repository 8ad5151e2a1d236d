#include "fricid/data/contract.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "columns_of_joints.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/names.hpp"
#include "fricid/config/toml_file.hpp"
#include "fricid/config/toml_reader.hpp"
#include "fricid/config/toml_writer.hpp"
#include "fricid/data/log_reader.hpp"
#include "logs/columns.hpp"

namespace fricid::data {
namespace {

using config::place_of_key;
using config::TomlFile;
using config::TomlReader;
using Names = std::vector<std::string>;

constexpr std::string_view kCouplings = "coupling";

void fill(std::vector<double>& values, int n, double value) {
  if (values.empty()) values.assign(static_cast<std::size_t>(n), value);
}

// A motor that turns against its joint has a sign, not a negative ratio.
void refuse_negative_ratio(const TomlFile& file) {
  constexpr std::string_view kKey = "gear_ratio";
  const auto refuse = [&](const toml::node& ratio) {
    const std::optional<double> value = ratio.value<double>();
    if (value && *value < 0)
      throw UserError(
          "{}: gear_ratio has {}; allowed: its size, and sign = -1 for this joint in each of "
          "[position], [velocity] and [torque] that is measured at the motor",
          place_of_key(file, kKey), *value);
  };
  const toml::node* ratios = file.table.get(kKey);
  if (!ratios) return;
  if (const toml::array* array = ratios->as_array())
    for (const toml::node& ratio : *array) refuse(ratio);
  else
    refuse(*ratios);
}

// Rules across the keys of a contract.
class ContractCheck {
 public:
  ContractCheck(const TomlFile& file, const Contract& contract)
      : file_(file), contract_(contract), n_(static_cast<std::size_t>(contract.n())) {}

  void run() const {
    const bool own_columns = contract_.format != "auto" && contract_.format != "csv";
    count("position.columns", contract_.position.columns, own_columns);
    count("torque.columns", contract_.torque.columns, false);
    count("velocity.columns", contract_.velocity.columns, true);
    count("temperature.columns", contract_.temperature.columns, true);
    refuse_shared_columns();
    signs("position.sign", contract_.position.sign);
    signs("velocity.sign", contract_.velocity.sign);
    signs("torque.sign", contract_.torque.sign);
    needs(at_motor(contract_.position.unit), "gear_ratio", contract_.gear_ratio, "position.unit",
          contract_.position.unit);
    needs(at_motor(contract_.velocity.unit), "gear_ratio", contract_.gear_ratio, "velocity.unit",
          contract_.velocity.unit);
    needs(counts_at_motor(contract_.torque.kind), "gear_ratio", contract_.gear_ratio, "torque.kind",
          contract_.torque.kind);
    needs(contract_.torque.kind == "current", "torque.torque_constant",
          contract_.torque.torque_constant, "torque.kind", contract_.torque.kind);
    dynamics::couplings_of(contract_.couplings, contract_.joint_names, kCouplings,
                           [&](std::string_view key) { return line_of(key); });
    if (!contract_.couplings.empty() && !at_motor(contract_.position.unit) &&
        !at_motor(contract_.velocity.unit) && !counts_at_motor(contract_.torque.kind))
      throw UserError(
          "{}: coupling without effect: position.unit = \"{}\" and torque.kind = \"{}\" are of the "
          "joints; allowed with motor_rad, motor_deg, motor_torque or current",
          line_of(kCouplings), contract_.position.unit, contract_.torque.kind);
    if (contract_.decimal_comma && contract_.separator == "comma")
      throw UserError("{}: separator = \"comma\"; allowed: another one with decimal_comma",
                      line_of("separator"));
  }

 private:
  std::string line_of(std::string_view key) const { return place_of_key(file_, key); }
  void count(std::string_view key, const Names& columns, bool optional) const {
    if (columns.size() == n_ || (optional && columns.empty())) return;
    throw UserError(
        "{}: {} names {} columns; allowed: {}, one per joint, or one pattern with {{}}{}",
        line_of(key), key, columns.size(), n_,
        key == "position.columns" && columns.empty() ? formats_with_own() : "");
  }
  static std::string formats_with_own() {
    std::vector<std::string_view> names;
    for (const LogReader& reader : log_readers())
      if (!reader.defaults.position.empty()) names.push_back(reader.name);
    return fmt::format("; or none with format = \"...\", one of {}", fmt::join(names, " "));
  }
  // A column is the position, the torque or the velocity of one joint. Temperatures may share one.
  void refuse_shared_columns() const {
    struct Use {
      std::string_view key;
      std::size_t joint;
    };
    std::map<std::string, Use> uses;
    const std::pair<std::string_view, const Names&> sections[]{
        {"position.columns", contract_.position.columns},
        {"torque.columns", contract_.torque.columns},
        {"velocity.columns", contract_.velocity.columns}};
    for (const auto& [key, columns] : sections)
      for (std::size_t j = 0; j < columns.size(); ++j) {
        const auto [first, is_new] = uses.try_emplace(columns[j], Use{key, j});
        if (is_new) continue;
        const Use& other = first->second;
        throw UserError(
            "{}: column {} is {} of joint {} and {} of joint {} ({}); allowed: a column of its own "
            "for each",
            line_of(key), in_quotes(columns[j]), signal_of(key), contract_.joint_names[j],
            signal_of(other.key), contract_.joint_names[other.joint], line_of(other.key));
      }
  }
  static std::string_view signal_of(std::string_view key) { return key.substr(0, key.find('.')); }
  void signs(std::string_view key, const std::vector<double>& values) const {
    for (const double value : values)
      if (std::abs(value) != 1)
        throw UserError("{}: {} has {}; allowed: 1 or -1", line_of(key), key, value);
  }
  void needs(bool condition, std::string_view key, const std::vector<double>& values,
             std::string_view because, const std::string& value) const {
    if (condition && values.empty())
      throw UserError("{}: {} is missing; {} = \"{}\" needs it", line_of(because), key, because,
                      value);
  }

  const TomlFile& file_;
  const Contract& contract_;
  std::size_t n_;
};

}  // namespace

std::vector<dynamics::Coupling> couplings_of(const Contract& contract) {
  return dynamics::couplings_of(contract.couplings, contract.joint_names, kCouplings,
                                [](std::string_view) { return "contract"; });
}

Contract load_contract(const std::filesystem::path& path) {
  const TomlFile file = config::load_toml(path);
  Contract contract;
  const std::vector<std::string> none;
  TomlReader names(file.table, "", file.path, none);
  names("joint_names", contract.joint_names, required(text("joints of the robot")));
  const Names joints = contract.joint_names;
  for (const std::string& joint : joints)
    require_name(Named::kJoint, joint, place_of_key(file, "joint_names"));
  refuse_twins(joints, place_of_key(file, "joint_names"));
  refuse_negative_ratio(file);
  TomlReader reader(file.table, "", file.path, joints);
  contract.visit(reader);
  reader.refuse_unknown();
  for (Names* columns : {&contract.position.columns, &contract.torque.columns,
                         &contract.velocity.columns, &contract.temperature.columns})
    *columns = expand_pattern(*columns, contract.joint_names);
  ContractCheck(file, contract).run();
  for (MotionColumns* motion : {&contract.position, &contract.velocity}) {
    fill(motion->sign, contract.n(), 1);
    fill(motion->scale, contract.n(), 1);
    fill(motion->offset_rad, contract.n(), 0);
  }
  fill(contract.torque.sign, contract.n(), 1);
  fill(contract.torque.scale, contract.n(), 1);
  fill(contract.torque.percent_of, contract.n(), 100);
  fill(contract.torque.torque_constant, contract.n(), 1);
  fill(contract.gear_ratio, contract.n(), 1);
  return contract;
}

std::string contract_template() {
  Contract example;
  example.joint_names = {"joint_a1", "joint_a2", "joint_a3", "joint_a4", "joint_a5", "joint_a6"};
  example.position.columns = {"q{}"};
  example.torque.columns = {"tau{}"};
  config::TomlWriter writer(true, {});
  example.visit(writer);
  return "# A column contract of fricid: what each column of a log means. Headers are matched as\n"
         "# written, else without regard to letter case. Unknown keys are errors.\n"
         "#\n"
         "# What torque.kind may be:\n"
         "#   joint_torque   motor torque times gear ratio: friction is in it, all can be "
         "identified.\n"
         "#                  Of coupled joints the torque about the joint; of their motors say\n"
         "#                  motor_torque, with gear_ratio 1 where it is multiplied already, and\n"
         "#                  [[coupling]]\n"
         "#   motor_torque   the same at the motor shaft [N m]; needs gear_ratio\n"
         "#   current        motor current [A]; needs torque_constant and gear_ratio. KUKA RSI "
         "MACur;\n"
         "#                  $CURR_ACT is % of the amplifier's largest current: percent_of\n"
         "#   gear_torque    the controller's estimate behind the gear from current, its friction\n"
         "#                  model still in it\n"
         "#   gear_torque_less_friction   ... taken out: what is identified is the friction that "
         "the\n"
         "#                  controller's model lacks (KUKA GearTorq)\n"
         "#   link_torque    a sensor beyond the gear (Franka tau_J): friction of the gear is not "
         "in\n"
         "#                  it and cannot be identified\n\n" +
         writer.text();
}

}  // namespace fricid::data
