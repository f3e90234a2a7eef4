/// \file
/// What the lists of candidates of poses and of logs share.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/yaml.h"

namespace simgap {

/// "01-payload_forearm.yaml"
std::string candidateFileName(std::size_t number, const std::string& causes);

/// The name of a file beside the list. \throws ConfigError: it lies elsewhere
std::string fileNameOf(const YamlNode& node);

/// A list's entries: file, causes and role of each; `readRest` reads what a kind has besides.
/// \tparam Entry  with file and candidate {causes, role}. \throws ConfigError: fewer than two, a file elsewhere
template <class Entry, class ReadRest>
std::vector<Entry> readCandidateEntries(const YamlNode& list, const ReadRest& readRest) {
  std::vector<Entry> entries;
  for (const YamlNode& node : list.items()) {
    Entry& entry = entries.emplace_back();
    entry.file = fileNameOf(node.at("file"));
    entry.candidate.causes = node.at("causes").text();
    entry.candidate.role = node.at("role").oneOf({"named", "instead", "alone", "refused", "without"});
    readRest(node, entry.candidate);
  }
  if (entries.size() < 2) {
    list.fail("found fewer than two candidates: the diagnosis had nothing to compare its answer with");
  }
  return entries;
}

}  // namespace simgap
