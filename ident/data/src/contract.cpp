#include "fricid/data/contract.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "check_times.hpp"
#include "csv.hpp"
#include "fricid/base/error.hpp"
#include "toml_file.hpp"
#include "toml_reader.hpp"
#include "toml_writer.hpp"

namespace fricid::data {
namespace {

using Names = std::vector<std::string>;

// "q{}" -> q1 ... qn
void expand_pattern(Names& columns, int n) {
  if (columns.size() != 1 || columns[0].find("{}") == std::string::npos) return;
  const std::string pattern = columns[0];
  const std::size_t hole = pattern.find("{}");
  columns.clear();
  for (int j = 1; j <= n; ++j)
    columns.push_back(pattern.substr(0, hole) + std::to_string(j) + pattern.substr(hole + 2));
}

void fill(std::vector<double>& values, int n, double value) {
  if (values.empty()) values.assign(static_cast<std::size_t>(n), value);
}

bool at_motor(const std::string& unit) { return unit.starts_with("motor_"); }
double radians(const std::string& unit) {
  return unit.ends_with("deg") ? std::numbers::pi / 180 : 1.0;
}

char separator_of(const std::string& name) {
  return name == "comma"       ? ','
         : name == "semicolon" ? ';'
         : name == "tab"       ? '\t'
         : name == "space"     ? ' '
                               : '\0';
}

// Rules across the keys of a contract.
class ContractCheck {
 public:
  ContractCheck(const TomlFile& file, const Contract& contract)
      : file_(file), contract_(contract), n_(static_cast<std::size_t>(contract.n())) {}

  void run() const {
    count("position.columns", contract_.position.columns, false);
    count("torque.columns", contract_.torque.columns, false);
    count("velocity.columns", contract_.velocity.columns, true);
    count("temperature.columns", contract_.temperature.columns, true);
    signs("position.sign", contract_.position.sign);
    signs("velocity.sign", contract_.velocity.sign);
    signs("torque.sign", contract_.torque.sign);
    needs(at_motor(contract_.position.unit), "gear_ratio", contract_.gear_ratio, "position.unit",
          contract_.position.unit);
    needs(at_motor(contract_.velocity.unit), "gear_ratio", contract_.gear_ratio, "velocity.unit",
          contract_.velocity.unit);
    needs(contract_.torque.kind != "joint_torque", "gear_ratio", contract_.gear_ratio,
          "torque.kind", contract_.torque.kind);
    needs(contract_.torque.kind == "current", "torque.torque_constant",
          contract_.torque.torque_constant, "torque.kind", contract_.torque.kind);
    if (contract_.decimal_comma && contract_.separator == "comma")
      throw UserError("{}: separator = \"comma\"; allowed: another one with decimal_comma",
                      line_of("separator"));
  }

