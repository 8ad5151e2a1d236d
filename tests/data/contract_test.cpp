#include "fricid/data/contract.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <numbers>

#include "fricid/data/log_part.hpp"
#include "fricid/data/log_reader.hpp"
#include "import_fixture.hpp"
#include "source_dir.hpp"

namespace fricid::data {
namespace {

using testing::ElementsAre;
using testing::StartsWith;

constexpr double kDegree = std::numbers::pi / 180;

// Reference: the torque is 100 t two and a half samples late; one sample is lost at 40 ms.
TEST_F(Import, AKnownDelayOfTheTorqueIsTakenOut) {
  std::string log = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 20; ++k)
    if (k != 10) log += fmt::format("{},{},0,{},1\n", 0.004 * k, k, 0.4 * (k - 2.5));
  for (const double sign : {1.0, -1.0}) {
    const Dataset d = read_log(write("log.csv", log),
                               contract(kContract + fmt::format("delay_s = {}\n", sign * 0.01)));
    EXPECT_EQ(d.length(), 16);
    EXPECT_EQ(d.q(0, 0), sign > 0 ? 0 : 3);
    EXPECT_EQ(d.t[0], 0);
    int missing = 0;
    for (int k = 0; k < d.length(); ++k) {
      if (std::isnan(d.tau(k, 0)))
        ++missing;
      else
        EXPECT_NEAR(d.tau(k, 0), 0.4 * (d.q(k, 0) - (sign > 0 ? 0 : 5)), 1e-12) << k;
    }
    EXPECT_EQ(missing, 2);
    EXPECT_THAT(d.source, testing::HasSubstr("moved back"));
  }
  // a clock that begins again leaves the last row without a later one
  const std::string again =
      "t,q1,q2,tau1,tau2\n0,0,0,0,1\n0.004,1,0,1,1\n0.008,2,0,2,1\n0,3,0,3,1\n";
  EXPECT_EQ(
      read_log(write("log.csv", again), contract(kContract + std::string("delay_s = 0.004\n")))
          .length(),
      3);
  EXPECT_THAT(log_error(kLog, std::string(kContract) + "delay_s = 0.5\n"),
              testing::HasSubstr("delay_s = 0.5 of a log of 0.012 s"));
}

// Reference: the mean of t^2 and of t^3 over an interval; cubic curves have it exactly.
TEST_F(Import, TorqueMeasuredAtItsSamplesIsHeldBetweenThem) {
  std::string log = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 12; ++k)
    log += fmt::format("{},{},0,{},{}\n", 0.004 * k, k, k * k,
                       k == 6 ? "" : std::to_string(k * k * k));
  const auto read = [&](const char* timing) {
    return read_log(write("log.csv", log),
                    contract(kContract + fmt::format("timing = \"{}\"\n", timing)));
  };
  const Dataset held = read("held"), measured = read("measured");
  EXPECT_EQ(held.length(), 12);
  EXPECT_EQ(held.tau(3, 0), 9);
  ASSERT_EQ(measured.length(), 11);
  EXPECT_THAT(measured.source, testing::HasSubstr("measured at its samples"));
  for (int k = 1; k < 10; ++k) EXPECT_NEAR(measured.tau(k, 0), k * k + k + 1. / 3, 1e-12) << k;
  for (const int k : {1, 2, 3, 8, 9}) {
    const double end = k + 1;
    EXPECT_NEAR(measured.tau(k, 1), (end * end * end * end - k * k * k * k) / 4, 1e-9) << k;
  }
  EXPECT_EQ(measured.tau(4, 1), (4 * 4 * 4 + 5 * 5 * 5) / 2.);  // beside a gap: the straight line
  EXPECT_TRUE(std::isnan(measured.tau(5, 1)) && std::isnan(measured.tau(6, 1)));
}

// Held or measured half a sample later, as likely where the contract leaves it open: kept in files.
TEST_F(Import, WhatIsNotKnownOfTheTimingOfATorqueIsKept) {
  const auto unknown = [&](const std::string& line) {
    return read_log(write("log.csv", kLog), contract(kContract + line)).torque_delay_sd;
  };
  const double half_a_sample = 0.5 / import(kLog).rate_hz;
  EXPECT_NEAR(unknown(""), half_a_sample * std::sqrt(0.5), 1e-15);
  for (const char* known : {"timing = \"held\"\n", "timing = \"measured\"\n", "delay_s = 0.004\n"})
    EXPECT_EQ(unknown(known), 0) << known;
  const Dataset read = import(kLog);
  const std::filesystem::path file =
      std::filesystem::path(write("log.csv", kLog)).parent_path() / "log.h5";
  save_dataset(read, file);
  EXPECT_EQ(load_dataset(file).torque_delay_sd, read.torque_delay_sd);
  EXPECT_EQ(rows_of(read, 1, 2).torque_delay_sd, read.torque_delay_sd);
}

