// Options in, exit codes out.
#include <fcntl.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <vector>

#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/limits.hpp"
#include "fricid/base/names.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/deploy/export.hpp"
#include "fricid/film/options.hpp"
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

/// Options that every command takes.
void add_common(CLI::App& command, CommonOptions& common, const std::string& example) {
  command.add_option("--jobs", common.jobs, "threads; 0: all cores")->check(CLI::Range(0, 4096));
  command.add_flag("--quiet", common.quiet, "no progress on stderr");
  command.add_flag("--json", common.json, "result on stdout as JSON");
  command.add_flag("--fresh", common.fresh, "repeat all stages, up to date or not");
  command.footer("Example:\n  " + example);
}

/// How the robot of a log stands, and how its file is read.
void add_robot_of_log(CLI::App& command, workflow::RobotOfLog& robot) {
  command.add_flag("--mend-inertia", robot.mend_inertia,
                   "take the nearest inertia that a body can have where that of a link is none");
  command
      .add_option_function<std::string>(
          "--mount",
          [&mount = robot.mount](const std::string& name) {
            mount = value_named<scene::Mount>(name).value_or(scene::Mount::kFloor);
          },
          "of the robot: floor, ceiling or wall; default floor")
      ->check(CLI::IsMember({"floor", "ceiling", "wall"}));
}

