// fricid payload: the load of an arm from logs without and with it.
#include "fricid/workflow/payload.hpp"
#include "commands.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/data/artefact.hpp"
#include "fricid/workflow/run.hpp"
#include "terminal.hpp"

namespace fricid::cli {

namespace fs = std::filesystem;

Verdict find_payload(const PayloadOptions& options, const CommonOptions& common) {
  for (const fs::path& input :
       {options.without, options.with, options.contract, options.robot.urdf})
    if (!options.output.empty() && !input.empty() &&
        fs::weakly_canonical(options.output) == fs::weakly_canonical(input))
      throw UserError("-o {}: would replace an input; allowed: another name",
                      options.output.string());
  const workflow::Subject without =
      workflow::is_run_folder(options.without)
          ? workflow::subject_of_run(options.without)
          : workflow::subject_of_log(options.without, options.contract, options.robot);
  const workflow::Subject with = workflow::subject_of_log(options.with, options.contract, {});
  const data::PayloadFile payload = workflow::find_payload(without, with.sets, options.frame);
  if (!options.output.empty()) data::save(payload, options.output);
  print(common.json ? visible_json(data::to_json(payload)) : workflow::to_text(payload));
  return payload.outcome == data::Outcome::kConverged ? Verdict::kDone : Verdict::kNo;
}

}  // namespace fricid::cli
