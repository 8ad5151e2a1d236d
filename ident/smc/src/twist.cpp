#include "fricid/smc/twist.hpp"

#include <cmath>

#include "fricid/base/eigen_instances.hpp"
#include "fricid/smc/guides.hpp"

namespace fricid::smc {
namespace {

double log_det_of_factor(const Eigen::MatrixXd& L) { return 2 * L.diagonal().array().log().sum(); }

/// Information in y_t about the deviation of x_t from s_t: adds to Lambda, lambda and kappa.
void add_observation(std::span<const double> y, const Eigen::MatrixXd& C, const Eigen::MatrixXd& R,
                     const Eigen::VectorXd& s, Eigen::MatrixXd& Lambda, Eigen::VectorXd& lambda,
                     double& kappa) {
  std::vector<Eigen::Index> present;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (!std::isnan(y[i])) present.push_back(static_cast<Eigen::Index>(i));
  }
  if (present.empty()) return;
  Eigen::MatrixXd whitened = C(present, Eigen::all);
  Eigen::VectorXd r(static_cast<Eigen::Index>(present.size()));
  for (Eigen::Index k = 0; k < r.size(); ++k) {
    const Eigen::Index i = present[static_cast<std::size_t>(k)];
    r(k) = y[static_cast<std::size_t>(i)] - C.row(i).dot(s);
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(Eigen::MatrixXd(R(present, present)));
  llt.matrixL().solveInPlace(whitened);
  llt.matrixL().solveInPlace(r);
  Lambda.noalias() += whitened.transpose() * whitened;
  lambda.noalias() += whitened.transpose() * r;
  kappa -= 0.5 * (r.squaredNorm() + log_det_of_factor(llt.matrixL()) +
                  static_cast<double>(r.size()) * 1.8378770664093453);  // log 2 pi
}

}  // namespace

TwistStep::TwistStep(const Eigen::MatrixXd& Q)
    : J(Q),
      G(Q),
      factor(Q),
      h(Q.rows()),
      shift(Q.rows()),
      Q_(Q),
      L_(Q.llt().matrixL()),
      inverse_L_(Eigen::MatrixXd::Identity(Q.rows(), Q.rows())),
      M_(Q),
      W_(Q),
      product_(Q),
      llt_(Q) {
  L_.triangularView<Eigen::Lower>().solveInPlace(inverse_L_);
}

void TwistStep::compute(const Eigen::MatrixXd& Lambda, const Eigen::VectorXd& lambda) {
  // M = I + L' Lambda L, well conditioned whatever the units of the states
  product_.noalias() = Lambda * L_;
  M_.setIdentity();
  M_.noalias() += L_.transpose() * product_;
  llt_.compute(M_);
  const double log_det = 2 * llt_.matrixLLT().diagonal().array().log().sum();

  // Sigma = W W' with W = L M^-1/2, J = L M^-1 L^-1
  W_ = L_;
  llt_.matrixU().solveInPlace<Eigen::OnTheRight>(W_);
  product_ = inverse_L_;
  llt_.matrixL().solveInPlace(product_);
  J.noalias() = W_ * product_;
  product_.noalias() = W_ * W_.transpose();
  shift.noalias() = product_ * lambda;
  llt_.compute(product_);
  factor = llt_.matrixL();

  // G = J' Lambda as a sum of two positive terms, symmetric whatever the rounding
  product_.noalias() = Lambda * J;
  G.noalias() = J.transpose() * product_;
  M_.noalias() = Q_ * product_;
  G.noalias() += product_.transpose() * M_;
  for (Eigen::Index j = 0; j < G.cols(); ++j) {
    for (Eigen::Index i = 0; i < j; ++i) G(i, j) = G(j, i) = 0.5 * (G(i, j) + G(j, i));
  }
  h.noalias() = J.transpose() * lambda;
  log_constant = 0.5 * (lambda.dot(shift) - log_det);
}

TwistRecursion::TwistRecursion(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& C,
                               const Eigen::MatrixXd& R, const RowMatrix& y, Foresight foresight,
                               Twist& twist)
    : C_(C), R_(R), y_(y), twist_(twist), step_(Q), G_c_(Q.rows()), G_A_(Q) {
  const std::size_t T = twist.s.size();
  twist.foresight = foresight;
  twist.Lambda.assign(T, Eigen::MatrixXd::Zero(Q.rows(), Q.rows()));
  twist.lambda.assign(T, Eigen::VectorXd::Zero(Q.rows()));
  twist.kappa.assign(T, 0);
  observe(static_cast<int>(T) - 1);
}

void TwistRecursion::observe(int t) {
  const auto k = static_cast<std::size_t>(t);
  Eigen::MatrixXd& Lambda = twist_.Lambda[k];
  add_observation(row_of(y_, t), C_, R_, twist_.s[k], Lambda, twist_.lambda[k], twist_.kappa[k]);
  Lambda = (0.5 * (Lambda + Lambda.transpose())).eval();
}

void TwistRecursion::add(int t) {
  const auto k = static_cast<std::size_t>(t);
  if (twist_.foresight == Foresight::kOne) return observe(t);
  step_.compute(twist_.Lambda[k + 1], twist_.lambda[k + 1]);
  const Eigen::VectorXd& c = twist_.c[k];
  const Eigen::MatrixXd& A = twist_.A[k];
  G_c_.noalias() = step_.G * c;
  G_A_.noalias() = step_.G * A;
  twist_.Lambda[k].noalias() = A.transpose() * G_A_;
  twist_.lambda[k].noalias() = A.transpose() * (step_.h - G_c_);
  twist_.kappa[k] = twist_.kappa[k + 1] + step_.log_constant + step_.h.dot(c) - 0.5 * c.dot(G_c_);
  if (!twist_.bend.empty()) {
    twist_.Lambda[k] += twist_.bend[k].H;
    twist_.lambda[k] += twist_.bend[k].g;
    twist_.kappa[k] += twist_.bend[k].c;
  }
  observe(t);
}

void twist_backward(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& C, const Eigen::MatrixXd& R,
                    const RowMatrix& y, Foresight foresight, Twist& twist) {
  twist.bend.clear();
  twist.kink.clear();
  TwistRecursion recursion(Q, C, R, y, foresight, twist);
  for (int t = twist.steps() - 2; t >= 0; --t) recursion.add(t);
}

TwistedStart twisted_start(const Gaussian& initial, const Twist& twist) {
  const auto n = initial.mean.size();
  const Eigen::MatrixXd L = square_root(initial.covariance);
  const Eigen::MatrixXd& Lambda = twist.Lambda[0];
  const Eigen::VectorXd F = initial.mean - twist.s[0], r = twist.lambda[0] - Lambda * F;
  const Eigen::LLT<Eigen::MatrixXd> llt(
      Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n) + L.transpose() * Lambda * L));
  TwistedStart start;
  start.factor = L;
  llt.matrixU().solveInPlace<Eigen::OnTheRight>(start.factor);
  const Eigen::VectorXd white = start.factor.transpose() * r;
  start.mean = initial.mean + start.factor * white;
  start.log_normaliser = twist.kappa[0] - 0.5 * log_det_of_factor(llt.matrixL()) -
                         0.5 * F.dot(Lambda * F) + twist.lambda[0].dot(F) +
                         0.5 * white.squaredNorm();
  return start;
}

void twisted_moments(const Gaussian& initial, const Eigen::MatrixXd& Q, const Twist& twist,
                     std::span<Gaussian> moments) {
  const TwistedStart start = twisted_start(initial, twist);
  moments[0].mean = start.mean;
  moments[0].covariance = start.factor * start.factor.transpose();
  TwistStep step(Q);
  for (std::size_t t = 0; t + 1 < moments.size(); ++t) {
    step.compute(twist.Lambda[t + 1], twist.lambda[t + 1]);
    const Eigen::VectorXd F = twist.c[t] + twist.A[t] * (moments[t].mean - twist.s[t]);
    const Eigen::MatrixXd JA = step.J * twist.A[t];
    moments[t + 1].mean = twist.s[t + 1] + step.J * F + step.shift;
    moments[t + 1].covariance = JA * moments[t].covariance * JA.transpose();
    moments[t + 1].covariance.noalias() += step.factor * step.factor.transpose();
  }
}

}  // namespace fricid::smc
