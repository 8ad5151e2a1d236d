// An unknown load, found from recordings with it.
#include <array>

#include "html.hpp"
#include "report_parts.hpp"

namespace fricid::render {
namespace {

using html::Row;
using html::Style;

/// Values of a quantity, their standard errors and, where the load was simulated, the true ones.
struct Quantity {
  std::string_view unit;
  std::vector<std::string_view> names;
  std::vector<double> found, error, truth;
};

void add_rows(const Quantity& quantity, bool known, std::vector<Row>& rows) {
  for (std::size_t i = 0; i < quantity.found.size() && i < quantity.names.size(); ++i) {
    Row row{{{html::escaped(quantity.names[i])}}};
    row.style = i == 0 ? Style::kRule : Style::kPlain;
    row.cells.push_back({html::number(quantity.found[i], 4)});
    row.cells.push_back({html::number(i < quantity.error.size() ? quantity.error[i] : kNaN)});
    if (known) row.cells.push_back({html::number(quantity.truth[i], 4)});
    row.cells.push_back({html::escaped(quantity.unit), Style::kText});
    rows.push_back(std::move(row));
  }
}

}  // namespace

Html payload_section(const Record& record) {
  if (!record.run.payload) return {};
  const data::PayloadFile& load = *record.run.payload;
  const scene::PayloadSection& truth = record.scene.payload;
  const bool known = record.scene.simulates();
  std::vector<Html> head = html::headings({"load", "found", "± s.e."});
  if (known) head.push_back(Html::of("truth"));
  head.push_back(Html::of("unit"));
  std::vector<Row> rows;
  add_rows({"kg", {"mass"}, {load.mass}, {load.mass_error}, {truth.mass_kg}}, known, rows);
  add_rows({"m",
            {"centre x", "centre y", "centre z"},
            load.com,
            load.com_error,
            {truth.com.begin(), truth.com.end()}},
           known, rows);
  add_rows({"kg m²",
            {"Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"},
            load.inertia,
            load.inertia_error,
            {truth.inertia.begin(), truth.inertia.end()}},
           known, rows);
  return Html::of("<h2 id=\"payload\">Load</h2>\n") +
         html::table(head, rows,
                     Html::of("In the axes of {}, the inertia about the centre of mass: weighted "
                              "least squares over {} recording{} without the load and {} with it, "
                              "then the nearest rigid body. {}: {}.",
                              html::escaped(load.frame), load.without.size(),
                              html::plural(load.without.size()), load.with.size(),
                              html::escaped(name_of(load.outcome)), html::escaped(load.message)));
}

}  // namespace fricid::render
