#include "simgap/core/progress.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <unistd.h>

#include <array>
#include <limits>
#include <thread>

namespace simgap {
namespace {

using std::chrono::milliseconds;

/// A sandbox without devpts has no terminals to give.
bool terminalsExist() {
  int screen = -1;
  int terminal = -1;
  if (openpty(&screen, &terminal, nullptr, nullptr, nullptr) != 0) return false;
  close(terminal);
  close(screen);
  return true;
}

/// Makes stderr a terminal of a given width, and keeps what is written to it.
class StderrTerminal {
 public:
  explicit StderrTerminal(unsigned short width) {
    struct winsize size = {};
    size.ws_row = 24;
    size.ws_col = width;
    int terminal = -1;
    if (openpty(&screen_, &terminal, nullptr, nullptr, &size) != 0) ADD_FAILURE() << "no pseudo terminal";
    saved_ = dup(STDERR_FILENO);
    dup2(terminal, STDERR_FILENO);
    close(terminal);
  }
  ~StderrTerminal() {
    dup2(saved_, STDERR_FILENO);
    close(saved_);
    close(screen_);
  }
  StderrTerminal(const StderrTerminal&) = delete;
  StderrTerminal& operator=(const StderrTerminal&) = delete;

  /// What was written since the last call. The kernel hands it over a moment later, hence the wait.
  std::string take() {
    std::string text;
    struct pollfd screen = {screen_, POLLIN, 0};
    while (poll(&screen, 1, 200) > 0 && (screen.revents & POLLIN) != 0) {
      std::array<char, 256> block;
      const ssize_t got = read(screen_, block.data(), block.size());
      if (got <= 0) break;
      text.append(block.data(), static_cast<std::size_t>(got));
    }
    return text;
  }

 private:
  int screen_ = -1;
  int saved_ = -1;
};

TEST(FormatDuration, ReadsAsPeopleWriteIt) {
  EXPECT_EQ(formatDuration(0.0), "0 s");
  EXPECT_EQ(formatDuration(7.6), "8 s");
  EXPECT_EQ(formatDuration(59.6), "1 min 00 s");
  EXPECT_EQ(formatDuration(200.0), "3 min 20 s");
  EXPECT_EQ(formatDuration(3599.6), "1 h 00 min");
  EXPECT_EQ(formatDuration(7500.0), "2 h 05 min");
  EXPECT_EQ(formatDuration(45.0 * 3600.0), "45 h 00 min");
}

TEST(FormatDuration, SurvivesNonsense) {
  EXPECT_EQ(formatDuration(-3.0), "0 s");
  EXPECT_EQ(formatDuration(std::numeric_limits<double>::infinity()), "unknown time");
  EXPECT_EQ(formatDuration(std::numeric_limits<double>::quiet_NaN()), "unknown time");
}

TEST(Progress, RewritesOneLineOfATerminal) {
  if (!terminalsExist()) GTEST_SKIP() << "no pseudo terminal here";
  StderrTerminal terminal(200);
  {
    Progress progress("generation", 250, false);
    progress.update(1, "best 3.5");
    EXPECT_EQ(terminal.take(), "") << "nothing within the first second";
    std::this_thread::sleep_for(milliseconds(1200));
    terminal.take();
    progress.update(125, "best 2.5");
    progress.update(126, "too soon: at most 10 times a second");
    // Half is done, so as much time is left as has passed: 1 s, and at most 9 s on a very busy machine.
    const std::string line = terminal.take();
    EXPECT_TRUE(line.starts_with("\rgeneration 125/250, ") && line.ends_with(" s left, best 2.5\x1b[K")) << line;
    EXPECT_EQ(line.size(), std::string("\rgeneration 125/250, 1 s left, best 2.5\x1b[K").size()) << line;
    progress.update(249);  // the wait in take() is over
    progress.update(250);
    EXPECT_TRUE(terminal.take().ends_with("\rgeneration 250/250\x1b[K")) << "the last one is never left out";
  }
  EXPECT_EQ(terminal.take(), "\r\n");  // the terminal's own translation of a newline
}

TEST(Progress, MovesWithoutNews) {
  if (!terminalsExist()) GTEST_SKIP() << "no pseudo terminal here";
  StderrTerminal terminal(200);
  {
    Progress work("fit-motor", 0, false);
    std::this_thread::sleep_for(milliseconds(2300));
    const std::string lines = terminal.take();
    EXPECT_NE(lines.find("\rfit-motor, 1 s so far\x1b[K"), std::string::npos) << lines;
    EXPECT_NE(lines.find("\rfit-motor, 2 s so far\x1b[K"), std::string::npos) << lines;
  }
  EXPECT_EQ(terminal.take(), "\r\x1b[K") << "nothing is left of it";
}

TEST(Progress, SentencesStandOnLinesOfTheirOwn) {
  if (!terminalsExist()) GTEST_SKIP() << "no pseudo terminal here";
  StderrTerminal terminal(30);
  Progress progress("pose", 4, false);
  std::this_thread::sleep_for(milliseconds(1200));
  progress.update(2);
  terminal.take();
  printSentence("a cord is stretched beyond what is linear");
  const std::string text = terminal.take();
  EXPECT_TRUE(text.starts_with("\r\x1b[Ka cord is stretched beyond\r\n  what is linear\r\n\rpose 2/4, ")) << text;
}

TEST(Progress, CutsALineToTheTerminal) {
  if (!terminalsExist()) GTEST_SKIP() << "no pseudo terminal here";
  StderrTerminal terminal(20);
  Progress progress("pose", 4, false);
  std::this_thread::sleep_for(milliseconds(1050));
  terminal.take();
  progress.update(4, "α α α α α α α α α");
  EXPECT_EQ(terminal.take(), "\rpose 4/4, α α α α α\x1b[K");  // 19 characters
}

TEST(Progress, LeavesEarlierWorkOutOfTheEstimate) {
  if (!terminalsExist()) GTEST_SKIP() << "no pseudo terminal here";
  StderrTerminal terminal(200);
  Progress progress("step", 1'020'100, false);
  progress.startFrom(1'000'000);
  std::this_thread::sleep_for(milliseconds(1050));
  terminal.take();
  progress.update(1'000'100);
  // 100 steps in 1.05 s, 20000 to go: 210 s. The steps before would make it less than 1 s.
  const std::string line = terminal.take();
  EXPECT_NE(line.find(" min "), std::string::npos) << line;
}

TEST(Progress, WritesPlainLinesIntoAFile) {
  testing::internal::CaptureStderr();
  {
    Progress progress("generation", 10, false);
    std::this_thread::sleep_for(milliseconds(1050));
    progress.update(1);  // too early for a file
    std::this_thread::sleep_for(milliseconds(4000));
    progress.update(10, "done");
    progress.update(10, "again");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "generation 10/10, done\n");
}

TEST(Progress, QuietIsSilent) {
  if (!terminalsExist()) GTEST_SKIP() << "no pseudo terminal here";
  StderrTerminal terminal(80);
  {
    Progress progress("generation", 10, true);
    std::this_thread::sleep_for(milliseconds(1050));
    progress.update(5);
    progress.update(10);
  }
  EXPECT_EQ(terminal.take(), "");
}

}  // namespace
}  // namespace simgap
