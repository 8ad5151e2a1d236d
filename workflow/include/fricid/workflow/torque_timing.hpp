// Whether logs have a torque that is held from their samples or measured at them.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "fricid/data/contract.hpp"
#include "fricid/data/dataset.hpp"
#include "fricid/dynamics/robot_model.hpp"

namespace fricid::workflow {

/// Where the contract of logs of one campaign leaves it open, takes a torque that a regression over
/// all of them finds to be measured at its samples as its mean between them, and says so. Any other
/// is taken as held, and the logs' `torque_delay_sd` is what that may be wrong by.
void settle_torque_timing(std::span<data::Dataset> logs, const dynamics::RobotModel& robot,
                          const data::TorqueColumns& torque,
                          const std::function<void(const std::string&)>& say);

}  // namespace fricid::workflow
