// Options in, exit codes out.
#include <fcntl.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/deploy/export.hpp"
#include "fricid/film/options.hpp"
#include "fricid/scene/robot.hpp"
#include "seeds.hpp"

namespace fricid::cli {
namespace {

enum ExitCode {
  kDone = 0,
  kVerdictNo = 1,
  kUserMistake = 2,
  kNumericalFailure = 3,
  kStopped = 130
};

/// How the robot of a log stands, and how its file is read.
void add_robot_of_log(CLI::App& command, workflow::RobotOfLog& robot) {
  command.add_flag("--mend-inertia", robot.mend_inertia,
                   "take the nearest inertia that a body can have where that of a link is none");
  command
      .add_option("--mount", robot.mount,
                  "of the robot: floor, ceiling, wall, or roll,pitch,yaw in rad; default floor")
      ->check([](const std::string& words) -> std::string {
        try {
          scene::mount_rotation(words);
          return {};
        } catch (const UserError& error) {
          return error.what();
        }
      });
}

/// The text as one printable line.
void print_error(std::string_view message) {
  std::fflush(stdout);
  std::fprintf(stderr, "fricid: %s\n", printable(message).c_str());
}

/// Digits only: CLI11 would read -1 as 2^64 - 1 and 07 as an octal number.
std::string whole_number_up_to(const Limit& limit, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value <= limit.most &&
      (text == "0" || text.front() != '0'))
    return {};
  return fmt::format("\"{}\"; allowed: a whole number from 0 to {}", text, limit.most);
}

/// No option and no argument is an empty text: an empty path would be the folder the program runs
/// in.
void refuse_empty_texts(CLI::App& app) {
  const CLI::Validator not_empty(
      [](std::string& text) { return text.empty() ? "is empty" : std::string(); }, "");
  for (CLI::App* command : app.get_subcommands({}))
    for (CLI::Option* option : command->get_options())
      if (option->get_items_expected_max() > 0) option->check(not_empty);
}

/// Opens closed standard streams on a file that can neither be read nor written, so that no file
/// opened later takes their descriptor. A closed pipe on stdout and the limit on file sizes become
/// write errors instead of killing the program.
void keep_standard_streams() {
  for (const int stream : {0, 1, 2})
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", stream == 0 ? O_WRONLY : O_RDONLY);
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
}

/// Flushes stdout. Returns `code`, or that of a failure to write.
int exit_code_once_printed(int code) {
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  print_error("stdout: cannot be written: it is full or closed");
  return kNumericalFailure;
}

int exit_code_of(Verdict verdict) { return verdict == Verdict::kDone ? kDone : kVerdictNo; }

std::string is_seed(const std::string& text) { return whole_number_up_to(limits::kSeed, text); }

/// What a command line asks for.
struct Call {
  CommonOptions common;
  std::function<Verdict()> command;