TEST_F(Import, ReadsColumnsByPattern) {
  const Dataset d = import(kLog);
  EXPECT_EQ(d.name, "log");
  EXPECT_EQ(d.source, "import log.csv");
  EXPECT_THAT(d.joint_names, ElementsAre("shoulder", "elbow"));
  EXPECT_EQ(d.rate_hz, 250);
  EXPECT_EQ(d.length(), 4);
  EXPECT_EQ(d.t[0], 0);
  EXPECT_NEAR(d.t[3], 0.012, 1e-12);
  EXPECT_EQ(d.q(2, 0), 0.12);
  EXPECT_EQ(d.q(2, 1), 0.22);
  EXPECT_EQ(d.tau(2, 0), -10);
  EXPECT_EQ(d.tau(2, 1), 3);
  EXPECT_EQ(d.v.size(), 0);
  EXPECT_EQ(d.temperature.size(), 0);
}

// The same numbers written in the ways that loggers and spreadsheets write them.
TEST_F(Import, SeparatorsLineEndsAndDecimalCommas) {
  const Dataset expected = import(kLog);
  const auto with = [](std::string text, char from, const std::string& to) {
    std::string result;
    for (const char c : text) result += c == from ? to : std::string(1, c);
    return result;
  };
  const auto same = [&](const std::string& log, const std::string& text = kContract) {
    const Dataset d = import(log, text);
    return d.q == expected.q && d.tau == expected.tau && d.t == expected.t;
  };
  EXPECT_TRUE(same(with(kLog, ',', ";")));
  EXPECT_TRUE(same(with(kLog, ',', "\t")));
  EXPECT_TRUE(same(with(kLog, ',', "   ")));
  EXPECT_TRUE(same(with(kLog, ',', " , ")));
  EXPECT_TRUE(same(with(kLog, '\n', "\r\n")));
  EXPECT_TRUE(same("\xEF\xBB\xBF# made by a logger\n\n" + std::string(kLog) + "\n# end\n"));
  EXPECT_TRUE(same(with(kLog, '\n', ",\n")));
  EXPECT_TRUE(same(replaced(kLog, "t,q1", "\"t\",\"q1\"")));
  EXPECT_TRUE(same(replaced(kLog, "note\n", "note\ns,rad,rad,Nm,Nm,-\n")));  // a row of units
  EXPECT_TRUE(same(replaced(kLog, "q1,q2", "Q1,Q2")));
  EXPECT_TRUE(same(with(with(kLog, ',', ";"), '.', ","),
                   std::string("decimal_comma = true\n") + kContract));
  EXPECT_TRUE(same(kLog, std::string("separator = \"comma\"\n") + kContract));
  // cells in quotes, as R and pandas write them: separators are part of them
  const auto quoted = [&](const std::string& separator, char point) {
    std::string cells = with(with(kLog, ',', "\"|\""), '\n', "\"\n\"");
    return with(with("\"" + cells.substr(0, cells.size() - 1), '.', std::string(1, point)), '|',
                separator);
  };
  EXPECT_TRUE(same(quoted(" ", '.')));
  EXPECT_TRUE(same(quoted(",", ','), std::string("decimal_comma = true\n") + kContract));
  std::string tabs = "\"id\"\t";  // a cell that is empty before one in quotes
  for (const char c : quoted("\t", '.'))
    tabs += c == '\n' ? std::string("\n\t") : std::string(1, c);
  tabs.pop_back();
  EXPECT_TRUE(same(tabs));
  EXPECT_EQ(log_error(with(kLog, '\n', "\r")),
            "log.csv: lines end with CR alone; allowed: with LF or CR LF");
}

