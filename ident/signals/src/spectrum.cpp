#include "fricid/signals/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace fricid::signals {

Spectrum welch(const Eigen::VectorXd& x, double rate_hz, int segment) {
  const int length = std::min(segment, static_cast<int>(x.size()) / 2 * 2);
  if (length < 4) return {};
  const int half = length / 2;
  std::vector<double> window(static_cast<std::size_t>(length));
  double power = 0;
  for (int i = 0; i < length; ++i) {
    const double w = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / length);
    window[static_cast<std::size_t>(i)] = w;
    power += w * w;
  }
  Eigen::FFT<double> fft;
  std::vector<double> part(window.size());
  std::vector<std::complex<double>> transform;
  Spectrum spectrum{Eigen::VectorXd(half), Eigen::VectorXd::Zero(half)};
  int segments = 0;
  for (Eigen::Index begin = 0; begin + length <= x.size(); begin += half, ++segments) {
    double sum = 0;
    for (int i = 0; i < length; ++i) {
      const double value = x[begin + i];
      part[static_cast<std::size_t>(i)] = std::isfinite(value) ? value : 0;
      sum += part[static_cast<std::size_t>(i)];
    }
    for (std::size_t i = 0; i < part.size(); ++i) part[i] = (part[i] - sum / length) * window[i];
    fft.fwd(transform, part);
    for (int k = 1; k <= half; ++k)
      spectrum.density[k - 1] +=
          (k == half ? 1 : 2) * std::norm(transform[static_cast<std::size_t>(k)]);
  }
  spectrum.density /= rate_hz * power * segments;
  for (int k = 1; k <= half; ++k) spectrum.frequency_hz[k - 1] = k * rate_hz / length;
  return spectrum;
}

Spectrum smoothed_by_octaves(const Spectrum& fine) {
  const double step = std::pow(2, 1.0 / 6);
  std::vector<double> frequency, density;
  for (Eigen::Index k = 0; k < fine.density.size();) {
    const double end = fine.frequency_hz[k] * step;
    double sum_f = 0, sum_d = 0;
    int count = 0;
    for (; k < fine.density.size() && (count == 0 || fine.frequency_hz[k] < end); ++k, ++count) {
      sum_f += fine.frequency_hz[k];
      sum_d += fine.density[k];
    }
    frequency.push_back(sum_f / count);
    density.push_back(sum_d / count);
  }
  return {Eigen::Map<Eigen::VectorXd>(frequency.data(), std::ssize(frequency)),
          Eigen::Map<Eigen::VectorXd>(density.data(), std::ssize(density))};
}

}  // namespace fricid::signals
