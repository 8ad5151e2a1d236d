#include "fricid/data/estimate_file.hpp"

#include <array>

#include "fricid/base/error.hpp"
#include "fricid/data/hdf5.hpp"

namespace fricid::data {
namespace {

constexpr const char* kFormat = "fricid.estimate/1";

struct Table {
  const char *name, *unit;
  RowMatrix EstimateSignals::*values;
};
constexpr std::array kOfJoints{Table{"q", "rad", &EstimateSignals::q},
                               Table{"v", "rad/s", &EstimateSignals::v},
                               Table{"tau_f", "N m", &EstimateSignals::tau_f},
                               Table{"q_sd", "rad", &EstimateSignals::q_sd},
                               Table{"v_sd", "rad/s", &EstimateSignals::v_sd},
                               Table{"tau_f_sd", "N m", &EstimateSignals::tau_f_sd}};
constexpr std::array kOfStates{Table{"z", "1", &EstimateSignals::z},
                               Table{"z_sd", "1", &EstimateSignals::z_sd}};

struct Column {
  const char* name;
  Eigen::VectorXd EstimateSignals::*values;
};
constexpr std::array kColumns{Column{"log_likelihood", &EstimateSignals::log_likelihood},
                              Column{"ess", &EstimateSignals::ess}};

}  // namespace

void save_estimate(const EstimateSignals& estimate, const ModelFile& model, const Dataset& log,
                   const std::filesystem::path& path) {
  write_hdf5(path, kFormat, [&](H5Writer& file) {
    file.attribute("joint_names", log.joint_names);
    file.attribute("model", model.name);
    file.attribute("log", log.name);
    file.vector("t", estimate.t, "s");
    for (const Table& table : kOfJoints)
      file.matrix(table.name, estimate.*table.values, table.unit);
    if (estimate.z.cols() > 0)
      for (const Table& table : kOfStates)
        file.matrix(table.name, estimate.*table.values, table.unit);
    for (const Column& column : kColumns) file.vector(column.name, estimate.*column.values, "1");
  });
}

EstimateSignals load_estimate(const std::filesystem::path& path, int n) {
  const H5Reader file(path, kFormat);
  EstimateSignals estimate;
  estimate.t = file.vector("t");
  const auto require_rows = [&](const char* name, Eigen::Index rows) {
    if (rows != estimate.t.size())
      throw UserError("{}: table {} has {} rows; allowed: {}, as t", path.string(), name, rows,
                      estimate.t.size());
  };
  for (const Table& table : kOfJoints) {
    estimate.*table.values = file.matrix(table.name, n);
    require_rows(table.name, (estimate.*table.values).rows());
  }
  for (const Table& table : kOfStates) {
    if (!file.has(table.name)) continue;
    estimate.*table.values = file.matrix(table.name);
    require_rows(table.name, (estimate.*table.values).rows());
  }
  for (const Column& column : kColumns) {
    estimate.*column.values = file.vector(column.name);
    require_rows(column.name, (estimate.*column.values).size());
  }
  return estimate;
}

}  // namespace fricid::data