TEST_F(Import, ARowOfUnitsIsHeldAgainstTheContract) {
  const auto below = [](const char* units) {
    return replaced(kLog, "note\n", fmt::format("note\n{}\n", units));
  };
  for (const char* units : {"s,rad,rad,Nm,Nm,-", "# s,rad,rad,Nm,Nm,-",
                            "[s],[rad],[rad],[N m],[N*m],[1]", "sec,m,radians,N.m,?,words"})
    EXPECT_EQ(import(below(units)).length(), 4) << units;
  const std::string values = std::string(kLog).substr(std::string(kLog).find('\n') + 1);
  EXPECT_EQ(import("# t,q1,q2,tau1,tau2,note\n# s,rad,rad,Nm,Nm,-\n" + values).length(), 4);
  const auto error = [&](const char* units) { return log_error(below(units)); };
  EXPECT_EQ(error("s,rad,deg,Nm,Nm,-"),
            "log.csv:2: the row of units has \"deg\" for q2; the contract says otherwise: unit = "
            "\"deg\" in [position]; where the row is wrong, leave it out");
  EXPECT_THAT(error("# s,rad,\u00B0,Nm,Nm,-"), testing::HasSubstr("unit = \"deg\" in [position]"));
  EXPECT_THAT(error("us,rad,rad,Nm,Nm,-"), testing::HasSubstr("unit = \"us\" in [time]"));
  EXPECT_THAT(error("s,rad,mm,Nm,Nm,-"), testing::HasSubstr("scale = 0.001 in [position]"));
  EXPECT_THAT(error("s,rad,rad,Nm,mNm,-"), testing::HasSubstr("scale = 0.001 in [torque]"));
  EXPECT_EQ(import(below("s,deg,deg,Nmm,Nmm,-"),
                   replaced(kContract, "\"q{}\"", "\"q{}\"\nunit = \"deg\"") + "scale = 0.001\n")
                .tau(3, 1),
            0.004);
}

TEST_F(Import, HeadersThatDifferInLetterCaseAreToldApart) {
  EXPECT_EQ(import(replaced(kLog, "note", "Q1")).q(1, 0), 0.11);
  EXPECT_EQ(log_error(replaced(replaced(kLog, "note", "TAU1"), "tau1", "Tau1")),
            "log.csv:1: column \"tau1\" may be \"Tau1\" or \"TAU1\"; allowed: the name in its own "
            "letter case");
  EXPECT_EQ(log_error(kLog, replaced(kContract, "\"q{}\"", "[\"q1\", \"Q1\"]")),
            "log.csv:1: \"q1\" and \"Q1\" of the contract are both column \"q1\"");
}

// Oracle: the formulas of the header, by hand.
TEST_F(Import, UnitsSignsGearsAndOffsets) {
  const Dataset d = import(
      "Time;A1;A2;w1;w2;I1;I2;T1;T2\n"
      "0;90;-180;10;20;1;2;25;26\n"
      "4;91;-170;10;20;3;4;25;27\n",
      R"(joint_names = ["shoulder", "elbow"]
gear_ratio = [100, 50]
[time]
column = "Time"
unit = "ms"
[position]
columns = ["A1", "A2"]
unit = "deg"
sign = [1, -1]
offset_rad = [0.5, 0]
[velocity]
columns = "w{}"
unit = "motor_deg"
sign = -1
[torque]
columns = "I{}"
kind = "current"
torque_constant = [0.2, 0.1]
sign = [-1, 1]
[temperature]
columns = "T{}"
unit = "C"
)");
  EXPECT_EQ(d.rate_hz, 250);
  EXPECT_NEAR(d.q(0, 0), 90 * kDegree + 0.5, 1e-15);
  EXPECT_NEAR(d.q(1, 1), 170 * kDegree, 1e-15);
  EXPECT_NEAR(d.v(0, 0), -10 * kDegree / 100, 1e-15);
  EXPECT_NEAR(d.v(1, 1), -20 * kDegree / 50, 1e-15);
  EXPECT_NEAR(d.tau(1, 0), -3 * 0.2 * 100, 1e-12);
  EXPECT_NEAR(d.tau(1, 1), 4 * 0.1 * 50, 1e-12);
  EXPECT_NEAR(d.temperature(1, 1), 27 + 273.15, 1e-12);
}

TEST_F(Import, MotorTorqueGoesThroughTheGear) {
  const std::string text = replaced(kContract, "[torque]\n", "[torque]\nkind = \"motor_torque\"\n");
  const Dataset d = import(kLog, "gear_ratio = [100, 50]\n" + text);
  EXPECT_EQ(d.tau(1, 0), 150);
  EXPECT_EQ(d.tau(1, 1), 125);
}

