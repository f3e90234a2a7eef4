/// \file
/// Other programs as a user runs them: arguments in, exit code and output out, signals at any moment.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace simgap::test {

/// How a process ended.
struct ProcessResult {
  int exit_code = -1;  ///< -1 when a signal ended it
  int signal = 0;
  std::string out;
  std::string err;
};

/// A running process; killed when it is still there at the end of its scope. Its standard input is empty.
class Process {
 public:
  /// \param arguments  the program first.  \param folder  the working directory.
  Process(const std::vector<std::string>& arguments, const std::filesystem::path& folder);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const;
  /// Reads its output to the end and waits. Call it once.
  ProcessResult wait();

 private:
  pid_t pid_ = -1;
  int out_ = -1;
  int err_ = -1;
  bool ended_ = false;
};

ProcessResult runProcess(const std::vector<std::string>& arguments, const std::filesystem::path& folder);
/// \throws std::runtime_error  with what it said on stderr where its exit code is not 0.
void runOrThrow(const std::vector<std::string>& arguments, const std::filesystem::path& folder);

/// Under the address sanitizer, programs run from now on may end with memory that libraries of others have lost.
void allowLeaks();

}  // namespace simgap::test
