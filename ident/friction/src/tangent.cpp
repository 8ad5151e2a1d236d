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

/// T of a law of one state, whose step maps the adjoint 1 to the rows of both Jacobians.
template <class S>
void step_one_state(const auto& law, const S* theta, const Input<S>& in, double dt, const S* z,
                    S* T) {
  const std::size_t size = law.parameters().size();
  std::array<S, kMostParameters> theta_bar;
  std::fill_n(theta_bar.begin(), size, S(0));
  Input<S> in_bar{S(0), S(0), S(0), S(0)};
  S z_bar = S(0);
  const S one = S(1);
  law.step_pullback(theta, in, dt, z, &one, theta_bar.data(), in_bar, &z_bar);
  for (std::size_t p = 0; p < size; ++p) T[p] = z_bar * T[p] + theta_bar[p];
}

int size_of(const RobotFriction& model) {
  if (model.has_whole()) return -1;
  int size = 0;
  for (const auto& slot : Kernels<PackD>::slots(model))
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      const int own = slot.backlash.kind < 0 ? size_of(law) : -1;
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
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      using Law = std::remove_cvref_t<decltype(law)>;
      if constexpr (TangentLaw<Law>) law.step_tangent(own, at, dt, z.data() + slot.z, T);
      if constexpr (kByPullback<Law>)
        if (law.state_size() == 1) step_one_state(law, own, at, dt, z.data() + slot.z, T);
      law.step(own, at, dt, z.data() + slot.z);
      T += size_of(law);
    });
  }
}

void Tangent::add(std::span<const PackD> theta, std::span<const PackD> z_bar,
                  std::span<PackD> theta_bar) const {
  const PackD* T = T_.data();
  for (const auto& slot : Kernels<PackD>::slots(model_))
    visit_entry<Laws>(slot.kind, slot.elements, [&](const auto law) {
      using Law = std::remove_cvref_t<decltype(law)>;
      PackD* own_bar = theta_bar.data() + slot.theta;
      if constexpr (TangentLaw<Law>)
        law.add_tangent(theta.data() + slot.theta, z_bar.data() + slot.z, T, own_bar);
      else
        for (int p = 0; p < size_of(law); ++p)
          own_bar[p] += z_bar[static_cast<std::size_t>(slot.z)] * T[p];
      T += size_of(law);
    });
}

}  // namespace fricid::friction
