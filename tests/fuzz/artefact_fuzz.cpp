// libFuzzer target: the JSON artefacts of a run folder. The first byte chooses the kind; the others
// are the file. What is read can be written and read again, and an evaluation makes tables.
#include "fricid/data/artefact.hpp"
#include "fricid/data/fit_file.hpp"
#include "fricid/evaluate/compare.hpp"
#include "fricid/evaluate/evaluate.hpp"
#include "fricid/sim/excitation_file.hpp"
#include "fricid/workflow/manifest.hpp"
#include "target.hpp"

namespace {

using namespace fricid;

constexpr char kFile[] = "artefact.json", kAgain[] = "again.json";

template <class Artefact, class Use>
void read(Use use) {
  std::optional<Artefact> artefact;
  if (!fuzz::reads({kFile}, [&] { artefact = data::load<Artefact>(kFile); })) return;
  const std::string text = data::to_json(*artefact);
  fuzz::write(kAgain, text);
  fuzz::require_same("the artefact", text, data::to_json(data::load<Artefact>(kAgain)));
  use(*artefact);
}

void make_tables(const evaluate::Evaluation& evaluation) {
  evaluate::to_markdown(evaluation);
  evaluate::to_csv(evaluation);
  evaluate::short_table(evaluation, {});
  fuzz::reads({kFile}, [&] {
    evaluate::to_markdown(evaluate::compare_runs(
        std::vector<evaluate::ComparedRun>{{kFile, evaluation, {}}, {kAgain, evaluation, {}}}));
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  fuzz::write(kFile, fuzz::text_of(data + 1, size - 1));
  switch (data[0] % 4) {
    case 0:
      read<evaluate::Evaluation>(make_tables);
      break;
    case 1:
      read<data::FitFile>([](const data::FitFile&) {});
      break;
    case 2:
      read<workflow::Manifest>([](const workflow::Manifest& file) { workflow::fit_seconds(file); });
      break;
    default:
      read<sim::ExcitationFile>([](const sim::ExcitationFile&) {});
  }
  return 0;
}
