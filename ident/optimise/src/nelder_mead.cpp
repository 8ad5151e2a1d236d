#include "fricid/optimise/nelder_mead.hpp"

#include <limits>
#include <memory>
#include <utility>

#include <nlopt.h>

#include "fricid/base/progress.hpp"

namespace fricid::optimise {
namespace {

struct Search {
  const Objective& objective;
  nlopt_opt optimiser;
  Eigen::VectorXd c;
  int values = 0;
};

double value_at(unsigned size, const double* x, double*, void* user) {
  Search& search = *static_cast<Search*>(user);
  ++search.values;
  if (stop_requested()) nlopt_force_stop(search.optimiser);
  search.c = Eigen::VectorXd::Map(x, size);
  return search.objective(search.c);
}

}  // namespace

Minimum nelder_mead(const Objective& objective, const Box& box, Eigen::VectorXd c,
                    const SimplexOptions& options) {
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> optimiser(
      nlopt_create(NLOPT_LN_NELDERMEAD, static_cast<unsigned>(c.size())), &nlopt_destroy);
  Search search{objective, optimiser.get(), c};
  nlopt_set_lower_bounds(optimiser.get(), box.lower.data());
  nlopt_set_upper_bounds(optimiser.get(), box.upper.data());
  nlopt_set_min_objective(optimiser.get(), &value_at, &search);
  nlopt_set_initial_step1(optimiser.get(), options.first_step);
  nlopt_set_xtol_abs1(optimiser.get(), options.tolerance);
  nlopt_set_ftol_rel(optimiser.get(), options.tolerance);
  nlopt_set_maxeval(optimiser.get(), options.evaluations);
  double value = std::numeric_limits<double>::max();
  const nlopt_result result = nlopt_optimize(optimiser.get(), c.data(), &value);
  throw_if_stopped();
  const bool converged = result == NLOPT_XTOL_REACHED || result == NLOPT_FTOL_REACHED ||
                         result == NLOPT_SUCCESS || result == NLOPT_ROUNDOFF_LIMITED;
  return {std::move(c), value, converged, search.values};
}

}  // namespace fricid::optimise