TEST_F(Import, EmptyCellsAreMissingValues) {
  const Dataset d = import(replaced(replaced(kLog, "0.11,", ","), "1.5", "nan"));
  EXPECT_TRUE(std::isnan(d.q(1, 0)));
  EXPECT_TRUE(std::isnan(d.tau(1, 0)));
  EXPECT_EQ(d.q(1, 1), 0.21);
}

TEST_F(Import, WordsForMissingValues) {
  for (const char* word : {"null", "NULL", "None", "NaN", "nan"}) {
    const Dataset d = import(replaced(kLog, "0.11,", std::string(word) + ","));
    EXPECT_TRUE(std::isnan(d.q(1, 0))) << word;
    EXPECT_EQ(d.q(1, 1), 0.21) << word;
  }
  EXPECT_EQ(log_error(replaced(kLog, "0.11,", "-,")),
            std::string("log.csv:3: q1 = \"-\"; allowed: a number") + kOrMissing);
}

// As numpy.savetxt writes it.
TEST_F(Import, ACommentAboveTheNumbersIsTheHeader) {
  const Dataset expected = import(kLog);
  for (const char* mark : {"#", "# ", "## "}) {
    const Dataset d = import(std::string("# of today\n") + mark + kLog);
    EXPECT_EQ(d.t, expected.t) << mark;
    EXPECT_EQ(d.q, expected.q) << mark;
    EXPECT_EQ(d.tau, expected.tau) << mark;
  }
  EXPECT_EQ(import(std::string("# a,b,c,d,e,f\n") + kLog).q, expected.q);
  EXPECT_EQ(log_error(std::string("# ") + replaced(kLog, "0.21", "O.21")),
            std::string("log.csv:3: q2 = \"O.21\"; allowed: a number") + kOrMissing);
  EXPECT_EQ(log_error(std::string("# ") + replaced(kLog, "tau2", "tau_2")),
            "log.csv:1: no column \"tau2\"; nearest: \"tau1\"");
}

TEST_F(Import, ALogWithoutHeaderIsToldSo) {
  const std::string numbers = std::string(kLog).substr(std::string(kLog).find('\n') + 1);
  for (const std::string& above : {std::string(), std::string("# no names\n")})
    EXPECT_EQ(log_error(above + numbers),
              fmt::format("log.csv:{}: no column \"t\"; this line is taken for the header and "
                          "holds numbers; allowed: a line of names above the numbers, with or "
                          "without #",
                          above.empty() ? 1 : 2));
}

TEST_F(Import, RateIsWholeDespiteRoundedTimes) {
  std::string log = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 100; ++k) {
    char line[64];
    std::snprintf(line, sizeof line, "%.4f,%d,0,0,0\n", k / 1200.0, k % 3);
    log += line;
  }
  EXPECT_EQ(message_of([&] { import(log); }).substr(0, 30), "log.csv:3: jitter in time: 0.0");
  log = "t,q1,q2,tau1,tau2\n";
  for (int k = 0; k < 100; ++k) {
    char line[64];
    std::snprintf(line, sizeof line, "%.7f,%d,0,0,0\n", k / 1200.0, k % 3);
    log += line;
  }
  EXPECT_EQ(import(log).rate_hz, 1200);
}

TEST_F(Import, GapInTime) {
  EXPECT_EQ(log_error(replaced(kLog, "5.012", "5.016")),
            "log.csv:5: gap in time: 0.008 s after the sample before; allowed: 0.004 s within 1 %; "
            "`fricid check` lists what `fricid import --fix` repairs");
}

TEST_F(Import, TimeThatDoesNotRise) {
  const std::string remedy = "; `fricid check` lists what `fricid import --fix` repairs";
  EXPECT_EQ(log_error(replaced(kLog, "5.008", "5.001")),
            "log.csv:4: t = 0.001 s after 0.004 s; allowed: rising times" + remedy);
  EXPECT_EQ(log_error(replaced(kLog, "5.008", "5.004")),
            "log.csv:4: t = 0.004 s after 0.004 s; allowed: rising times" + remedy);
  EXPECT_EQ(log_error(replaced(kLog, "5.008", "")), "log.csv:4: t = nan; allowed: a finite time");
}

