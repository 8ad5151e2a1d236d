// KUKA RobotSensorInterface: the XML packets of a controller, one after the other in a file.
//
//     <Rob Type="KUKA">...<AIPos A1="74.8" .../><MACur A1="0.11" .../><IPOC>680309708</IPOC></Rob>
//
// Columns are TAG.ATTRIBUTE and, for a tag with text, TAG: AIPos.A1, MACur.A1, IPOC, Delay.D. IPOC
// [ms] is the controller's clock. Answers (<Sen>), time stamps of a logger and anything else
// between packets are skipped, a packet that the file ends in too.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fricid/data/log_reader.hpp"

namespace fricid::data {

/// Names in the first packet. @throws UserError when there is none
std::vector<std::string> rsi_names(std::string_view text, const std::string& file);

/// @throws UserError "file:line: ..." for a missing column, a value that is no number
LogTable parse_rsi(std::string_view text, const std::string& file,
                   const std::vector<std::string>& wanted);

}  // namespace fricid::data
