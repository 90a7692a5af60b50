// The program record as a person calls it: sentences and exit codes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace copresence::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

struct Ended {
  std::optional<int> code;
  std::string words;
};

Ended record(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program("record"));
  Process process(arguments);
  const auto code = process.wait(seconds(20));
  return {code, process.output()};
}

std::string read_all(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

const std::string kWhole = recordings() / "camera0.oni";

TEST(RecordProgram, TellsWhatARecordingHolds) {
  const Ended table = record({"info", kWhole});
  EXPECT_EQ(table.code, 0) << table.words;
  EXPECT_THAT(table.words, HasSubstr("16zT"));
  const Ended json = record({"info", kWhole, "--json"});
  EXPECT_EQ(json.code, 0);
  EXPECT_EQ(nlohmann::json::parse(json.words)["streams"][0]["kind"], "depth");
}

TEST(RecordProgram, RepairsAndCuts) {
  TemporaryFolder folder;
  const std::string bytes = read_all(kWhole);
  std::ofstream(folder / "cut_off.oni", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const Ended before = record({"info", folder / "cut_off.oni"});
  EXPECT_EQ(before.code, 1);
  EXPECT_THAT(before.words, HasSubstr("record repair"));
  const Ended repaired = record({"repair", folder / "cut_off.oni"});
  EXPECT_EQ(repaired.code, 0) << repaired.words;
  EXPECT_THAT(repaired.words, HasSubstr("finished with"));
  EXPECT_EQ(record({"info", folder / "cut_off.oni"}).code, 0);
  const Ended cut = record({"cut", kWhole, "--from", "0.2", "--to", "0.5", "--out", folder / "part.oni"});
  EXPECT_EQ(cut.code, 0) << cut.words;
  const auto part = nlohmann::json::parse(record({"info", folder / "part.oni", "--json"}).words);
  EXPECT_NEAR(part["streams"][0]["frames"].get<int>(), 9, 1);
}

TEST(RecordProgram, LeavesNoPartOfAFileThatFindsNoRoom) {
  TemporaryFolder folder;
  const std::string out = folder / "part.oni";
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 1'000'000;
  setrlimit(RLIMIT_FSIZE, &small);
  const Ended cut = record({"cut", kWhole, "--out", out});
  const bool cut_is_there = std::filesystem::exists(out);
  const Ended repaired = record({"repair", kWhole, "--out", out});
  setrlimit(RLIMIT_FSIZE, &before);
  for (const Ended& ended : {cut, repaired}) {
    EXPECT_EQ(ended.code, 1);
    EXPECT_THAT(ended.words, HasSubstr("ulimit"));
  }
  EXPECT_FALSE(cut_is_there);
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(RecordProgram, LeavesNoFileBehindWhereNoFrameWasWhole) {
  TemporaryFolder folder;
  std::ofstream(folder / "early.oni", std::ios::binary) << read_all(kWhole).substr(0, 5000);
  const Ended repaired = record({"repair", folder / "early.oni", "--out", folder / "out.oni"});
  EXPECT_EQ(repaired.code, 1);
  EXPECT_THAT(repaired.words, HasSubstr("no depth frame"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out.oni"));
}

TEST(RecordProgram, KeepsAFileThatExistsUnlessToldToOverwriteIt) {
  TemporaryFolder folder;
  const std::string out = folder / "part.oni";
  std::ofstream(out) << "precious";
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"cut", kWhole, "--to", "0.3", "--out", out},
        std::vector<std::string>{"repair", kWhole, "--out", out}}) {
    const Ended kept = record(command);
    EXPECT_EQ(kept.code, 1) << kept.words;
    EXPECT_THAT(kept.words, HasSubstr("--overwrite"));
    EXPECT_EQ(read_all(out), "precious");
  }
  const Ended replaced = record({"cut", kWhole, "--to", "0.3", "--out", out, "--overwrite"});
  EXPECT_EQ(replaced.code, 0) << replaced.words;
  EXPECT_EQ(record({"info", out}).code, 0);
}

TEST(RecordProgram, SaysWhereAPartEndsBeforeItsTime) {
  TemporaryFolder folder;
  const Ended cut = record({"cut", kWhole, "--from", "1", "--to", "99", "--out", folder / "part.oni"});
  EXPECT_EQ(cut.code, 0);
  EXPECT_THAT(cut.words, HasSubstr("only 2.0 s long"));
}

TEST(RecordProgram, CountsRepairedFramesAsInfoDoes) {
  TemporaryFolder folder;
  const std::string bytes = read_all(kWhole);
  std::ofstream(folder / "cut_off.oni", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const Ended repaired = record({"repair", folder / "cut_off.oni"});
  const auto streams =
      nlohmann::json::parse(record({"info", folder / "cut_off.oni", "--json"}).words)["streams"];
  EXPECT_THAT(repaired.words, HasSubstr("finished with " + std::to_string(streams[0]["frames"].get<int>()) +
                                        " frames of depth, " +
                                        std::to_string(streams[1]["frames"].get<int>()) + " of colour"));
}

TEST(RecordProgram, AWrongCommandLineExitsWithTwo) {
  EXPECT_EQ(record({}).code, 2);
  EXPECT_EQ(record({"play", kWhole}).code, 2);
  EXPECT_EQ(record({"cut", kWhole}).code, 2);
  EXPECT_EQ(record({"cut", kWhole, "--from", "2", "--to", "1", "--out", "x.oni"}).code, 2);
  EXPECT_EQ(record({"from-images", "/tmp", "--out", "x.oni", "--fx", "525"}).code, 2);
  EXPECT_EQ(record({"--help"}).code, 0);
  EXPECT_EQ(record({"from-images", "--help"}).code, 0);
  EXPECT_EQ(record({"--version"}).code, 0);
}

TEST(RecordProgram, WhatFailsIsOneSentenceAndOne) {
  TemporaryFolder folder;
  for (const Ended& ended :
       {record({"info", folder / "missing.oni"}), record({"repair", folder / "missing.oni"}),
        record({"cut", kWhole, "--from", "1000", "--out", folder / "x.oni"}),
        record({"cut", kWhole, "--out", "/nonexistent/x.oni"}),
        record({"from-images", folder / "missing", "--out", folder / "x.oni"})}) {
    EXPECT_EQ(ended.code, 1) << ended.words;
    EXPECT_EQ(std::count(ended.words.begin(), ended.words.end(), '\n'), 1) << ended.words;
    EXPECT_THAT(ended.words, ::testing::StartsWith("record: "));
  }
}

}  // namespace
}  // namespace copresence::testing
