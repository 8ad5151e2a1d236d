#include "fricid/render/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "../../render/src/html.hpp"
#include "../../render/src/svg.hpp"
#include "fricid/base/error.hpp"
#include "fricid/base/files.hpp"
#include "fricid/workflow/manifest.hpp"
#include "run_folder_fixture.hpp"

namespace fricid::render {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Report : public RunToDraw {
 protected:
  scene::Scene scene;
  workflow::Manifest manifest;

  std::string page() const { return report_of_run(run, scene, manifest); }
};

TEST_F(Report, NamesTheBestModelAndItsDistanceFromTheOracle) {
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("Of 1 model of <b>two joints</b>, <b>simple</b> follows the held-out "
                              "trajectory best"));
  // sqrt(7e-6) and sqrt(1e-6) rad
  EXPECT_THAT(page, HasSubstr("it is off by 2.6&#8239;mrad within 1&#8239;s"));
  EXPECT_THAT(page,
              HasSubstr("The true model under the same noisy torque is off by 1.0&#8239;mrad"));
  EXPECT_THAT(page, HasSubstr("the squared error of simple is 7.0 times the smallest possible one: "
                              "no model here closes this headroom."));
}

TEST_F(Report, ClaimsNoHeadroomWhereTheTruthIsNoBetter) {
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    evaluation.summary[2].ratio_to_oracle.assign(evaluation.horizons_s.size(), 0.75);
  });
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("the squared error of simple is 0.75"));
  EXPECT_THAT(page, HasSubstr("times as large, so within 1&#8239;s"));
  EXPECT_THAT(page, HasSubstr("no model can be told to be better."));
  EXPECT_THAT(page, Not(HasSubstr("smallest possible one")));
  EXPECT_THAT(page, Not(HasSubstr("headroom.")));
}

// The table marks no model as best that failed its own checks.
TEST_F(Report, NothingIsBestThatIsNotTrusted) {
  const auto table_1 = [&] {
    const std::string page = this->page();
    const std::size_t begin = page.find("<table", page.find("<b>Table 1.</b>"));
    return page.substr(begin, page.find("</table>", begin) - begin);
  };
  EXPECT_THAT(table_1(), HasSubstr("class=\"best\""));
  EXPECT_THAT(table_1(), HasSubstr("yes</td>"));
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    evaluation.summary[2].doubts = {"R2 of joint_a1 is 0.1"};
  });
  EXPECT_THAT(table_1(), Not(HasSubstr("class=\"best\"")));
  EXPECT_THAT(table_1(), HasSubstr("no</td>"));
}

TEST_F(Report, SaysWhatFrictionATorqueBeyondTheGearShows) {
  const auto says = HasSubstr("what is identified is the friction beyond the sensor");
  EXPECT_THAT(page(), Not(says));
  trajectory.data.source = "import log.csv, tau from link_torque; fixed gap";
  data::save_dataset(trajectory.data, run.recording(kTrajectory));
  EXPECT_THAT(page(), says);
}

TEST_F(Report, SaysWhichJointsSlide) {
  EXPECT_THAT(page(), Not(HasSubstr("(m, N)")));
  let_slide(1);
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("joint_a2 (m, N)"));
  EXPECT_THAT(page, Not(HasSubstr("joint_a1 (m, N)")));
}

TEST_F(Report, SaysWhatAFitMayTry) {
  EXPECT_THAT(page(), Not(HasSubstr("budget</th>")));
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    evaluation.summary[2].budget = "20 starts & 300 steps";
  });
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("budget</th>"));
  EXPECT_THAT(page, HasSubstr("20 starts &amp; 300 steps"));
}

/// An archive that puts a text behind every text of an artefact but those under some keys.
struct AddToTexts {
  std::string text;
  std::set<std::string_view> spared;
  int count = 0;

