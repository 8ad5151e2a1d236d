// Signals as matrices: one row per sample, one column per joint.
#pragma once

#include <Eigen/Core>

namespace fricid {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ConstRowMatrix = Eigen::Ref<const RowMatrix>;

}  // namespace fricid
