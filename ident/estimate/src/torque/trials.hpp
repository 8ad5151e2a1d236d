// The candidates for one model, and which of them is taken.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fricid/base/progress.hpp"
#include "fricid/estimate/fit.hpp"
#include "fricid/estimate/torque/joint_fit.hpp"

namespace fricid::estimate {

/// A candidate and how it was fitted, so that the same can be done with all rows.
struct Trial {
  Candidate candidate;
  const char* conventional = nullptr;  ///< law of the method conventional, else fitted jointly
  std::optional<std::size_t> refined;  ///< by windows: the trial that they start from
};

/// Whether the model is the sum whose parts the data choose.
bool is_sum(const ModelOptions& config);

/// Fits of one model to the training rows. The held-out rows, which none of them has seen, tell
/// them apart; the one that is taken is fitted once more, to all rows.
class Trials {
 public:
  Trials(const Prepared& prepared, const JointFits& fits, const ModelOptions& config, int seed);

  /// The given friction in every joint.
  void add_law(const friction::JointSpec& spec);
  /// The sum, with networks too where its laws leave something; conventional laws, fitted like it
  /// and, where that comes near, by the method conventional; and of each joint the best of these.
  /// @param evidence  for each part of the sum
  void add_sum(std::vector<PartEvidence>& evidence);
  /// Of those that come near the best, refined on windows.
  void add_windows();

  /// What held-out data choose (`choose`), marked as taken.
  const Trial& take();
  /// The same fit to all rows.
  Arm on_all_rows(const Trial& trial) const;
  std::vector<Candidate> candidates() const;

 private:
  void add(Trial trial);
  std::vector<friction::LvmParts> fit_sum(std::vector<PartEvidence>& evidence, Arm& bank);
  void add_networks(const Arm& bank, const std::vector<friction::LvmParts>& parts,
                    std::vector<PartEvidence>& evidence);
  void add_best_of_each_joint();
  std::optional<Arm> conventional(const Prepared& prepared, const char* law) const;
  double near() const;

  const Prepared& prepared_;
  const JointFits& fits_;
  int seed_;
  std::string label_;
  Progress progress_;
  std::vector<Trial> trials_;
};

}  // namespace fricid::estimate