  template <class Value>
  void operator()(std::string_view key, Value& value, const Field& field) {
    if (spared.contains(key) || !field.choices.empty()) return;
    if constexpr (std::is_same_v<Value, std::string>) {
      add(value);
    } else if constexpr (std::is_same_v<Value, std::vector<std::string>>) {
      for (std::string& item : value) add(item);
    }
  }
  template <class Values>
  void pairs(std::string_view, Values&, const Field&) {}
  template <class Value>
  void derived(std::string_view, const Value&, const Field&) {}
  template <class Part>
  void section(std::string_view, Part& part, std::string_view) {
    part.visit(*this);
  }
  template <class Part>
  void section(std::string_view, std::optional<Part>& part, std::string_view) {
    if (part) part->visit(*this);
  }
  template <class Part>
  void sections(std::string_view, std::vector<Part>& parts, std::string_view) {
    for (Part& part : parts) part.visit(*this);
  }
  template <class Part>
  void sections(std::string_view key, std::optional<std::vector<Part>>& parts,
                std::string_view meaning) {
    if (parts) sections(key, *parts, meaning);
  }

 private:
  void add(std::string& value) {
    value += text;
    ++count;
  }
};

TEST_F(Report, TextOfFilesIsNoMarkup) {
  // names are checked where they are read
  AddToTexts hostile{"</p><x-hostile a='1' b=\"2\">&amp;",
                     {"name", "scene", "trajectories", "joint"}};
  edit_evaluation([&](evaluate::Evaluation& evaluation) { evaluation.visit(hostile); });
  edit_fit([&](data::FitFile& fit) {
    fit.joints[0].at_bound = {"Fc", "Fv"};
    fit.outcome = data::Outcome::kFailed;
    fit.usable = false;
    fit.em.emplace().warnings = {"few particles"};
    fit.torque.emplace();
    fit.visit(hostile);
  });
  manifest.sources = {{"robot.urdf", "hash"}};
  workflow::StageRecord& stage = manifest.at(workflow::stage_of(simple));
  stage.outputs = {{"models/simple_s1.json", "hash"}};
  hostile.spared.clear();
  manifest.visit(hostile);
  manifest.check("the manifest");
  EXPECT_GT(hostile.count, 20);
  scene.description = hostile.text;
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("&lt;x-hostile"));
  EXPECT_THAT(page, Not(HasSubstr("<x-hostile")));
  EXPECT_THAT(page, Not(HasSubstr("b=\"2\"")));
}

TEST_F(Report, SaysWhatFails) {
  EXPECT_THAT(page(), HasSubstr("Nothing failed"));
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    evaluation.summary[2].diverged = 3;
    evaluation.meaningless[1] = "headroom 2 below 10";
  });
  edit_fit([](data::FitFile& fit) { fit.joints[0].at_bound = {"Fc", "Fv"}; });
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("What fails: simple diverges in 3 of 4 rollouts, 2 parameters ended "
                              "on a bound and the horizon of 10&#8239;s cannot rank models"));
  EXPECT_THAT(page, HasSubstr("on a bound: Fc, Fv of joint_a1"));
  EXPECT_THAT(page, HasSubstr("headroom 2 below 10"));
}

TEST_F(Report, WarnsOfTrainingThatWentAstray) {
  edit_fit([](data::FitFile& fit) {
    fit.torque.emplace().skipped = 7;
    data::FittedTraining& windows = fit.multi_step.emplace();
    windows.checked = {0, 1, 2, 3};
    windows.held_out = {4, 3, 2, 1};
    windows.chosen = 3;
    windows.returns = 1;
  });
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("7 training steps were skipped"));
  EXPECT_THAT(page, HasSubstr("returned to its best point 1 time."));
  EXPECT_THAT(page, Not(HasSubstr("did not improve on its start")));
}

TEST_F(Report, WarnsOfTrainingThatLedNowhere) {
  const auto of_em = [&](int chosen) {
    edit_fit([&](data::FitFile& fit) {
      fit.joints.clear();
      fit.em.emplace().iterations.resize(2);
      fit.em->chosen = chosen;
    });
    return page();
  };
  EXPECT_THAT(of_em(-1), HasSubstr("did not improve on its start"));
  EXPECT_THAT(of_em(0), Not(HasSubstr("did not improve on its start")));  // the first iteration
}

