// fricid payload: the load of an arm from logs without and with it.
#include "fricid/workflow/payload.hpp"
#include "commands.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/data/payload_file.hpp"
#include "fricid/workflow/run.hpp"
#include "outputs.hpp"
#include "terminal.hpp"

namespace fricid::cli {

Verdict find_payload(const PayloadOptions& options, const CommonOptions& common) {
  require_not_input("-o", options.output,
                    {options.without, options.with, options.contract, options.robot.urdf});
  require_like("-o", options.output, data::PayloadFile::kFormat);
  const bool is_run = workflow::is_run_folder(options.without);
  if (is_run) require_no_robot(options.robot, options.without);
  const workflow::Subject without =
      is_run ? workflow::subject_of_run(options.without)
             : workflow::subject_of_log(options.without, options.contract, options.robot);
  const workflow::Subject with =
      workflow::subject_of_log(options.with, options.contract, without.robot);
  for (const workflow::Subject* subject : {&without, &with})
    for (const std::string& warning : subject->warnings) print(warning + "\n", stderr);
  const data::PayloadFile payload = workflow::find_payload(without, with.sets, options.frame);
  if (!options.output.empty()) data::save(payload, options.output);
  print(common.json ? visible_json(data::to_json(payload)) : workflow::to_text(payload));
  for (const std::string& doubt : payload.doubts)
    print("not to be trusted: " + doubt + "\n", stderr);
  if (payload.outcome != data::Outcome::kConverged)
    print(payload.message + "\n", stderr);
  else if (payload.doubts.empty())
    return Verdict::kDone;
  return Verdict::kNo;
}

}  // namespace fricid::cli
