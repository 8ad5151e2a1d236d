// The row of units that some logs have below their header, against the contract.
#pragma once

#include <string>

#include "fricid/data/contract.hpp"
#include "fricid/data/log_reader.hpp"

namespace fricid::data {

/// Words that name no unit of the quantity, and factors that the contract states, are left alone.
/// @throws UserError "file:line: ..." at the first unit that the contract contradicts, with the key
/// to state
void check_units(const LogTable& table, const Contract& contract, const std::string& file);

}  // namespace fricid::data