TEST_F(Report, TheTimeOfAFitIsThatOfItsStage) {
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    add_model(evaluation, "tool", false, {1e-6, 2e-6});
    evaluation.summary.back().stated_fit_seconds = 77;
    add_model(evaluation, "unknown", false, {1e-6, 2e-6});
  });
  manifest.at("identify simple_s1").seconds = 12;
  manifest.at("identify simple_s2").seconds = 14;
  manifest.at("plots").outputs = {{"plots/tracking.svg", "5a5a"}};
  manifest.at("evaluate").outputs = {{"evaluation.json", "c3c3"}};
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("<td>13&#8239;s</td>"));
  EXPECT_THAT(page, HasSubstr("<td>77&#8239;s</td>"));
  EXPECT_THAT(page, HasSubstr("<td>–</td>"));
  EXPECT_THAT(page, HasSubstr("<dt>Time</dt><dd>12&#8239;s</dd>"));
  EXPECT_THAT(page, HasSubstr("c3c3  evaluation.json"));
  EXPECT_THAT(page, Not(HasSubstr("5a5a")));  // pictures are no results
}

TEST_F(Report, SaysWhatTheSceneSaysOfItself) {
  EXPECT_THAT(page(), HasSubstr("<p class=\"byline\">fricid"));
  scene.description = "bristles & noise";
  EXPECT_THAT(page(), HasSubstr("bristles &amp; noise · fricid"));
  EXPECT_THAT(page(), HasSubstr("description = &quot;bristles &amp; noise&quot;"));
}

TEST_F(Report, WithoutTruthSaysNothingOfOracles) {
  std::filesystem::remove(run.truth(kTrajectory));
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    evaluation.models.erase(evaluation.models.begin(), evaluation.models.begin() + 2);
    evaluation.summary.erase(evaluation.summary.begin(), evaluation.summary.begin() + 2);
    evaluation.floor = evaluation.oracle = unknown(2);
  });
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("A log holds no truth"));
  EXPECT_THAT(page, Not(HasSubstr("Table 2.")));
  EXPECT_THAT(page, Not(HasSubstr(">floor<")));
}

TEST_F(Report, ShowsParametersWithTruthAndBounds) {
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("Parameters of <i>dahl</i>"));
  EXPECT_THAT(page, HasSubstr("truth: as injected"));
}

TEST_F(Report, ShowsParametersOfModifiers) {
  data::ModelFile model = data::load_model(run.model(simple));
  const friction::JointSpec joint{
      {{.law = "dahl", .elements = 0, .modifiers = {{"asymmetry", 1}}}}};
  model.arm.friction.model = friction::RobotFriction({joint, joint});
  model.arm.friction.theta = friction::default_theta(model.arm.friction.model);
  data::save_model(model, run.model(simple));
  const std::string page = this->page();
  EXPECT_THAT(page, HasSubstr("Parameters of <i>dahl</i>"));
  EXPECT_THAT(page, HasSubstr("Parameters of <i>asymmetry</i> of <i>dahl</i>"));
}

TEST_F(Report, SaysOfRolloutsAloneThatTheyAre) {
  edit_evaluation([](evaluate::Evaluation& evaluation) {
    add_model(evaluation, "tool", false, {1e-6, 2e-6});
    evaluation.models.back().label = evaluation.summary.back().label = "a tool";
  });
  const std::string page = this->page();
  const std::size_t section = page.find("<section id=\"model-tool-1\">");
  ASSERT_NE(section, std::string::npos);
  EXPECT_THAT(page.substr(section, page.find("</section>", section) - section),
              AllOf(HasSubstr("a tool"), HasSubstr("Only rollouts, made by another program"),
                    Not(HasSubstr("Parameters"))));
}

TEST_F(Report, NeedsAnEvaluation) {
  std::filesystem::remove(run.evaluation());
  EXPECT_THROW(write_report(run, scene, manifest, run.report()), UserError);
  EXPECT_FALSE(std::filesystem::exists(run.report()));
}

TEST(Html, EscapesWhatHasAMeaning) {
  EXPECT_EQ(html::escaped("a<b> & \"c\" 'd'").text(), "a&lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;");
}