/// The text as one printable line.
void print_error(std::string_view message) {
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

int exit_code_of_command_line(int argc, char** argv,
                              const std::function<void(const ViewOptions&)>& view) {
  CLI::App app{"fricid: ground truth, identification and pictures for friction in robot joints"};
  app.require_subcommand(0, 1);
  app.set_help_all_flag("--help-all", "help of every command");
  bool version = false;
  app.add_flag("--version", version, "versions, SIMD path, renderers found");

  CommonOptions common;
  RunOptions run_options;
  RenderOptions render_options;
  ViewOptions view_options;
  ImportOptions import_options;
  EstimateOptions estimate_options;
  CheckOptions check_options;
  PayloadOptions payload_options;
  ContactOptions contact_options;
  ExportOptions export_options;
  std::string file, topic, against;
  std::vector<std::filesystem::path> folders;
  std::filesystem::path output;
  bool csv = false;
  std::function<Verdict()> command;

  auto* run_command =
      app.add_subcommand("run", "run everything: data, identification, evaluation, plots, report");
  run_command->add_option("SCENE", run_options.target, "scene file (TOML)")->required();
  run_command->add_option("-o,--output", run_options.output, "run folder; default run/NAME");
  const auto is_seed = [](const std::string& text) {
    return whole_number_up_to(limits::kSeed, text);
  };
  run_command->add_option("--seed", run_options.seed, "seed of the data; default: scene")
      ->check(is_seed);
  run_command->add_flag("--no-video", run_options.no_video, "make no videos");
  add_common(*run_command, common, "fricid run scenes/kr6_demo.toml -o run/kr6_demo");
  run_command->callback([&] { command = [&] { return run(run_options, common); }; });

  auto* simulate_command =
      app.add_subcommand("simulate", "ground truth only: data sets and truth files");
  simulate_command->add_option("SCENE", run_options.target, "scene file (TOML)")->required();
  simulate_command->add_option("-o,--output", run_options.output, "run folder; default run/NAME");
  simulate_command->add_option("--seed", run_options.seed, "seed of the data; default: scene")
      ->check(is_seed);
  add_common(*simulate_command, common, "fricid simulate scenes/kr6_lugre.toml");
  simulate_command->callback([&] { command = [&] { return simulate(run_options, common); }; });

  auto* identify_command = app.add_subcommand("identify", "fit models to the training data");
  identify_command->add_option("SCENE|DIR", run_options.target, "scene file or run folder")
      ->required();
  identify_command->add_option("-o,--output", run_options.output, "run folder; default run/NAME");
  identify_command->add_option("--model", run_options.models, "only these models (repeatable)")
      ->allow_extra_args(false);
  identify_command->add_option("--seeds", run_options.seeds, "of the fits, e.g. 1-5 or 1,3")
      ->each([](const std::string& text) { parse_seeds(text); });
  add_common(*identify_command, common, "fricid identify run/kr6_demo --model lugre --seeds 1-5");
  identify_command->callback([&] { command = [&] { return identify(run_options, common); }; });

  auto* evaluate_command = app.add_subcommand(
      "evaluate", "open loops against held-out data, models in DIR/external included");
  evaluate_command->add_option("DIR", run_options.target, "run folder")->required();
  evaluate_command->add_option("--data", run_options.data,
                               "further data sets (HDF5) to evaluate on");
  add_common(*evaluate_command, common,
             "fricid evaluate run/kr6_demo --data other/validation_0.h5");
  evaluate_command->callback([&] { command = [&] { return evaluate(run_options, common); }; });

  auto* render_command =
      app.add_subcommand("render", "draw the plots, videos, report or a still of a run folder");
  render_command->add_option("DIR", render_options.target, "run folder")->required();
  render_command
      ->add_option("WHAT", render_options.what, "plots, video, report, still; default: not still")
      ->check(CLI::IsMember({"plots", "video", "report", "still"}));
  render_command->add_option("--quality", render_options.quality, "of the video; default: scene")
      ->check(CLI::IsMember(all_names<film::Quality>()));
  render_command->add_option("--layout", render_options.layout, "of the video; default: scene")
      ->check(CLI::IsMember(all_names<film::Layout>()));
  render_command->add_option("--renderer", render_options.renderer, "default: the first that works")
      ->check(CLI::IsMember({"egl", "osmesa"}));
  render_command->add_option("-o,--output", render_options.still,
                             "file of the still; default still.png");
  render_command->add_option("--at", render_options.at, "time of the still [s]; default: middle");
  add_common(*render_command, common, "fricid render run/kr6_demo video --quality final");
  render_command->callback([&] { command = [&] { return render(render_options, common); }; });

  auto* compare_command = app.add_subcommand(
      "compare", "join the evaluations of many runs, with intervals over the runs");
  compare_command->add_option("DIR", folders, "run folders")->required();
  compare_command->add_option("--against", against, "model whose errors the others are divided by");
  compare_command->add_option("-o,--output", output, "file for the table; default stdout");
  add_common(*compare_command, common, "fricid compare run/kr6_gms_1 run/kr6_gms_2");
  compare_command->callback(
      [&] { command = [&] { return compare(folders, against, output, common); }; });

  auto* view_command =
      app.add_subcommand("view", "replay a run, or move the live arm with adjustable friction");
  view_command->add_option("DIR|SCENE|MODEL", view_options.target, "what to show")->required();
  view_command->add_option("--screenshot", view_options.screenshot,
                           "write this PNG and exit; needs no display");
  view_command->add_option("--at", view_options.at, "time of the screenshot [s]");
  view_command->add_option("--script", view_options.script,
                           "run the commands of this file, then exit (docs/rendering.md)");
  view_command->add_option("--renderer", view_options.renderer, "of the screenshot")
      ->check(CLI::IsMember({"egl", "osmesa"}));
  add_common(*view_command, common, "fricid view run/kr6_demo");
  view_command->callback([&] {
    command = [&] {
      if (!view) throw UserError("this build has no viewer; docs/rendering.md says how to get it");
      view(view_options);
      return Verdict::kDone;
    };
  });

  auto* import_command =
      app.add_subcommand("import", "convert real logs to data sets (docs/your_own_log.md)");
  import_command->add_option("LOG", import_options.logs, "log files")->required();
  import_command->add_option("--contract", import_options.contract, "meaning of the columns (TOML)")
      ->required();
  import_command->add_option("-o,--output", import_options.output,
                             "folder for the data sets; default .");
  import_command->add_option("--robot", import_options.robot.urdf,
                             "URDF: joints are then checked against its dynamics too");
  add_robot_of_log(*import_command, import_options.robot);
  import_command
      ->add_option("--fix", import_options.fixes,
                   "findings to repair, by name: gap,delay,... (docs/your_own_log.md)")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_common(*import_command, common, "fricid import log.csv --contract contract.toml -o data");
  import_command->callback([&] { command = [&] { return import_logs(import_options, common); }; });

  auto* check_command =
      app.add_subcommand("check", "check data: faults, and which parameters they identify");
  check_command
      ->add_option("DIR|LOG", check_options.target,
                   "run folder, data set (HDF5), or log; \"LOG[FROM:TO]\", in seconds, for a part")
      ->required();
  check_command->add_option("--contract", check_options.contract, "of a log (TOML)");
  check_command->add_option("--robot", check_options.robot.urdf, "URDF of the robot of a log");
  add_robot_of_log(*check_command, check_options.robot);
  check_command->add_option(
      "--design", check_options.design,
      "write a trajectory (TOML, and CSV beside it) to identify more parameters");
  check_command->add_flag("--verbose", check_options.verbose,
                          "every parameter, joint and note, beside the verdict");
  add_common(*check_command, common, "fricid check log.csv --contract contract.toml");
  check_command->callback([&] { command = [&] { return check(check_options, common); }; });

  auto* payload_command = app.add_subcommand(
      "payload",
      "identify a load: its mass, centre of mass and inertia, from logs without and with it");
  payload_command
      ->add_option("WITHOUT", payload_options.without,
                   "run folder, data set (HDF5), or log without the load; \"LOG[FROM:TO]\", in "
                   "seconds, for a part")
      ->required();
  payload_command
      ->add_option("WITH", payload_options.with,
                   "data set (HDF5), or log with the load, or a part of it")
      ->required();
  payload_command->add_option("--contract", payload_options.contract, "of both logs (TOML)");
  payload_command->add_option("--robot", payload_options.robot.urdf,
                              "URDF of the robot without the load");
  add_robot_of_log(*payload_command, payload_options.robot);
  payload_command->add_option("--frame", payload_options.frame,
                              "that carries the load; default flange or tool0");
  payload_command->add_option("-o,--output", payload_options.output, "JSON file; default none");
  add_common(*payload_command, common,
             "fricid payload without.csv with.csv --contract contract.toml --robot arm.urdf");
  payload_command->callback(
      [&] { command = [&] { return find_payload(payload_options, common); }; });

  auto* estimate_command = app.add_subcommand(
      "estimate", "estimate states and friction along a log with the online filter");
  estimate_command->add_option("MODEL", estimate_options.model, "identified model (JSON)")
      ->required();
  estimate_command->add_option("LOG", estimate_options.log, "data set (HDF5)")->required();
  estimate_command->add_option("-o,--output", estimate_options.output,
                               "HDF5 file; default estimate.h5");
  estimate_command->add_option("--particles", estimate_options.particles, "of the filter")
      ->check(CLI::Range(1, 1'000'000));
  estimate_command->add_option("--seed", estimate_options.seed, "of the filter")->check(is_seed);
  add_common(*estimate_command, common,
             "fricid estimate run/kr6_demo/models/lugre_s1.json "
             "run/kr6_demo/data/validation_0.h5 -o estimate.h5");
  estimate_command->callback(
      [&] { command = [&] { return estimate_log(estimate_options, common); }; });

  auto* contact_command = app.add_subcommand(
      "contact", "find the external torque along a log with a momentum observer");
  contact_command->add_option("MODEL", contact_options.model, "identified model (JSON)")
      ->required();
  contact_command->add_option("LOG", contact_options.log, "data set (HDF5)")->required();
  contact_command->add_option("-o,--output", contact_options.output,
                              "HDF5 file; default contact.h5");
  contact_command
      ->add_option("--bandwidth", contact_options.bandwidth_hz, "of the observer [Hz]; default 10")
      ->check(CLI::Range(0.1, 1000.0));
  contact_command
      ->add_option("--particles", contact_options.particles,
                   "that filter the states of friction; default 0: they follow the motion")
      ->check(CLI::Range(0, 1'000'000));
  contact_command->add_option("--seed", contact_options.seed, "of the particles")->check(is_seed);
  add_common(*contact_command, common,
             "fricid contact run/kr6_demo/models/lvm_s1.json "
             "run/kr6_demo/data/validation_0.h5 -o contact.h5");
  contact_command->callback(
      [&] { command = [&] { return find_contact(contact_options, common); }; });

  auto* export_command =
      app.add_subcommand("export", "models for simulators and controllers (docs/use_it.md)");
  export_command->add_option("RUN|MODEL", export_options.target, "run folder or model (JSON)")
      ->required();
  export_command->add_option("FORMAT", export_options.format, deploy::format_list())->required();
  export_command->add_option("-o,--output", export_options.output, "folder for the files")
      ->required();
  export_command->add_option("--mjcf", export_options.mjcf,
                             "plugin: MJCF that includes the extension, to be checked");
  add_common(*export_command, common,
             "fricid export run/kr6_demo/models/lugre_s1.json c -o controller");
  export_command->callback(
      [&] { command = [&] { return export_models(export_options, common); }; });

  auto* info_command = app.add_subcommand("info", "show the content of any fricid file");
  info_command->add_option("FILE", file, "data set, truth, rollout, model or scene")->required();
  info_command->add_flag("--csv", csv, "write its signals as CSV");
  add_common(*info_command, common, "fricid info run/kr6_demo/data/train_0.h5");
  info_command->callback([&] { command = [&] { return info(file, csv, common); }; });

  auto* template_command = app.add_subcommand("template", "print a commented file with every key");
  template_command->add_option("KIND", topic, "robot, scene or contract")
      ->required()
      ->check(CLI::IsMember({"robot", "scene", "contract"}));
  add_common(*template_command, common, "fricid template scene > my_scene.toml");
  template_command->callback([&] { command = [&] { return print_template(topic); }; });

  refuse_empty_texts(app);
  install_stop_handler();
  try {
    app.parse(argc, argv);
    Progress::set_quiet(common.quiet);
    if (version) return print_version(), kDone;
    if (!command) return std::fputs(app.help().c_str(), stdout), kUserMistake;
    return exit_code_of(command());
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
