#include "fricid/data/estimate_file.hpp"

#include <gmock/gmock.h>

#include "fricid/data/signal_file.hpp"
#include "scene_folder.hpp"

namespace fricid::data {
namespace {

class EstimateFile : public FolderTest {
 protected:
  static constexpr int kRows = 5;
  const std::filesystem::path file = path("e.h5");
  EstimateSignals estimate;

  EstimateFile() {
    estimate.joint_names = {"a", "b"};
    estimate.t = Eigen::VectorXd::LinSpaced(kRows, 0, 1);
    estimate.ess = Eigen::VectorXd::Random(kRows);
    estimate.log_likelihood = Eigen::VectorXd::Random(kRows);
    for (RowMatrix* values : {&estimate.q, &estimate.v, &estimate.tau_f, &estimate.q_sd,
                              &estimate.v_sd, &estimate.tau_f_sd})
      *values = RowMatrix::Random(kRows, 2);
  }
  void save() const { save_signals(estimate, file); }
  std::string said() const {
    return message_of([&] { load_signals<EstimateSignals>(file, 2); });
  }
};

TEST_F(EstimateFile, ComesBackAsItWas) {
  estimate.z = RowMatrix::Random(kRows, 3);
  estimate.z_sd = RowMatrix::Random(kRows, 3);
  save();
  const EstimateSignals read = load_signals<EstimateSignals>(file, 2);
  for (const auto values : {&EstimateSignals::q, &EstimateSignals::v, &EstimateSignals::tau_f,
                            &EstimateSignals::z, &EstimateSignals::q_sd, &EstimateSignals::v_sd,
                            &EstimateSignals::tau_f_sd, &EstimateSignals::z_sd})
    EXPECT_EQ(read.*values, estimate.*values);
  for (const auto values :
       {&EstimateSignals::t, &EstimateSignals::ess, &EstimateSignals::log_likelihood})
    EXPECT_EQ(read.*values, estimate.*values);
}

TEST_F(EstimateFile, AFrictionWithoutStatesHasNone) {
  save();
  EXPECT_EQ(load_signals<EstimateSignals>(file, 2).z.size(), 0);
}

TEST_F(EstimateFile, TablesOfOtherShapesAreRefused) {
  estimate.ess = Eigen::VectorXd::Zero(kRows - 1);
  save();
  EXPECT_EQ(said(), "e.h5: table ess has 4 rows; allowed: 5, as t");
  estimate.ess = estimate.t;
  estimate.v_sd = RowMatrix::Zero(kRows + 1, 2);
  save();
  EXPECT_EQ(said(), "e.h5: table v_sd has 6 rows; allowed: 5, as t");
  estimate.v_sd = RowMatrix::Zero(kRows, 1);
  save();
  EXPECT_EQ(said(), "e.h5: /v_sd has 1 columns; allowed: 2");
}

}  // namespace
}  // namespace fricid::data
