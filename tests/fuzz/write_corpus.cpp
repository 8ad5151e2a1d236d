// Writes the samples of all formats as starting inputs of log_fuzz into the folder argv[1].
#include <fmt/format.h>

#include <fstream>
#include <string>

#include "log_samples.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = argv[1];
  const auto write = [&](const std::string& name, char format, const std::string& content) {
    std::ofstream(folder + "/" + name, std::ios::binary) << format << content;
  };
  int count = 0;
  for (const fricid::data::LogSample& sample : fricid::data::log_samples(4)) {
    const bool german = sample.format == "german_csv";
    const char format = sample.format == "rsi_xml"      ? 2
                        : sample.format == "kuka_trace" ? 3
                        : sample.format == "mcap"       ? 4
                                                        : static_cast<char>(german ? 1 : 0);
    std::string content = sample.files[0].second;
    if (format == 3) content += sample.files[1].second;
    write(fmt::format("{}_{}", sample.format, count++), format, content);
  }
}
