#include "fricid/friction/tangent.hpp"

#include <algorithm>
#include <array>
#include <concepts>

#include "fricid/friction/detail/kernels.hpp"

namespace fricid::friction {
namespace {

constexpr std::size_t kMostParameters = 8;  // of a law of one state that does not say how

template <class Law>
concept TangentLaw = requires(const Law law, const double* theta, const Input<double>& in,
                              double* T) {
  { law.tangent_size() } -> std::same_as<int>;
  law.template step_tangent<double>(theta, in, 0.0, theta, T);
  law.template add_tangent<double>(theta, theta, T, T);
};

/// Laws whose sensitivities follow from the pullback where they have at most one state.
template <class Law>
constexpr bool kByPullback = !TangentLaw<Law> && !LearnedLaw<Law>;

/// Numbers that a law carries forward; < 0: it cannot.
template <class Law>
int size_of(const Law& law) {
  if constexpr (TangentLaw<Law>) {
    return law.tangent_size();
  } else {
    if (!kByPullback<Law> || law.state_size() > 1) return -1;
    return law.state_size() * static_cast<int>(law.parameters().size());
  }
}

/// How z' follows z and v, state by state.
template <class S>
struct StateSlopes {
  std::array<S, kMaxElements> by_z, by_v;
};

/// T of a law of one state, whose step maps the adjoint 1 to the rows of its Jacobians.
template <class S>
StateSlopes<S> step_one_state(const auto& law, const S* theta, const Input<S>& in, double dt,
                              const S* z, S* T) {
  const std::size_t size = law.parameters().size();
  std::array<S, kMostParameters> theta_bar;
  std::fill_n(theta_bar.begin(), size, S(0));
  Input<S> in_bar{S(0), S(0), S(0), S(0)};
  S z_bar = S(0);
  const S one = S(1);
  law.step_pullback(theta, in, dt, z, &one, theta_bar.data(), in_bar, &z_bar);
  for (std::size_t p = 0; p < size; ++p) T[p] = z_bar * T[p] + theta_bar[p];
  StateSlopes<S> slopes;
  slopes.by_z[0] = z_bar;
  slopes.by_v[0] = in_bar.v;
  return slopes;
}

/// T after a step from z.
template <class S>
void step_tangent(const auto& law, const S* theta, const Input<S>& in, double dt, const S* z,
                  S* T) {
  using Law = std::remove_cvref_t<decltype(law)>;
  if constexpr (TangentLaw<Law>) law.step_tangent(theta, in, dt, z, T);
  if constexpr (kByPullback<Law>)
    if (law.state_size() == 1) step_one_state(law, theta, in, dt, z, T);
}

/// theta_bar += (dz/dtheta)' z_bar.
template <class S>
void add_tangent(const auto& law, const S* theta, const S* z_bar, const S* T, S* theta_bar) {
  if constexpr (TangentLaw<std::remove_cvref_t<decltype(law)>>)
    law.add_tangent(theta, z_bar, T, theta_bar);
  else
    for (int p = 0; p < size_of(law); ++p) theta_bar[p] += z_bar[0] * T[p];
}

template <class Law>
concept GapLaw = TangentLaw<Law> &&
    requires(const Law law, const double* theta, const Input<double>& in, double* x) {
  law.template step_slopes<double>(theta, in, 0.0, theta, x, x);
};

/// Sensitivities of a law behind backlash. The velocity that the law sees follows the parameters,
/// so dz/dtheta is that at held velocity, in the form of the law, and a matrix D beside it that the
/// velocity moves:
///
///     dv_law, dg' = plan(dg, dtau_0, dtau_1),    D' = dz'/dz D + dz'/dv dv_law
///
/// by the parameters of the law, then b.
template <class Law>
class GapTangent {
 public:
  explicit GapTangent(const Law& law)
      : law_(law),
        states_(static_cast<std::size_t>(law.state_size())),
        columns_(law.parameters().size() + 1) {}

  /// Numbers carried forward; < 0: not known.
  static int size_of_law(const Law& law) {
    const int own = size_of(law);
    if (own < 0 || (law.state_size() > 1 && !GapLaw<Law>)) return -1;
    return own + (law.state_size() + 1) * (static_cast<int>(law.parameters().size()) + 1);
  }

  template <class S>
  void step(const S* theta, const S* gap, const Input<S>& in, double dt, S* z, S& g, S* T) const {
    if (dt == 0) return;
    const auto plan = Backlash::make_plan(law_, theta, gap, in, dt, z, g);
    std::array<S, kMostColumns> stored{}, trial{};
    if (any(plan.crosses)) {
      rest_torque(theta, in, z, T, stored);
      std::vector<S> T_trial(T, T + size_of_law(law_));
      std::array<S, kMaxElements> z_trial{};
      std::copy_n(z, states_, z_trial.begin());
      const StateSlopes<S> slopes = step_own(theta, in, dt, z_trial.data(), T_trial.data());
      const std::array<S, kMostColumns> same_velocity{};
      move(slopes, same_velocity, T_trial.data());
      rest_torque(theta, in, z_trial.data(), T_trial.data(), trial);
    }
    S* G = T + size_of(law_) + states_ * columns_;
    std::array<S, kMostColumns> v_law{};
    for (std::size_t p = 0; p < columns_; ++p) {
      const S b = S(p + 1 == columns_ ? 1 : 0);
      const auto change = Backlash::change(plan, in.v, dt, b, G[p], stored[p], trial[p]);
      v_law[p] = change.v_law;
      G[p] = change.g_next;
    }
    Input<S> seen = in;
    seen.v = plan.v_law;
    move(step_own(theta, seen, dt, z, T), v_law, T);
    g = plan.g_next;
  }

