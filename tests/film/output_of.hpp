#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace fricid::film {

/// What a shell command prints.
inline std::string output_of(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 256> part{};
  while (std::fgets(part.data(), part.size(), pipe)) text += part.data();
  pclose(pipe);
  return text;
}

}  // namespace fricid::film
