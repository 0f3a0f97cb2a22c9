#include "io/output_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "error.h"
#include "io/text_file.h"

namespace trunnion {
namespace {

namespace fs = std::filesystem;

class OutputFileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "trunnion-output-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const char* name) const { return (folder_ / name).string(); }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  fs::path folder_;
};

TEST_F(OutputFileTest, AppearsOnCommitAndNotBefore) {
  OutputFile file(path("out"), {});
  file.append("whole");
  EXPECT_FALSE(fs::exists(path("out")));
  file.commit();
  EXPECT_EQ(read_text(path("out")), "whole");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(OutputFileTest, LeavesNothingWithoutCommitAndTheOldFileAsItWas) {
  write_whole(path("out"), "old", {});
  { OutputFile(path("out"), {}).append(std::string(std::size_t{3} << 20, 'x')); }
  EXPECT_EQ(read_text(path("out")), "old");
  EXPECT_EQ(entries(), 1u);
}

TEST_F(OutputFileTest, NeverOverwritesAnInputWhateverItIsCalled) {
  write_whole(path("in"), "input", {});
  fs::create_symlink(path("in"), path("soft"));
  fs::create_hard_link(path("in"), path("hard"));
  for (const char* name : {"in", "soft", "hard", "../in"}) {
    const std::string output = std::string(name) == "../in" ? path("x/../in") : path(name);
    fs::create_directory(path("x"));
    EXPECT_THROW(write_whole(output, "lost", {path("in")}), UsageError) << name;
  }
  EXPECT_EQ(read_text(path("in")), "input");
}

TEST_F(OutputFileTest, FollowsALinkAndKeepsTheModeOfWhatItReplaces) {
  write_whole(path("target"), "old", {});
  ASSERT_EQ(::chmod(path("target").c_str(), 0640), 0);
  fs::create_symlink(path("target"), path("link"));
  write_whole(path("link"), "new", {});
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(read_text(path("target")), "new");
  struct stat info {};
  ASSERT_EQ(::stat(path("target").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0640u);
}

TEST_F(OutputFileTest, WritesToADeviceInsteadOfReplacingIt) {
  write_whole("/dev/null", "text", {});
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THROW(write_whole("/dev/full", "text", {}), InputError);
}

TEST_F(OutputFileTest, TakesTheUnfinishedAwayWhenItIsInterrupted) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    OutputFile file(path("out"), {});
    file.append(std::string(std::size_t{3} << 20, 'x'));
    std::raise(SIGTERM);
    ::_exit(0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM);
  EXPECT_EQ(entries(), 0u);
}

TEST_F(OutputFileTest, AFolderAppearsWithAllItsFilesOrNone) {
  OutputFolder good(path("tables"), {});
  good.add("a", "1");
  good.add("sub/b", "2");
  good.commit();
  EXPECT_EQ(read_text(path("tables/sub/b")), "2");
  write_whole(path("file"), "in the way", {});
  OutputFolder bad(path("other"), {path("file")});
  bad.add("a", "1");
  bad.add("none/too/deep", "2");
  EXPECT_THROW(bad.commit(), InputError);
  EXPECT_FALSE(fs::exists(path("other")));
}

}  // namespace
}  // namespace trunnion