  /// theta_bar (of the law), b_bar += (dz/dtheta)' z_bar.
  template <class S>
  void add(const S* theta, const S* z_bar, const S* T, S* theta_bar, S& b_bar) const {
    add_tangent(law_, theta, z_bar, T, theta_bar);
    const S* D = T + size_of(law_);
    for (std::size_t i = 0; i < states_; ++i, D += columns_) {
      for (std::size_t p = 0; p + 1 < columns_; ++p) theta_bar[p] += z_bar[i] * D[p];
      b_bar += z_bar[i] * D[columns_ - 1];
    }
  }

 private:
  static constexpr std::size_t kMostColumns = 2 * kMaxElements + 8;

  /// z and the law's own T after a step, and how the states follow each other.
  template <class S>
  StateSlopes<S> step_own(const S* theta, const Input<S>& in, double dt, S* z, S* T) const {
    StateSlopes<S> slopes;
    if constexpr (GapLaw<Law>) {
      law_.step_slopes(theta, in, dt, z, slopes.by_z.data(), slopes.by_v.data());
      law_.step_tangent(theta, in, dt, z, T);
    } else if constexpr (kByPullback<Law>) {
      if (law_.state_size() == 1) slopes = step_one_state(law_, theta, in, dt, z, T);
    }
    law_.step(theta, in, dt, z);
    return slopes;
  }

  template <class S>
  void move(const StateSlopes<S>& slopes, const std::array<S, kMostColumns>& v_law, S* T) const {
    S* D = T + size_of(law_);
    for (std::size_t i = 0; i < states_; ++i, D += columns_)
      for (std::size_t p = 0; p < columns_; ++p)
        D[p] = slopes.by_z[i] * D[p] + slopes.by_v[i] * v_law[p];
  }

  /// d(torque at v = 0)/dtheta in state z.
  template <class S>
  void rest_torque(const S* theta, const Input<S>& in, const S* z, const S* T,
                   std::array<S, kMostColumns>& by_theta) const {
    Input<S> in_bar{S(0), S(0), S(0), S(0)};
    std::array<S, kMaxElements> z_bar{};
    law_.torque_pullback(theta, Backlash::at_rest(in), z, S(1), by_theta.data(), in_bar,
                         z_bar.data());
    add(theta, z_bar.data(), T, by_theta.data(), by_theta[columns_ - 1]);
  }

  const Law& law_;
  std::size_t states_, columns_;
};

int size_of(const RobotFriction& model) {
  if (model.has_whole()) return -1;
  int size = 0;
  for (const auto& slot : Kernels<PackD>::slots(model))
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      const int own = slot.backlash.kind < 0
                          ? size_of(law)
                          : GapTangent<std::remove_cvref_t<decltype(law)>>::size_of_law(law);
      size = size < 0 || own < 0 ? -1 : size + own;
    });
  return size;
}

}  // namespace

bool Tangent::is_known(const RobotFriction& model) { return size_of(model) >= 0; }

Tangent::Tangent(const RobotFriction& model)
    : model_(model), T_(static_cast<std::size_t>(size_of(model)), PackD(0)) {}

void Tangent::reset() { std::fill(T_.begin(), T_.end(), PackD(0)); }

void Tangent::step(std::span<const PackD> theta, std::span<const Input<PackD>> in, double dt,
                   std::span<PackD> z) {
  PackD* T = T_.data();
  for (const auto& slot : Kernels<PackD>::slots(model_)) {
    const Input<PackD>& at = in[static_cast<std::size_t>(slot.joint)];
    const PackD* own = theta.data() + slot.theta;
    PackD* own_z = z.data() + slot.z;
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      using Law = std::remove_cvref_t<decltype(law)>;
      if (slot.backlash.kind < 0) {
        step_tangent(law, own, at, dt, own_z, T);
        law.step(own, at, dt, own_z);
        T += size_of(law);
      } else {
        GapTangent<Law>(law).step(own, theta.data() + slot.backlash.theta, at, dt, own_z,
                                  z[static_cast<std::size_t>(slot.backlash.z)], T);
        T += GapTangent<Law>::size_of_law(law);
      }
    });
  }
}

void Tangent::add(std::span<const PackD> theta, std::span<const PackD> z_bar,
                  std::span<PackD> theta_bar) const {
  const PackD* T = T_.data();
  for (const auto& slot : Kernels<PackD>::slots(model_))
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      using Law = std::remove_cvref_t<decltype(law)>;
      const PackD* own = theta.data() + slot.theta;
      const PackD* own_bar = z_bar.data() + slot.z;
      PackD* by_own = theta_bar.data() + slot.theta;
      if (slot.backlash.kind < 0) {
        add_tangent(law, own, own_bar, T, by_own);
        T += size_of(law);
      } else {
        GapTangent<Law>(law).add(own, own_bar, T, by_own,
                                 theta_bar[static_cast<std::size_t>(slot.backlash.theta)]);
        T += GapTangent<Law>::size_of_law(law);
      }
    });
}

}  // namespace fricid::friction
