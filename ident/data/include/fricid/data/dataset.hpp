#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "fricid/data/hdf5.hpp"

namespace fricid::data {

/// What a real log has, and nothing more: T samples of n joints. Row k holds time t_k; tau_k is
/// held over [t_k, t_{k+1}). Missing values are NaN.
struct Dataset {
  std::string name;                      ///< file stem, e.g. "train_0"
  std::vector<std::string> joint_names;  ///< (n)
  double rate_hz = 0;                    ///< nominal sample rate
  std::string source;                    ///< "simulation kr6_full seed 1", "import trajA_train.csv"
  Eigen::VectorXd t;                     ///< (T) [s], uniform
  RowMatrix q;                           ///< (T, n) [rad]
  RowMatrix tau;                         ///< (T, n) motor torque at the joint [N m]
  RowMatrix v;                           ///< (T, n) [rad/s] or empty
  RowMatrix temperature;                 ///< (T, n) [K] or empty

  int length() const { return static_cast<int>(t.size()); }
  int n() const { return static_cast<int>(q.cols()); }
  double dt() const { return 1.0 / rate_hz; }
};

/// HDF5, format "fricid.dataset/1": /t /q /tau [/v] [/temperature] with attribute `unit`; root
/// attributes format, joint_names, rate_hz, source. The file is written atomically.
void save_dataset(const Dataset& dataset, const std::filesystem::path& path);
/// @throws UserError naming the file when it is missing, a folder, torn, of another format or a
/// newer version,
///         or when the data break a rule of `check_dataset`
Dataset load_dataset(const std::filesystem::path& path);

/// Rules of every data set: at least two samples, equal lengths, finite rising t without a gap or
/// jitter above 1 % of the period, values finite or NaN (missing), at least one value per joint.
/// Warns about |q| > 4 pi (degrees?) and positions logged in steps above 0.1 mrad.
/// @throws UserError naming `where`, the sample and what was found
/// @return warnings, one line each
std::vector<std::string> check_dataset(const Dataset& dataset, const std::string& where);

}  // namespace fricid::data
