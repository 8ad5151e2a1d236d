#include "fricid/smc/twist.hpp"

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
  const Eigen::LLT<Eigen::MatrixXd> llt(R(present, present));
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

void twist_backward(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& C, const Eigen::MatrixXd& R,
                    const RowMatrix& y, Foresight foresight, Twist& twist) {
  const std::size_t T = twist.s.size();
  const auto n = Q.rows();
  twist.foresight = foresight;
  twist.Lambda.resize(T);
  twist.lambda.resize(T);
  twist.kappa.resize(T);
  TwistStep step(Q);
  Eigen::VectorXd G_c(n);
  Eigen::MatrixXd G_A(n, n);
  for (std::size_t t = T; t-- > 0;) {
    Eigen::MatrixXd& Lambda = twist.Lambda[t].setZero(n, n);
    Eigen::VectorXd& lambda = twist.lambda[t].setZero(n);
    double& kappa = twist.kappa[t] = 0;
    if (foresight == Foresight::kWhole && t + 1 < T) {
      step.compute(twist.Lambda[t + 1], twist.lambda[t + 1]);
      const Eigen::VectorXd& c = twist.c[t];
      const Eigen::MatrixXd& A = twist.A[t];
      G_c.noalias() = step.G * c;
      G_A.noalias() = step.G * A;
      Lambda.noalias() = A.transpose() * G_A;
      lambda.noalias() = A.transpose() * (step.h - G_c);
      kappa = twist.kappa[t + 1] + step.log_constant + step.h.dot(c) - 0.5 * c.dot(G_c);
    }
    add_observation(row_of(y, static_cast<int>(t)), C, R, twist.s[t], Lambda, lambda, kappa);
    Lambda = (0.5 * (Lambda + Lambda.transpose())).eval();
  }
}

TwistedStart twisted_start(const Gaussian& initial, const Twist& twist) {
  const auto n = initial.mean.size();
  const Eigen::MatrixXd L = square_root(initial.covariance);
  const Eigen::MatrixXd& Lambda = twist.Lambda[0];
  const Eigen::VectorXd F = initial.mean - twist.s[0], r = twist.lambda[0] - Lambda * F;
  const Eigen::LLT<Eigen::MatrixXd> llt(Eigen::MatrixXd::Identity(n, n) +
                                        L.transpose() * Lambda * L);
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

}  // namespace fricid::smc
