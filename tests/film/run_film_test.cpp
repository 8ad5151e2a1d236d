#include "fricid/film/run_film.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "film_fixture.hpp"
#include "fricid/base/error.hpp"
#include "fricid/workflow/recordings.hpp"

namespace fricid::film {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> names(const RunFilm& film) {
  std::vector<std::string> names;
  for (const FilmModel& model : film.models) names.push_back(model.name);
  return names;
}

using ReadFilm = FilmFolder;

TEST_F(ReadFilm, ShowsTheBestTheFirstAndTheNextBestInTheOrderOfTheScene) {
  EXPECT_THAT(names(read_film(run, problem())), ElementsAre("simple", "lugre", "gms"));
}

TEST_F(ReadFilm, ShowsWhatTheSceneNames) {
  scene.render.models = {"dahl"};
  EXPECT_THAT(names(read_film(run, problem())), ElementsAre("dahl"));
  scene.render.models = {"neural"};
  EXPECT_THROW(read_film(run, problem()), UserError);
}

TEST_F(ReadFilm, TakesTruthModelsAndTable) {
  const RunFilm film = read_film(run, problem());
  EXPECT_EQ(film.q, motion(0, false));
  EXPECT_EQ(film.tau_f, friction(0));
  EXPECT_EQ(film.models[2].q, motion(0.02, false));
  EXPECT_EQ(film.oracle.q, motion(1e-4, false));
  ASSERT_EQ(film.table.size(), 5u);
  EXPECT_TRUE(film.table[0].is_oracle);
  EXPECT_TRUE(film.table[1].shown);
  EXPECT_FALSE(film.table[3].shown);
  EXPECT_THAT(film.table[4].mse, ElementsAre(4e-5, 4e-4));
  EXPECT_EQ(film.row(1.0), 250);
  EXPECT_EQ(film.row(99), kRows - 1);
}

TEST_F(ReadFilm, WithoutTruthTheMeasurementStandsForIt) {
  std::filesystem::remove(run.truth(kTrajectory));
  const RunFilm film = read_film(run, problem());
  EXPECT_FALSE(film.has_truth());
  EXPECT_EQ(film.q, motion(0, false));
  EXPECT_EQ(most_telling_joint(film), 0);
}

TEST_F(ReadFilm, RolloutsWithoutFrictionTorqueAreInTheTableOnly) {
  save_rollout("gms", 0.02, data::RowMatrix());
  const RunFilm film = read_film(run, problem());
  EXPECT_THAT(names(film), ElementsAre("simple", "lugre", "dahl"));
  EXPECT_EQ(film.table.size(), 5u);
}

TEST_F(ReadFilm, ShorterRolloutsShortenTheFilm) {
  save_rollout("gms", 0.02, friction(0), 100);
  const RunFilm film = read_film(run, problem());
  EXPECT_EQ(film.t.size(), 100);
  EXPECT_EQ(film.models[0].tau_f.rows(), 100);
  EXPECT_EQ(film.oracle.q.rows(), 100);
}

TEST_F(ReadFilm, ARolloutThatIsNotShownIsAbsent) {
  const workflow::RunFolder visible =
      run.restricted_to({run.name_of(run.evaluation()), run.name_of(run.recording(kTrajectory)),
                         run.name_of(run.rollout({"dahl", 1}, kTrajectory))});
  const RunFilm film = read_film(visible, problem());
  EXPECT_THAT(names(film), ElementsAre("dahl"));
  EXPECT_FALSE(film.has_truth());
  EXPECT_EQ(film.oracle.q.size(), 0);
  EXPECT_FALSE(workflow::is_there(film.models[0].file));
}

TEST_F(ReadFilm, TheMostTellingJointIsMissedMost) {
  EXPECT_EQ(most_telling_joint(read_film(run, problem())), 2);
}

TEST(Describe, NamesLawsElementsAndModifiers) {
  const friction::JointSpec joint{
      {{"gms", 4, {{"load"}, {"ripple"}, {"asymmetry"}}}, {"coulomb_viscous", 0, {}}}};
  const friction::RobotFriction model({joint, joint});
  EXPECT_EQ(describe({model, friction::default_theta(model)}),
            "gms, 4 elements, with load, ripple and asymmetry; coulomb_viscous");
}

}  // namespace
}  // namespace fricid::film
