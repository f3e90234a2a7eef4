/// \file
/// `intervene` on a diagnosis of a log, and what it shares with `design --separate`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/intervene/logs/log_intervention.h"

namespace simgap {

struct InterveneOptions {
  CommonOptions common;
  LogFileOptions table;
  std::filesystem::path run;
  std::vector<std::string> changes;
  std::string poses, motions, log, profile, bench;
};

/// What the files of --change say; a change without a name has its file's. \param none  how no change is called
template <class Changes, class Read>
std::vector<Changes> readChangeFiles(const InterveneOptions& options, Session& session, const char* none,
                                     const Read& read) {
  std::vector<Changes> all;
  for (const std::string& file : options.changes) {
    all.push_back(read(YamlNode::parse(session.read("change", file).content, file)));
    if (all.back().name.empty()) all.back().name = std::filesystem::path(file).stem().string();
  }
  if (all.empty()) all.emplace_back().name = none;
  return all;
}

/// What was recorded shows what became of one change. \param recorded  option of its file \throws ConfigError: several
void requireOneChange(const InterveneOptions& options, const char* recorded);

/// \throws DataError: a file of that role has the content of one that the run read.
void requireOtherFiles(const Session& session, const std::string& role, const std::filesystem::path& run);

/// What the diagnosis left in its folder of candidates.
LogEvidence readLogEvidence(const InterveneOptions& options, Session& session);
ExitCode interveneOnLog(const InterveneOptions& options, const std::vector<std::string>& argv);

}  // namespace simgap