TEST_F(Import, Cells) {
  EXPECT_EQ(log_error(replaced(kLog, "0.21", "O.21")),
            std::string("log.csv:3: q2 = \"O.21\"; allowed: a number") + kOrMissing);
  EXPECT_EQ(log_error(replaced(kLog, "0.21", "0.21 rad")),
            std::string("log.csv:3: q2 = \"0.21 rad\"; allowed: a number") + kOrMissing);
  EXPECT_EQ(log_error(replaced(kLog, "0.21", "inf")),
            "log.csv:3: q2 = inf; allowed: finite, or nan where missing");
  EXPECT_EQ(log_error(replaced(kLog, "0.21,", "")),
            "log.csv:3: 5 cells; allowed: 6, as in the header");
  EXPECT_EQ(log_error(std::string(kLog) + "5.016,1"),
            "log.csv:6: 2 cells; allowed: 6, as in the header");
}

TEST_F(Import, Columns) {
  EXPECT_EQ(log_error(replaced(kLog, "tau2", "tau_2")),
            "log.csv:1: no column \"tau2\"; nearest: \"tau1\"");
  EXPECT_EQ(log_error(replaced(kLog, "t,q1", "when,q1")),
            "log.csv:1: no column \"t\"; found: when, q1, q2, tau1, tau2, note");
  EXPECT_EQ(log_error(replaced(kLog, "note", "q1")), "log.csv:1: column \"q1\" appears twice");
}

TEST_F(Import, RowsAboveTheHeaderAreSkipped) {
  const std::string above = "Robot;KR 6, \"R700\"\n\n# operator\nt\n", five = above + "a,b,c\n";
  const auto skipping = [](int rows) {
    return fmt::format("skip_rows = {}\n", rows) + std::string(kContract);
  };
  const Dataset expected = import(kLog);
  const Dataset d = import(five + kLog, skipping(5));
  EXPECT_EQ(d.q, expected.q);
  EXPECT_EQ(d.tau, expected.tau);
  EXPECT_EQ(log_error(five + replaced(kLog, "0.21", "O.21"), skipping(5)),
            std::string("log.csv:8: q2 = \"O.21\"; allowed: a number") + kOrMissing);
  EXPECT_EQ(log_error(five + kLog),
            "log.csv:1: no column \"t\"; found: Robot, KR 6, \"R700\"; line 6 has all columns: "
            "skip_rows = 5 in the contract");
  EXPECT_THAT(log_error(five + kLog, skipping(4)),
              testing::EndsWith("; line 6 has all columns: skip_rows = 5 in the contract"));
  EXPECT_THAT(log_error(kLog, skipping(1)),
              testing::EndsWith("; line 1 has all columns: skip_rows = 0 in the contract"));
  EXPECT_EQ(log_error(kLog, skipping(9)), "log.csv: no header after skip_rows = 9 lines");
  EXPECT_EQ(contract_error(skipping(-1)),
            "contract.toml:1: skip_rows = -1; allowed: a whole number from 0 to 10000");
}

TEST_F(Import, SkippedRowsNeedAHeader) {
  EXPECT_EQ(log_error("<Rob Type=\"KUKA\"></Rob>", "skip_rows = 2\n" + std::string(kContract)),
            "log.csv: KUKA RSI packets (XML): skip_rows = 2 in the contract; allowed: 0, there is "
            "no header");
}

// A recording of a Universal Robots arm is known by its header, wherever that stands.
TEST_F(Import, FormatsAreKnownBelowSkippedRows) {
  const auto log = write("log.csv", "made by a recorder\ntimestamp actual_q_0 actual_current_0\n");
  EXPECT_EQ(reader_for(log, "auto", 1).name, "ur_csv");
  EXPECT_EQ(reader_for(log, "auto").name, "csv");
}

TEST_F(Import, TimesOfAnotherUnitAreNamed) {
  const auto at = [](double factor) {
    std::string log = "t,q1,q2,tau1,tau2\n";
    for (int k = 0; k < 4; ++k) log += fmt::format("{:.9g},0,0,0,0\n", 7 + 4 * k * factor);
    return log;
  };
  const auto in = [](const char* unit) {
    return std::string(kContract) + "[time]\nunit = \"" + unit + "\"\n";
  };
  const std::pair<double, const char*> units[]{{1e-3, "s"}, {1, "ms"}, {1e3, "us"}, {1e6, "ns"}};
  for (const auto& [factor, unit] : units) {
    EXPECT_EQ(import(at(factor), in(unit)).rate_hz, 250) << unit;
    for (const auto& [other, said] : units) {
      if (said == std::string(unit)) continue;
      EXPECT_THAT(log_error(at(factor), in(said)),
                  testing::EndsWith(fmt::format(
                      "; if t is in {0}, say [time] unit = \"{0}\" in the contract", unit)))
          << unit << " said to be in " << said;
    }
  }
}

