#include "units.hpp"

#include <algorithm>
#include <optional>
#include <span>

#include "fricid/base/error.hpp"
#include "logs/columns.hpp"
#include "logs/unit_words.hpp"

namespace fricid::data {
namespace {

/// The units of one table of the contract.
struct Group {
  std::string_view table;
  std::optional<UnitWord> (*named)(std::string_view cell);
  std::string_view unit;            ///< that the contract states; empty: none
  std::span<const double> scale{};  ///< of every column; empty: 1
};

}  // namespace

void check_units(const LogTable& table, const Contract& contract, const std::string& file) {
  if (table.units.empty()) return;
  std::size_t next = 0;
  const auto check = [&](const Group& group, const std::vector<std::string>& columns) {
    for (std::size_t j = 0; j < columns.size(); ++j) {
      const std::string& cell = table.units[next++];
      const std::optional<UnitWord> read = group.named(cell);
      if (!read) continue;
      const std::string_view stated =
          group.unit.starts_with("motor_") ? group.unit.substr(6) : group.unit;
      const bool scaled = j < group.scale.size() && group.scale[j] != 1;
      std::string remedy;
      if (!stated.empty() && stated != read->unit && !scaled)
        remedy = fmt::format("unit = \"{}{}\"",
                             group.unit.substr(0, group.unit.size() - stated.size()), read->unit);
      else if (read->scale != 1 && !scaled)
        remedy = fmt::format("scale = {}", read->scale);
      if (!remedy.empty())
        throw UserError(
            "{}:{}: the row of units has {} for {}; the contract says otherwise: {} in [{}]; "
            "where the row is wrong, leave it out",
            file, table.units_line, in_quotes(cell), columns[j], remedy, group.table);
    }
  };
  check({"time", time_unit, contract.time.unit}, {contract.time.column});
  check({"position", motion_unit, contract.position.unit, contract.position.scale},
        contract.position.columns);
  const TorqueColumns& torque = contract.torque;
  const bool in_percent =
      std::ranges::any_of(torque.percent_of, [](double percent) { return percent != 100; });
  const bool is_torque = torque.kind != "current" && !in_percent;
  const auto none = [](std::string_view) -> std::optional<UnitWord> { return {}; };
  check({"torque", is_torque ? torque_unit : none, "", torque.scale}, torque.columns);
  check({"velocity", motion_unit, contract.velocity.unit, contract.velocity.scale},
        contract.velocity.columns);
  check({"temperature", temperature_unit, contract.temperature.unit}, contract.temperature.columns);
}

}  // namespace fricid::data