 private:
  std::string line_of(std::string_view key) const { return place_of_key(file_, key); }
  void count(std::string_view key, const Names& columns, bool optional) const {
    if (columns.size() == n_ || (optional && columns.empty())) return;
    throw UserError("{}: {} names {} columns; allowed: {}, one per joint, or one pattern with {{}}",
                    line_of(key), key, columns.size(), n_);
  }
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

// Rate of the samples, exactly whole where it is within a part in a million.
double rate_of(const Eigen::VectorXd& t) {
  std::vector<double> periods;
  for (int k = 1; k < t.size(); ++k) periods.push_back(t[k] - t[k - 1]);
  std::nth_element(periods.begin(),
                   periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2),
                   periods.end());
  double rate = 1 / periods[periods.size() / 2];
  // The whole length knows the period better than one rounded difference, unless there are gaps.
  const double mean = static_cast<double>(t.size() - 1) / (t[t.size() - 1] - t[0]);
  if (std::abs(mean - rate) < 1e-3 * rate) rate = mean;
  const double whole = std::round(rate);
  return std::abs(rate - whole) < 1e-6 * whole ? whole : rate;
}

Dataset read(const std::filesystem::path& path, const Contract& contract, std::vector<int>& lines) {
  const int n = contract.n();
  Names wanted{contract.time.column};
  const Names* groups[] = {&contract.position.columns, &contract.torque.columns,
                           &contract.velocity.columns, &contract.temperature.columns};
  for (const Names* columns : groups) wanted.insert(wanted.end(), columns->begin(), columns->end());
  const CsvTable table =
      read_csv(path, wanted, separator_of(contract.separator), contract.decimal_comma);
  const int length = static_cast<int>(table.lines.size());
  const std::string file = path.string();
  if (length < 2) throw UserError("{}: {} rows of numbers; allowed: at least 2", file, length);

  Dataset d;
  d.name = path.stem().string();
  d.joint_names = contract.joint_names;
  d.source = "import " + path.filename().string();
  const double second = contract.time.unit == "s" ? 1 : contract.time.unit == "ms" ? 1e3 : 1e6;
  d.t = Eigen::Map<const Eigen::VectorXd>(table.columns[0].data(), length);
  d.t = ((d.t.array() - d.t[0]) / second).eval();
  const auto place_of = [&](int k) {
    return fmt::format("{}:{}", file, table.lines[static_cast<std::size_t>(k)]);
  };
  d.rate_hz = rate_of(d.t);
  for (int k = 0; k < length; ++k)
    if (!std::isfinite(d.t[k]))
      throw UserError("{}: t = {}; allowed: a finite time", place_of(k), d.t[k]);

  // Column group -> (T, n) with value = factor_j raw + offset_j.
  std::size_t next = 1;
  const auto take = [&](const auto& factor, const auto& offset) {
    RowMatrix values(length, n);
    for (int j = 0; j < n; ++j) {
      const auto joint = static_cast<std::size_t>(j);
      const std::vector<double>& column = table.columns[next++];
      for (int k = 0; k < length; ++k) {
        const double raw = column[static_cast<std::size_t>(k)];
        if (std::isinf(raw))
          throw UserError("{}: {} = {}; allowed: finite, or nan where missing", place_of(k),
                          wanted[next - 1], raw);
        values(k, j) = factor(joint) * raw + offset(joint);
      }
    }
    return values;
  };
  const auto zero = [](std::size_t) { return 0.0; };
  const auto motion_factor = [&](const MotionColumns& motion) {
    return [&contract, &motion](std::size_t j) {
      const double gear = at_motor(motion.unit) ? contract.gear_ratio[j] : 1.0;
      return motion.sign[j] * radians(motion.unit) / gear;
    };
  };
  d.q = take(motion_factor(contract.position),
             [&](std::size_t j) { return contract.position.offset_rad[j]; });
  d.tau = take(
      [&](std::size_t j) {
        const TorqueColumns& torque = contract.torque;
        const double gear = torque.kind == "joint_torque" ? 1.0 : contract.gear_ratio[j];
        const double constant = torque.kind == "current" ? torque.torque_constant[j] : 1.0;
        return torque.sign[j] * constant * gear;
      },
      zero);
  if (!contract.velocity.columns.empty()) d.v = take(motion_factor(contract.velocity), zero);
  if (!contract.temperature.columns.empty())
    d.temperature =
        take([](std::size_t) { return 1.0; },
             [&](std::size_t) { return contract.temperature.unit == "C" ? 273.15 : 0.0; });
  lines = table.lines;
  return d;
}

}  // namespace

Contract load_contract(const std::filesystem::path& path) {
  const TomlFile file = load_toml(path);
  Contract contract;
  const std::vector<std::string> none;
  TomlReader names(file.table, "", file.path, none);
  names("joint_names", contract.joint_names, required(text("joints of the robot")));
  const Names joints = contract.joint_names;
  TomlReader reader(file.table, "", file.path, joints);
  contract.visit(reader);
  reader.refuse_unknown();
  for (Names* columns : {&contract.position.columns, &contract.torque.columns,
                         &contract.velocity.columns, &contract.temperature.columns})
    expand_pattern(*columns, contract.n());
  ContractCheck(file, contract).run();
  for (MotionColumns* motion : {&contract.position, &contract.velocity}) {
    fill(motion->sign, contract.n(), 1);
    fill(motion->offset_rad, contract.n(), 0);
  }
  fill(contract.torque.sign, contract.n(), 1);
  fill(contract.torque.torque_constant, contract.n(), 1);
  fill(contract.gear_ratio, contract.n(), 1);
  return contract;
}

std::string contract_template() {
  Contract example;
  example.joint_names = {"joint_a1", "joint_a2", "joint_a3", "joint_a4", "joint_a5", "joint_a6"};
  example.position.columns = {"q{}"};
  example.torque.columns = {"tau{}"};
  TomlWriter writer(true, {});
  example.visit(writer);
  return "# A column contract of fricid: what each column of a log means. Headers are matched as\n"
         "# written, else without regard to letter case. Unknown keys are errors.\n\n" +
         writer.text();
}

Dataset read_log(const std::filesystem::path& path, const Contract& contract) {
  std::vector<int> lines;
  return read(path, contract, lines);
}

Dataset import_csv(const std::filesystem::path& path, const Contract& contract) {
  std::vector<int> lines;
  Dataset d = read(path, contract, lines);
  check_times(d.t, d.rate_hz, [&](int k) {
    return fmt::format("{}:{}", path.string(), lines[static_cast<std::size_t>(k)]);
  });
  check_dataset(d, path.string());
  return d;
}

}  // namespace fricid::data
