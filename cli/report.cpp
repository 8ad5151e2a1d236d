// The stage that writes report.html.
#include "fricid/render/report.hpp"

#include <algorithm>
#include <cstdio>

#include "fricid/base/files.hpp"
#include "stages.hpp"

namespace fricid::cli {
namespace {

namespace fs = std::filesystem;

/// Names and hashes of the files in a folder.
std::string contents_of(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::exists(folder))
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::string text;
  for (const fs::path& file : files)
    text += file.filename().string() + " " + sha256_of_file(file) + "\n";
  return text;
}

}  // namespace

void make_report(Job& job) {
  const fs::path& folder = job.folder.path();
  std::string key = read_file(folder / "evaluation.json") + read_file(folder / "scene.toml");
  for (const char* pictures : {"fit", "plots", "video"}) key += contents_of(folder / pictures);
  const bool ran = job.folder.stage("report", key, [&] {
    render::write_report(folder);
    return std::vector<std::string>{"report.html"};
  });
  if (!ran) std::fputs("report: up to date\n", stderr);
}

}  // namespace fricid::cli
