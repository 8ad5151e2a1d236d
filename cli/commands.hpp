// One function per command of the program. Results go to stdout, progress and log to stderr.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "fricid/cli/command_line.hpp"
#include "fricid/workflow/check.hpp"

namespace fricid::cli {

struct CommonOptions {
  int jobs = 0;
  bool quiet = false, json = false, fresh = false;
};

struct RunOptions {
  std::filesystem::path target;     ///< scene file or run folder
  std::filesystem::path output;     ///< empty: run/NAME
  std::vector<std::string> models;  ///< empty: all of the scene
  std::string seeds;                ///< empty: those of the scene
  std::optional<std::uint64_t>
      seed;  ///< replaces that of the scene and its data; empty: the scene's
  std::vector<std::filesystem::path> data;  ///< further data sets to evaluate on; may be empty
  bool no_video = false;
};

struct RenderOptions {
  std::filesystem::path target;   ///< run folder
  std::vector<std::string> what;  ///< of plots, video, report, still; empty: all except still
  std::string quality, layout;    ///< empty: those of the scene
  std::string renderer;           ///< empty: FRICID_GL or what is found
  std::filesystem::path still = "still.png";
  std::optional<double> at;  ///< time of the still [s]
};

struct ImportOptions {
  std::vector<std::filesystem::path> logs;
  std::filesystem::path contract, output = ".";
  workflow::RobotOfLog robot;      ///< for checks by dynamics
  std::vector<std::string> fixes;  ///< findings to repair
};

struct CheckOptions {
  std::filesystem::path target;    ///< run folder, data set (HDF5) or log
  std::filesystem::path contract;  ///< of a log; empty: none
  workflow::RobotOfLog robot;      ///< of a log
  std::filesystem::path design;    ///< file of a trajectory to record next; empty: none
  bool verbose = false;            ///< print every parameter, family and note
};

struct PayloadOptions {
  std::filesystem::path without;   ///< run folder, data set (HDF5) or log
  std::filesystem::path with;      ///< data set (HDF5) or log
  std::filesystem::path contract;  ///< of both logs; empty: none
  workflow::RobotOfLog robot;      ///< of the logs, without the load
  std::string frame;               ///< that carries the load; empty: flange or tool0
  std::filesystem::path output;    ///< JSON; empty: none
};

struct EstimateOptions {
  std::filesystem::path model, log, output = "estimate.h5";
  int particles = 200;
  std::uint64_t seed = 1;
};

struct ContactOptions {
  std::filesystem::path model, log, output = "contact.h5";
  double bandwidth_hz = 10;  ///< of the observer
  int particles = 0;         ///< that filter the states of friction; 0: they follow the motion
  std::uint64_t seed = 1;
};

struct ExportOptions {
  std::filesystem::path target;  ///< model file, or run folder: all its models
  std::string format;
  std::filesystem::path output;  ///< folder
  std::filesystem::path mjcf;    ///< to be extended by the plugin; empty: the robot of the model
};

struct CompareOptions {
  std::vector<std::filesystem::path> folders;  ///< of runs
  std::string against;           ///< model whose errors the others are divided by; empty: none
  std::filesystem::path output;  ///< of the table; empty: stdout
};

struct InfoOptions {
  std::filesystem::path file;
  bool csv = false;  ///< write its signals as CSV
};

/// Verdict of a command that finished. kNo: a fit failed its own checks, or a horizon of the
/// evaluation cannot rank models; for logs without truth the latter is not checked.
enum class Verdict { kDone, kNo };

Verdict run(const RunOptions& options, const CommonOptions& common);
Verdict simulate(const RunOptions& options, const CommonOptions& common);
Verdict identify(const RunOptions& options, const CommonOptions& common);
Verdict evaluate(const RunOptions& options, const CommonOptions& common);
Verdict render(const RenderOptions& options, const CommonOptions& common);
Verdict import_logs(const ImportOptions& options, const CommonOptions& common);
Verdict check(const CheckOptions& options, const CommonOptions& common);
Verdict find_payload(const PayloadOptions& options, const CommonOptions& common);
Verdict compare(const CompareOptions& options, const CommonOptions& common);
Verdict estimate_log(const EstimateOptions& options, const CommonOptions& common);
Verdict find_contact(const ContactOptions& options, const CommonOptions& common);
Verdict export_models(const ExportOptions& options, const CommonOptions& common);
Verdict info(const InfoOptions& options, const CommonOptions& common);
Verdict print_template(const std::string& topic);
void print_version();

}  // namespace fricid::cli