TEST_F(Import, Files) {
  EXPECT_EQ(log_error(""), "log.csv: an empty file");
  EXPECT_EQ(log_error("\n\n# nothing\n"), "log.csv: an empty file");
  EXPECT_EQ(log_error("t,q1,q2,tau1,tau2\n"), "log.csv: 0 rows of numbers; allowed: at least 2");
  EXPECT_EQ(log_error(std::string("t,q1\0,q2", 8)), "log.csv: not a text file");
  std::string little, big;
  for (const char c : std::string(kLog)) {
    little += {c, '\0'};
    big += {'\0', c};
  }
  for (const std::string& text : {little, big, "\xFF\xFE" + little, "\xFE\xFF" + big})
    EXPECT_EQ(log_error(text), "log.csv: text in UTF-16; allowed: saved as UTF-8");
  EXPECT_EQ(message_of([&] { import_log(path("none.csv"), contract()); }),
            "none.csv: cannot be read: No such file or directory");
  EXPECT_THAT(message_of([&] { import_log(folder, contract()); }), testing::HasSubstr("folder"));
}

TEST_F(Import, DegreesWarn) {
  const Dataset d = import(replaced(kLog, "0.13", "13"));
  EXPECT_THAT(
      check_dataset(d, "log.csv"),
      ElementsAre("log.csv: |q| of shoulder reaches 13, more than 4 pi: degrees, or millimetres?"));
}

TEST_F(Import, WrongJointCount) {
  EXPECT_EQ(contract_error(replaced(kContract, "\"q{}\"", "[\"q1\", \"q2\", \"q3\"]")),
            "contract.toml:3: position.columns names 3 columns; allowed: 2, one per joint, or one "
            "pattern with {}");
  EXPECT_EQ(
      contract_error(std::string("gear_ratio = [1, 2, 3]\n") + kContract),
      "contract.toml:1: gear_ratio = an array of 3; allowed: a number from 0.001 to 100000, or "
      "an array of them for the 2 joints");
}

TEST_F(Import, ContractMistakes) {
  EXPECT_EQ(contract_error(std::string("seperator = \"tab\"\n") + kContract),
            "contract.toml:1: unknown key seperator; nearest known key: separator");
  EXPECT_EQ(contract_error("[position]\ncolumns = \"q{}\"\n"),
            "contract.toml: joint_names is missing: joints of the robot");
  EXPECT_EQ(
      contract_error(replaced(kContract, "columns = \"q{}\"\n", "")),
      "contract.toml:2: position.columns names 0 columns; allowed: 2, one per joint, or one "
      "pattern with {}; or none with format = \"...\", one of mcap db3 hdf5 mat kuka_trace rsi_xml "
      "rsi_csv ur_csv franka_csv");
  EXPECT_EQ(contract_error(replaced(kContract, "[torque]\n", "[torque]\nkind = \"current\"\n")),
            "contract.toml:5: gear_ratio is missing; torque.kind = \"current\" needs it");
  EXPECT_EQ(contract_error("gear_ratio = 100\n" +
                           replaced(kContract, "[torque]\n", "[torque]\nkind = \"current\"\n")),
            "contract.toml:6: torque.torque_constant is missing; torque.kind = \"current\" needs "
            "it");
  EXPECT_EQ(contract_error(replaced(kContract, "[torque]\n", "unit = \"motor_deg\"\n[torque]\n")),
            "contract.toml:4: gear_ratio is missing; position.unit = \"motor_deg\" needs it");
  EXPECT_EQ(contract_error(replaced(kContract, "[torque]\n", "sign = 0.5\n[torque]\n")),
            "contract.toml:4: position.sign has 0.5; allowed: 1 or -1");
  EXPECT_EQ(
      contract_error("decimal_comma = true\nseparator = \"comma\"\n" + std::string(kContract)),
      "contract.toml:2: separator = \"comma\"; allowed: another one with decimal_comma");
}