/// Whether a value may stand in a piece of HTML as it is.
template <class Value>
concept EntersHtml = requires(Value value) {
  Html::of("{}", value);
};
static_assert(EntersHtml<Html> && EntersHtml<double> && EntersHtml<int>);
static_assert(!EntersHtml<std::string> && !EntersHtml<std::string_view> &&
              !EntersHtml<const char*>);
static_assert(!EntersHtml<Svg>);
static_assert(!std::is_convertible_v<std::string, Html> &&
              !std::is_convertible_v<const char*, Html>);

TEST(Html, NumbersHaveTheDigitsThatCount) {
  EXPECT_EQ(html::number(0.123).text(), "0.12");
  EXPECT_EQ(html::number(9.96).text(), "10.0");
  EXPECT_EQ(html::number(4667.2).text(), "4667");
  EXPECT_EQ(html::number(-7.2e-9).text(), "−7.2&#8239;×&#8239;10<sup>−9</sup>");
  EXPECT_EQ(html::number(NAN).text(), "–");
  EXPECT_EQ(html::percent(0.0345).text(), "3.5&#8239;%");
}

TEST(Svg, OnlyWhatGnuplotDrawsMayEnterAPage) {
  const auto with = [](const std::string& part) {
    return is_plain_svg("<?xml version=\"1.0\"?>\n<svg width=\"1\">" + part + "</svg>");
  };
  EXPECT_TRUE(with("<g id='a'><use xlink:href='#gpPt6'/><text>on load=1 \" ></text></g>"));
  for (const char* part :
       {"<script>x</script>", "<g onload='x'/>", "<g\nONLOAD=x/>", "<g a=''onload=x/>",
        "<g/onload=x/>", "<use xlink:href='data:x'/>", "<use href=\"http://x\"/>",
        "<foreignObject/>", "<a/>", "<style>*{}</style>", "<![CDATA[x]]>", "<!ENTITY x>", "<g a='",
        "</g><iframe>"})
    EXPECT_FALSE(with(part)) << part;
  EXPECT_FALSE(is_plain_svg("text"));
}

// Labels may hold what looks like an attribute.
TEST(Svg, WordsStayWords) {
  const std::string words = "<text> d='M1,2 id=\"x\" ]]></text>";
  EXPECT_THAT(
      inline_svg(plain_svg("<svg width=\"1\" height=\"1\">" + words + "</svg>", "a.svg"), "")
          .text(),
      HasSubstr("<text> d=&#39;M1,2 id=&quot;x&quot; ]]&gt;</text>"));
}

TEST(Svg, PathsAreShortenedWithoutDrift) {
  EXPECT_EQ(relative_path("M10.04,20.00 L11.06,20.00 L11.06,18.55  "), "M10,20l1.1,0 0-1.4");
  // A thousand steps of 0.04 px end where they should.
  std::string d = "M0,0 ";
  for (int i = 1; i <= 1000; ++i) d += fmt::format("L{:.2f},0 ", 0.04 * i);
  double x = 0;
  const std::string path = relative_path(d);
  for (std::size_t at = path.find('l'); at != std::string::npos; at = path.find(' ', at + 1))
    x += std::stod(path.substr(at + 1));
  EXPECT_NEAR(x, 40, 1e-9);
}

TEST(Svg, BlackFollowsThePage) {
  const Svg picture = plain_svg(
      "<?xml?>\n<svg width=\"10\" height=\"20\" xmlns=\"x\">\n<title>Gnuplot</title>\n"
      "<defs><path id='gpPt0'/></defs><g id=\"plot\" color=\"black\"><path stroke='black'  "
      "d='M1.00,2.00 L3.00,2.00  '/></g></svg>\n",
      "a.svg");
  const std::string svg = inline_svg(picture, "a \"plot\"").text();
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 10 20\""));
  EXPECT_THAT(svg, HasSubstr("aria-label=\"a &quot;plot&quot;\""));
  EXPECT_THAT(svg, HasSubstr("<path stroke='currentColor'  d='M1,2l2,0'/>"));
  for (const char* gone : {"black", "id=", "defs", "title", "xml"})
    EXPECT_THAT(svg, Not(HasSubstr(gone)));
}

}  // namespace
}  // namespace fricid::render