  /// Completes a command: the options that every command takes, and what it does.
  void finish(CLI::App& app, const std::string& example,
              std::function<Verdict(const CommonOptions&)> does) {
    app.add_option("--jobs", common.jobs, "threads; 0: all cores")->check(CLI::Range(0, 4096));
    app.add_flag("--quiet", common.quiet, "no progress on stderr");
    app.add_flag("--json", common.json, "result on stdout as JSON");
    app.add_flag("--fresh", common.fresh, "repeat all stages, up to date or not");
    app.footer("Example:\n  " + example);
    app.callback(
        [this, does = std::move(does)] { command = [this, does] { return does(common); }; });
  }
};

void add_run(CLI::App& app, Call& call) {
  const auto options = std::make_shared<RunOptions>();
  CLI::App* command =
      app.add_subcommand("run", "run everything: data, identification, evaluation, plots, report");
  command->add_option("SCENE", options->target, "scene file (TOML)")->required();
  command->add_option("-o,--output", options->output, "run folder; default run/NAME");
  command->add_option("--seed", options->seed, "seed of the data; default: scene")->check(is_seed);
  command->add_flag("--no-video", options->no_video, "make no videos");
  call.finish(*command, "fricid run scenes/kr6_demo.toml -o run/kr6_demo",
              [options](const CommonOptions& common) { return run(*options, common); });
}

void add_simulate(CLI::App& app, Call& call) {
  const auto options = std::make_shared<RunOptions>();
  CLI::App* command =
      app.add_subcommand("simulate", "ground truth only: data sets and truth files");
  command->add_option("SCENE", options->target, "scene file (TOML)")->required();
  command->add_option("-o,--output", options->output, "run folder; default run/NAME");
  command->add_option("--seed", options->seed, "seed of the data; default: scene")->check(is_seed);
  call.finish(*command, "fricid simulate scenes/kr6_lugre.toml",
              [options](const CommonOptions& common) { return simulate(*options, common); });
}

void add_identify(CLI::App& app, Call& call) {
  const auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("identify", "fit models to the training data");
  command->add_option("SCENE|DIR", options->target, "scene file or run folder")->required();
  command->add_option("-o,--output", options->output, "run folder; default run/NAME");
  command->add_option("--model", options->models, "only these models (repeatable)")
      ->allow_extra_args(false);
  command->add_option("--seeds", options->seeds, "of the fits, e.g. 1-5 or 1,3")
      ->each([](const std::string& text) { parse_seeds(text); });
  call.finish(*command, "fricid identify run/kr6_demo --model lugre --seeds 1-5",
              [options](const CommonOptions& common) { return identify(*options, common); });
}

void add_evaluate(CLI::App& app, Call& call) {
  const auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand(
      "evaluate", "open loops against held-out data, models in DIR/external included");
  command->add_option("DIR", options->target, "run folder")->required();
  command->add_option("--data", options->data, "further data sets (HDF5) to evaluate on");
  call.finish(*command, "fricid evaluate run/kr6_demo --data other/validation_0.h5",
              [options](const CommonOptions& common) { return evaluate(*options, common); });
}

void add_render(CLI::App& app, Call& call) {
  const auto options = std::make_shared<RenderOptions>();
  CLI::App* command =
      app.add_subcommand("render", "draw the plots, videos, report or a still of a run folder");
  command->add_option("DIR", options->target, "run folder")->required();
  command->add_option("WHAT", options->what, "plots, video, report, still; default: not still")
      ->check(CLI::IsMember({"plots", "video", "report", "still"}));
  command->add_option("--quality", options->quality, "of the video; default: scene")
      ->check(CLI::IsMember(all_names<film::Quality>()));
  command->add_option("--layout", options->layout, "of the video; default: scene")
      ->check(CLI::IsMember(all_names<film::Layout>()));
  command->add_option("--renderer", options->renderer, "default: the first that works")
      ->check(CLI::IsMember({"egl", "osmesa"}));
  command->add_option("-o,--output", options->still, "file of the still; default still.png");
  command->add_option("--at", options->at, "time of the still [s]; default: middle");
  call.finish(*command, "fricid render run/kr6_demo video --quality final",
              [options](const CommonOptions& common) { return render(*options, common); });
}

void add_compare(CLI::App& app, Call& call) {
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* command = app.add_subcommand(
      "compare", "join the evaluations of many runs, with intervals over the runs");
  command->add_option("DIR", options->folders, "run folders")->required();
  command->add_option("--against", options->against,
                      "model whose errors the others are divided by");
  command->add_option("-o,--output", options->output, "file for the table; default stdout");
  call.finish(*command, "fricid compare run/kr6_gms_1 run/kr6_gms_2",
              [options](const CommonOptions& common) { return compare(*options, common); });
}

void add_view(CLI::App& app, Call& call, const std::function<void(const ViewOptions&)>& view) {
  const auto options = std::make_shared<ViewOptions>();
  CLI::App* command =
      app.add_subcommand("view", "replay a run, or move the live arm with adjustable friction");
  command->add_option("DIR|SCENE|MODEL", options->target, "what to show")->required();
  command->add_option("--screenshot", options->screenshot,
                      "write this PNG and exit; needs no display");
  command->add_option("--at", options->at, "time of the screenshot [s]");
  command->add_option("--script", options->script,
                      "run the commands of this file, then exit (docs/rendering.md)");
  command->add_option("--renderer", options->renderer, "of the screenshot")
      ->check(CLI::IsMember({"egl", "osmesa"}));
  call.finish(*command, "fricid view run/kr6_demo", [options, view](const CommonOptions&) {
    if (!view) throw UserError("this build has no viewer; docs/rendering.md says how to get it");
    view(*options);
    return Verdict::kDone;
  });
}

void add_import(CLI::App& app, Call& call) {
  const auto options = std::make_shared<ImportOptions>();
  CLI::App* command =
      app.add_subcommand("import", "convert real logs to data sets (docs/your_own_log.md)");
  command->add_option("LOG", options->logs, "log files")->required();
  command->add_option("--contract", options->contract, "meaning of the columns (TOML)")->required();
  command->add_option("-o,--output", options->output, "folder for the data sets; default .");
  command->add_option("--robot", options->robot.urdf,
                      "URDF: joints are then checked against its dynamics too");
  add_robot_of_log(*command, options->robot);
  command
      ->add_option("--fix", options->fixes,
                   "findings to repair, by name: gap,delay,... (docs/your_own_log.md)")
      ->delimiter(',')
      ->allow_extra_args(false);
  call.finish(*command, "fricid import log.csv --contract contract.toml -o data",
              [options](const CommonOptions& common) { return import_logs(*options, common); });
}

void add_check(CLI::App& app, Call& call) {
  const auto options = std::make_shared<CheckOptions>();
  CLI::App* command =
      app.add_subcommand("check", "check data: faults, and which parameters they identify");
  command
      ->add_option("DIR|LOG", options->target,
                   "run folder, data set (HDF5), or log; \"LOG[FROM:TO]\", in seconds, for a part")
      ->required();
  command->add_option("--contract", options->contract, "of a log (TOML)");
  command->add_option("--robot", options->robot.urdf, "URDF of the robot of a log");
  add_robot_of_log(*command, options->robot);
  command->add_option("--design", options->design,
                      "write a trajectory (TOML, and CSV beside it) to identify more parameters");
  command->add_flag("--verbose", options->verbose,
                    "every parameter, joint and note, beside the verdict");
  call.finish(*command, "fricid check log.csv --contract contract.toml",
              [options](const CommonOptions& common) { return check(*options, common); });
}

void add_payload(CLI::App& app, Call& call) {
  const auto options = std::make_shared<PayloadOptions>();
  CLI::App* command = app.add_subcommand(
      "payload",
      "identify a load: its mass, centre of mass and inertia, from logs without and with it");
  command
      ->add_option("WITHOUT", options->without,
                   "run folder, data set (HDF5), or log without the load; \"LOG[FROM:TO]\", in "
                   "seconds, for a part")
      ->required();
  command
      ->add_option("WITH", options->with, "data set (HDF5), or log with the load, or a part of it")
      ->required();
  command->add_option("--contract", options->contract, "of both logs (TOML)");
  command->add_option("--robot", options->robot.urdf, "URDF of the robot without the load");
  add_robot_of_log(*command, options->robot);
  command->add_option("--frame", options->frame, "that carries the load; default flange or tool0");
  command->add_option("-o,--output", options->output, "JSON file; default none");
  call.finish(*command,
              "fricid payload without.csv with.csv --contract contract.toml --robot arm.urdf",
              [options](const CommonOptions& common) { return find_payload(*options, common); });
}

void add_estimate(CLI::App& app, Call& call) {
  const auto options = std::make_shared<EstimateOptions>();
  CLI::App* command = app.add_subcommand(
      "estimate", "estimate states and friction along a log with the online filter");
  command->add_option("MODEL", options->model, "identified model (JSON)")->required();
  command->add_option("LOG", options->log, "data set (HDF5)")->required();
  command->add_option("-o,--output", options->output, "HDF5 file; default estimate.h5");
  command->add_option("--particles", options->particles, "of the filter")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--seed", options->seed, "of the filter")->check(is_seed);
  call.finish(*command,
              "fricid estimate run/kr6_demo/models/lugre_s1.json "
              "run/kr6_demo/data/validation_0.h5 -o estimate.h5",
              [options](const CommonOptions& common) { return estimate_log(*options, common); });
}

void add_contact(CLI::App& app, Call& call) {
  const auto options = std::make_shared<ContactOptions>();
  CLI::App* command = app.add_subcommand(
      "contact", "find the external torque along a log with a momentum observer");
  command->add_option("MODEL", options->model, "identified model (JSON)")->required();
  command->add_option("LOG", options->log, "data set (HDF5)")->required();
  command->add_option("-o,--output", options->output, "HDF5 file; default contact.h5");
  command->add_option("--bandwidth", options->bandwidth_hz, "of the observer [Hz]; default 10")
      ->check(CLI::Range(0.1, 1000.0));
  command
      ->add_option("--particles", options->particles,
                   "that filter the states of friction; default 0: they follow the motion")
      ->check(CLI::Range(0, 1'000'000));
  command->add_option("--seed", options->seed, "of the particles")->check(is_seed);
  call.finish(*command,
              "fricid contact run/kr6_demo/models/lvm_s1.json "
              "run/kr6_demo/data/validation_0.h5 -o contact.h5",
              [options](const CommonOptions& common) { return find_contact(*options, common); });
}

void add_export(CLI::App& app, Call& call) {
  const auto options = std::make_shared<ExportOptions>();
  CLI::App* command =
      app.add_subcommand("export", "models for simulators and controllers (docs/use_it.md)");
  command->add_option("RUN|MODEL", options->target, "run folder or model (JSON)")->required();
  command->add_option("FORMAT", options->format, deploy::format_list())->required();
  command->add_option("-o,--output", options->output, "folder for the files")->required();
  command->add_option("--mjcf", options->mjcf,
                      "plugin: MJCF that includes the extension, to be checked");
  call.finish(*command, "fricid export run/kr6_demo/models/lugre_s1.json c -o controller",
              [options](const CommonOptions& common) { return export_models(*options, common); });
}

void add_info(CLI::App& app, Call& call) {
  const auto options = std::make_shared<InfoOptions>();
  CLI::App* command = app.add_subcommand("info", "show the content of any fricid file");
  command->add_option("FILE", options->file, "data set, truth, rollout, model or scene")
      ->required();
  command->add_flag("--csv", options->csv, "write its signals as CSV");
  call.finish(*command, "fricid info run/kr6_demo/data/train_0.h5",
              [options](const CommonOptions& common) { return info(*options, common); });
}

void add_template(CLI::App& app, Call& call) {
  const auto topic = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("template", "print a commented file with every key");
  command->add_option("KIND", *topic, "robot, scene or contract")
      ->required()
      ->check(CLI::IsMember({"robot", "scene", "contract"}));
  call.finish(*command, "fricid template scene > my_scene.toml",
              [topic](const CommonOptions&) { return print_template(*topic); });
}

int exit_code_of_command_line(int argc, char** argv,
                              const std::function<void(const ViewOptions&)>& view) {
  CLI::App app{"fricid: ground truth, identification and pictures for friction in robot joints"};
  app.require_subcommand(0, 1);
  app.set_help_all_flag("--help-all", "help of every command");
  bool version = false;
  app.add_flag("--version", version, "versions, SIMD path, renderers found");
  Call call;
  add_run(app, call);
  add_simulate(app, call);
  add_identify(app, call);
  add_evaluate(app, call);
  add_render(app, call);
  add_compare(app, call);
  add_view(app, call, view);
  add_import(app, call);
  add_check(app, call);
  add_payload(app, call);
  add_estimate(app, call);
  add_contact(app, call);
  add_export(app, call);
  add_info(app, call);
  add_template(app, call);

  refuse_empty_texts(app);
  install_stop_handler();
  try {
    app.parse(argc, argv);
    Progress::set_quiet(call.common.quiet);
    if (version) return print_version(), kDone;
    if (!call.command) return std::fputs(app.help().c_str(), stdout), kUserMistake;
    return exit_code_of(call.command());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    print_error(error.what());
    return kUserMistake;
  } catch (const UserError& error) {
    print_error(error.what());
    return kUserMistake;
  } catch (const Stopped&) {
    std::fputs("fricid: stopped; the same command goes on from here\n", stderr);
    return kStopped;
  } catch (const std::filesystem::filesystem_error& error) {
    print_error(fmt::format("{}: {}", error.path1().string(), error.code().message()));
    return kUserMistake;
  } catch (const std::exception& error) {
    print_error(fmt::format("unexpected failure: {}", error.what()));
    return kNumericalFailure;
  }
}

}  // namespace

int run_command_line(int argc, char** argv, const std::function<void(const ViewOptions&)>& view) {
  keep_standard_streams();
  return exit_code_once_printed(exit_code_of_command_line(argc, argv, view));
}

}  // namespace fricid::cli