TEST_F(Import, AColumnIsOneSignalOfOneJoint) {
  EXPECT_EQ(contract_error(replaced(kContract, "\"q{}\"", "[\"q1\", \"q1\"]")),
            "contract.toml:3: column \"q1\" is position of joint elbow and position of joint "
            "shoulder (contract.toml:3); allowed: a column of its own for each");
  EXPECT_EQ(contract_error(replaced(kContract, "\"tau{}\"", "[\"tau1\", \"q1\"]")),
            "contract.toml:5: column \"q1\" is torque of joint elbow and position of joint "
            "shoulder (contract.toml:3); allowed: a column of its own for each");
  EXPECT_THAT(contract_error(std::string(kContract) + "[velocity]\ncolumns = \"tau{}\"\n"),
              StartsWith("contract.toml:7: column \"tau1\" is velocity of joint shoulder"));
  const Contract shared =
      contract(std::string(kContract) + "[temperature]\ncolumns = [\"T\", \"T\"]\n");
  EXPECT_THAT(shared.temperature.columns, ElementsAre("T", "T"));
}

TEST_F(Import, AJointIsNamedOnce) {
  EXPECT_EQ(contract_error(replaced(kContract, "\"elbow\"", "\"shoulder\"")),
            "contract.toml:1: joint_names has \"shoulder\" twice; allowed: every joint once");
}

TEST_F(Import, ANegativeGearRatioIsASign) {
  for (const char* ratio : {"-50", "[100, -50]"})
    EXPECT_EQ(contract_error(fmt::format("gear_ratio = {}\n", ratio) + kContract),
              "contract.toml:1: gear_ratio has -50; allowed: its size, and sign = -1 for this "
              "joint in each of [position], [velocity] and [torque] that is measured at the motor");
}

TEST_F(Import, TemplateIsAContract) {
  const Contract c = contract(contract_template());
  EXPECT_EQ(c.n(), 6);
  EXPECT_THAT(c.position.columns, ElementsAre("q1", "q2", "q3", "q4", "q5", "q6"));
  EXPECT_EQ(c.torque.kind, "joint_torque");
}

TEST(SampleLog, Imports) {
  const std::filesystem::path folder = source_dir() / "tests/data";
  const Dataset d =
      import_log(folder / "sample_log.csv", load_contract(folder / "sample_contract.toml"));
  EXPECT_EQ(d.rate_hz, 250);
  EXPECT_EQ(d.n(), 2);
  EXPECT_TRUE(check_dataset(d, "sample").empty());
}

// The log itself is not part of this project: FRICID_REALLOGS names the folder that holds it.
TEST(KukaLog, Imports) {
  const char* logs = std::getenv("FRICID_REALLOGS");
  if (!logs) GTEST_SKIP() << "FRICID_REALLOGS is not set";
  const Contract contract = load_contract(source_dir() / "scenes/kuka_kr300_contract.toml");
  const Dataset d =
      import_log(std::filesystem::path(logs) / "kuka_kr300_2020" / "trajA_train.csv", contract);
  EXPECT_EQ(d.length(), 2501);
  EXPECT_EQ(d.n(), 6);
  EXPECT_EQ(d.rate_hz, 250);
  EXPECT_EQ(d.tau(0, 0), 538.9044);
  EXPECT_EQ(d.v.rows(), 2501);
  EXPECT_TRUE(check_dataset(d, "trajA").empty());
}

// A ROS 2 bag of a real arm, from the same folder.
TEST(Ur10Bag, Imports) {
  const char* logs = std::getenv("FRICID_REALLOGS");
  if (!logs) GTEST_SKIP() << "FRICID_REALLOGS is not set";
  Contract contract = load_contract(source_dir() / "scenes/ur10_contract.toml");
  const Dataset d = read_log(
      std::filesystem::path(logs) / "ur10_unisa_2025/ur10_exciting_trajectory.db3", contract);
  EXPECT_EQ(d.length(), 3441);
  EXPECT_EQ(d.n(), 6);
  EXPECT_NEAR(d.rate_hz, 125, 0.5);
  EXPECT_EQ(d.v.rows(), 3441);
  EXPECT_TRUE(check_dataset(d, "ur10").empty());
}

}  // namespace
}  // namespace fricid::data
