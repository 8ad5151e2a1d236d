#include "fricid/sim/trace.hpp"

namespace fricid::sim {

State Trace::state(int sample) const {
  const auto row = [sample](const RowMatrix& matrix) {
    const double* begin = matrix.row(sample).data();
    return std::vector<double>(begin, begin + matrix.cols());
  };
  return {row(q), row(v), row(z)};
}

Trace make_trace(int length, double dt, int n, int state_size) {
  Trace trace;
  trace.t.resize(length);
  for (int k = 0; k < length; ++k) trace.t[k] = k * dt;
  for (RowMatrix* matrix :
       {&trace.q, &trace.v, &trace.a, &trace.tau, &trace.tau_f, &trace.temperature})
    *matrix = RowMatrix::Zero(length, n);
  trace.z = RowMatrix::Zero(length, state_size);
  return trace;
}

}  // namespace fricid::sim
