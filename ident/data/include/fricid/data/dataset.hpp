// Data sets as files, and the rules that they keep.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "fricid/data/hdf5.hpp"
#include "fricid/signals/dataset.hpp"

namespace fricid::data {

using signals::Dataset;

/// HDF5, format "fricid.dataset/1": /t /q /tau [/v] [/temperature] with attribute `unit`; root
/// attributes format, joint_names, rate_hz, source. The file is written atomically.
void save_dataset(const Dataset& dataset, const std::filesystem::path& path);
/// @throws UserError naming the file when it is missing, a folder, torn, of another format or a
/// newer version,
///         or when the data break a rule of `check_dataset`
Dataset load_dataset(const std::filesystem::path& path);

/// @throws UserError naming `where` and a joint that is named twice
void refuse_twins(const std::vector<std::string>& joints, const std::string& where);

/// Rules of every data set: every joint once, at least two samples, equal lengths, finite rising t
/// without a gap or jitter above 1 % of the period, values finite or NaN (missing), at least one
/// value per joint. Warns about |q| > 4 pi (degrees?) and positions logged in steps above 0.1 mrad.
/// @throws UserError naming `where`, the sample and what was found
/// @return warnings, one line each
std::vector<std::string> check_dataset(const Dataset& dataset, const std::string& where);

/// A log whose torque is measured at its samples as one whose torque is held between them: tau_k
/// becomes the mean over [t_k, t_{k+1}) of cubic curves through the measured values (of straight
/// lines beside a gap and at the ends). The last row goes; `source` says it.
Dataset held_between_samples(Dataset log);

/// [samples] by which a torque that is measured at its samples lags behind one held from them.
inline constexpr double kMeasuredLater = 0.5;
/// Standard deviation of the time of a torque [s], taken as held, that is measured at its samples
/// with a probability.
inline double delay_sd_if_measured(double probability, double dt) {
  return kMeasuredLater * dt * std::sqrt(probability);
}

}  // namespace fricid::data
