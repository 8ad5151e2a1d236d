// Atomic writing, hashes and locks, with failures forced at every step.
#include "fricid/base/files.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <set>
#include <stdexcept>
#include <thread>

#include "fricid/base/error.hpp"
#include "fricid/base/progress.hpp"
#include "fricid/base/rng.hpp"
#include "temporary_folder.hpp"

namespace fricid {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Files : public TemporaryFolder {
 protected:
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder)) found.insert(entry.path().filename());
    return found;
  }

  /// The message of the UserError that `action` must throw.
  template <class Action>
  static std::string user_error(Action action) {
    try {
      action();
    } catch (const UserError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no UserError";
    return {};
  }

  /// Exit code of `action`, run in a child; 1000 + signal when killed.
  template <class Action>
  static int in_child(Action action) {
    const pid_t child = ::fork();
    if (child == 0) {
      int code = 99;
      try {
        code = action();
      } catch (...) {
      }
      std::_Exit(code);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
};

TEST(RunningFile, IsTheProgram) {
  EXPECT_EQ(fs::canonical(running_file()), fs::canonical("/proc/self/exe"));
}

TEST_F(Files, WritesAndReadsBack) {
  const fs::path path = folder / "a" / "b" / "file.txt";  // parents are made
  const std::string text = std::string("line\nbinary \0 zero\n", 19) + std::string(200'000, 'x');
  write_file_atomically(path, text);
  EXPECT_EQ(read_file(path), text);
  write_file_atomically(path, "");
  EXPECT_EQ(read_file(path), "");
}

TEST_F(Files, ReplacesTheOldFileAndLeavesNothingElse) {
  write_file_atomically(folder / "file", "old");
  write_file_atomically(folder / "file", "new");
  EXPECT_EQ(read_file(folder / "file"), "new");
  EXPECT_EQ(names(), std::set<std::string>{"file"});
}

TEST_F(Files, RemovesWhatKilledWritersInTheFolderLeft) {
  const std::string ours = fmt::format(".a.txt.{}.7.fricid.tmp", ::getpid());
  const std::set<std::string> stay{ours, ".a.txt.2147483647.0.tmp", ".a.txt.tmp",
                                   ".a.99999999999.0.fricid.tmp"};
  for (const std::string& name : stay) std::ofstream(folder / name) << "half";
  // no process has this number
  for (const char* name : {".a.txt.2147483647.0.fricid.tmp", ".b.txt.2147483647.12.fricid.tmp"})
    std::ofstream(folder / name) << "half";
  write_file_atomically(folder / "a.txt", "whole");
  std::set<std::string> expected = stay;
  expected.insert("a.txt");
  EXPECT_EQ(names(), expected);
}

TEST_F(Files, WritesIntoTheCurrentFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(folder);
  write_file_atomically("bare_name", "text");
  fs::current_path(before);
  EXPECT_EQ(read_file(folder / "bare_name"), "text");
}

TEST_F(Files, TheTemporaryLiesInTheSameFolderAndTheOldFileIsThereMeanwhile) {
  const fs::path path = folder / "file";
  write_file_atomically(path, "old");
  write_file_atomically(path, [&](const fs::path& temporary) {
    EXPECT_EQ(temporary.parent_path(), folder);
    EXPECT_NE(temporary, path);
    std::ofstream(temporary) << "new";
    EXPECT_EQ(read_file(path), "old");
  });
  EXPECT_EQ(read_file(path), "new");
}

TEST_F(Files, AnExceptionOfTheWriterLeavesTheOldFile) {
  const fs::path path = folder / "file";
  write_file_atomically(path, "old");
  const auto failing = [](const fs::path& temporary) {
    std::ofstream(temporary) << "half";
    throw std::domain_error("writer");
  };
  EXPECT_THROW(write_file_atomically(path, failing), std::domain_error);
  EXPECT_EQ(read_file(path), "old");
  EXPECT_EQ(names(), std::set<std::string>{"file"});
}

TEST_F(Files, AWriterThatWritesNothingIsAnError) {
  EXPECT_THROW(write_file_atomically(folder / "file", [](const fs::path&) {}), UserError);
  EXPECT_TRUE(names().empty());
}

TEST_F(Files, AFolderInTheWay) {
  fs::create_directory(folder / "way");
  const std::string message = user_error([&] { write_file_atomically(folder / "way", "text"); });
  EXPECT_THAT(message, AllOf(HasSubstr((folder / "way").string()), HasSubstr("folder")));
  EXPECT_TRUE(fs::is_directory(folder / "way"));
  EXPECT_EQ(names(), std::set<std::string>{"way"});
}

TEST_F(Files, AFileWhereAParentFolderShouldBe) {
  write_file_atomically(folder / "file", "text");
  EXPECT_THAT(user_error([&] { write_file_atomically(folder / "file" / "below", "text"); }),
              HasSubstr((folder / "file").string()));
  EXPECT_EQ(read_file(folder / "file"), "text");
}

TEST_F(Files, NoPermission) {
  const int code = in_child([&] {
    // root may write anywhere, so stop being root
    constexpr uid_t kNobody = 65534;
    fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
    if (::geteuid() == 0 && ::setuid(kNobody) != 0) return 2;
    const std::string message = user_error([&] { write_file_atomically(folder / "file", "text"); });
    return message.ends_with("Permission denied") ? 0 : 1;
  });
  fs::permissions(folder, fs::perms::owner_all);
  EXPECT_EQ(code, 0);
  EXPECT_TRUE(names().empty());
}

/// /dev/null and the like must never be renamed over.
TEST_F(Files, SomethingThatIsNoRegularFile) {
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(user_error([&] { write_file_atomically(folder / "pipe", "text"); }),
              HasSubstr("regular file"));
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST_F(Files, ASymbolicLinkStaysOne) {
  write_file_atomically(folder / "target", "old");
  fs::create_symlink("target", folder / "link");
  write_file_atomically(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_file(folder / "target"), "new");
}

/// No room: a limit on the size of files stands for the full disk, write() fails the same way half
/// way through.
TEST_F(Files, AFullDiskLeavesTheOldFile) {
  const fs::path path = folder / "file";
  write_file_atomically(path, "old");
  const int code = in_child([&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {100'000, 100'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const std::string message =
        user_error([&] { write_file_atomically(path, std::string(1'000'000, 'x')); });
    return message.starts_with(path.string() + ": ") ? 0 : 1;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(read_file(path), "old");
  EXPECT_EQ(names(), std::set<std::string>{"file"});
}

TEST_F(Files, ThreadsMayWriteTheSameFile) {
  const std::string texts[] = {std::string(50'000, 'a'), std::string(80'000, 'b')};
  {
    std::vector<std::jthread> threads;
    for (const std::string& text : texts)
      threads.emplace_back([&] {
        for (int i = 0; i < 20; ++i) write_file_atomically(folder / "file", text);
      });
  }
  const std::string found = read_file(folder / "file");
  EXPECT_TRUE(found == texts[0] || found == texts[1]);
  EXPECT_EQ(names(), std::set<std::string>{"file"});
}

/// Version k of a file: its size and every byte tell k.
std::string version(int k) {
  return std::string(static_cast<std::size_t>(100'000 + 1000 * (k % 7)),
                     static_cast<char>('a' + k % 7));
}

/// Killed at 200 random moments, the writer always leaves one whole version, and at some of them a
/// temporary, which shows that the kills fell into the writing.
TEST_F(Files, KillingTheWriterLeavesOneWholeVersion) {
  const fs::path path = folder / "file";
  write_file_atomically(path, version(0));
  Rng rng(11, 0);
  std::set<std::string> seen;
  bool interrupted = false;
  // on a busy machine a child may be killed before it writes
  for (int repetition = 0; repetition < 200 || (seen.size() <= 3 && repetition < 4000);
       ++repetition) {
    const pid_t child = ::fork();
    if (child == 0) {
      for (int k = repetition;; ++k) write_file_atomically(path, version(k));
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(4e-3 * rng.uniform()));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));

    const std::string found = read_file(path);
    ASSERT_FALSE(found.empty());
    ASSERT_EQ(found, version(found[0] - 'a'));
    seen.insert(found.substr(0, 1));
    for (const std::string& name : names()) {
      if (name == "file") continue;
      EXPECT_TRUE(name.starts_with(".file.") && name.ends_with(".fricid.tmp")) << name;
      interrupted = true;
      fs::remove(folder / name);
    }
  }
  EXPECT_GT(seen.size(), 3u);
  EXPECT_TRUE(interrupted);
}

TEST_F(Files, RemovesWhatKilledWritersLeftAndNothingElse) {
  fs::create_directories(folder / "data");
  for (const char* name : {".a.h5.12.0.fricid.tmp", "data/.train_0.h5.4711.13.fricid.tmp", "a.h5",
                           "data/b.12.0.fricid.tmp", "data/.hidden.tmp", "data/.lock"})
    std::ofstream(folder / name) << "x";
  remove_left_temporaries(folder);
  EXPECT_EQ(names(), (std::set<std::string>{"a.h5", "data"}));
  std::set<std::string> data;
  for (const auto& entry : fs::directory_iterator(folder / "data"))
    data.insert(entry.path().filename());
  EXPECT_EQ(data, (std::set<std::string>{"b.12.0.fricid.tmp", ".hidden.tmp", ".lock"}));
  EXPECT_NO_THROW(remove_left_temporaries(folder / "missing"));
}

TEST_F(Files, ReadingWhatIsNotAReadableFile) {
  EXPECT_THAT(user_error([&] { read_file(folder / "missing"); }),
              AllOf(HasSubstr((folder / "missing").string()), HasSubstr("No such file")));
  EXPECT_THAT(user_error([&] { read_file(folder); }), HasSubstr("folder"));
  EXPECT_THAT(user_error([&] { sha256_of_file(folder / "missing"); }), HasSubstr("missing"));
}

TEST_F(Files, DevicesAndPipesAreNoRegularFiles) {
  const fs::path pipe = folder / "pipe", loop = folder / "loop";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink(loop, loop);
  for (const fs::path& path : {pipe, fs::path("/dev/zero")})
    EXPECT_EQ(user_error([&] { require_regular_file(path); }),
              path.string() + ": is not a regular file");
  EXPECT_THAT(user_error([&] { require_regular_file(folder); }), HasSubstr("is a folder"));
  EXPECT_THAT(user_error([&] { require_regular_file(folder / "none"); }),
              HasSubstr("No such file"));
  EXPECT_THAT(user_error([&] { require_regular_file(loop); }), HasSubstr("symbolic links"));
  write_file_atomically(folder / "file", "");
  EXPECT_NO_THROW(require_regular_file(folder / "file"));
}

TEST_F(Files, APipeIsReadToItsEnd) {
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] {
    std::ofstream out(pipe);
    out << "a" << std::flush;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    out << "b";
  });
  EXPECT_EQ(read_file(pipe), "ab");
  writer.join();
}

TEST_F(Files, ARequestToStopEndsTheWaitForAPipe) {
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(in_child([&]() -> int {
              install_stop_handler();
              std::raise(SIGTERM);
              ::alarm(20);
              try {
                read_file(pipe);
              } catch (const Stopped&) {
                return 0;
              }
              return 1;
            }),
            0);
}

/// FIPS 180-4 examples.
TEST_F(Files, Sha256KnownAnswers) {
  EXPECT_EQ(sha256_of_text(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of_text("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const std::string million(1'000'000, 'a');
  const std::string expected = "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0";
  EXPECT_EQ(sha256_of_text(million), expected);
  write_file_atomically(folder / "million", million);
  EXPECT_EQ(sha256_of_file(folder / "million"), expected);
}

TEST_F(Files, TheSecondLockIsRefused) {
  const fs::path path = folder / "run" / ".lock";
  {
    const FileLock lock(path);
    const std::string message = user_error([&] { FileLock second(path); });
    EXPECT_THAT(message, AllOf(HasSubstr((folder / "run").string()), HasSubstr("another run"),
                               Not(HasSubstr("\n"))));
    EXPECT_EQ(in_child([&] {
                user_error([&] { FileLock second(path); });
                return ::testing::Test::HasFailure() ? 1 : 0;
              }),
              0);
  }
  const FileLock again(path);
}

TEST_F(Files, AKilledHolderSetsTheLockFree) {
  const fs::path path = folder / ".lock";
  EXPECT_EQ(in_child([&]() -> int {
              const FileLock lock(path);
              return std::raise(SIGKILL);
            }),
            1000 + SIGKILL);
  const FileLock lock(path);
}

/// Not even those that have not run yet when it is killed.
TEST_F(Files, ProcessesThatAKilledHolderForkedDoNotHoldItsLock) {
  const fs::path path = folder / ".lock";
  EXPECT_EQ(in_child([&]() -> int {
              const FileLock lock(path);
              for (int i = 0; i < 8; ++i)
                if (::fork() == 0) {
                  ::alarm(5);
                  ::pause();
                }
              EXPECT_THROW(FileLock second(path), UserError);  // forking did not set it free
              return std::raise(SIGKILL);
            }),
            1000 + SIGKILL);
  const FileLock lock(path);
}

}  // namespace
}  // namespace fricid
