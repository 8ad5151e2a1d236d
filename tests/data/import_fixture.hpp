// A log of two joints, and its contract.
#pragma once

#include <string>

#include "fricid/data/contract.hpp"
#include "scene_folder.hpp"

namespace fricid::data {

inline constexpr char kContract[] = R"(joint_names = ["shoulder", "elbow"]
[position]
columns = "q{}"
[torque]
columns = "tau{}"
)";

inline constexpr char kLog[] =
    "t,q1,q2,tau1,tau2,note\n"
    "5.000,0.1,0.2,1,2,0\n"
    "5.004,0.11,0.21,1.5,2.5,0\n"
    "5.008,0.12,0.22,-1e1,+3,0\n"
    "5.012,0.13,0.23,1,4,0\n";

inline constexpr char kOrMissing[] = "; nan, null, none or nothing where it is missing";

class Import : public FolderTest {
 protected:
  Contract contract(const std::string& text = kContract) const {
    return load_contract(write("contract.toml", text));
  }
  Dataset import(const std::string& log, const std::string& text = kContract) const {
    return import_log(write("log.csv", log), contract(text));
  }
  std::string log_error(const std::string& log, const std::string& text = kContract) const {
    return message_of([&] { import(log, text); });
  }
  std::string contract_error(const std::string& text) const {
    return message_of([&] { contract(text); });
  }
};

}  // namespace fricid::data
