// Writes data/logs/bend.mcap: the beginning of data/logs/bend-friction.csv.gz as a robot's recorder would have it, with
// current and torque on topics of their own: make_sample_recording SOURCE FILE
#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/run_directory.h"
#include "support/bags.h"

namespace {

constexpr std::size_t kRows = 3000;
constexpr std::int64_t kBegin = 1'700'000'000'000'000'000;  // [ns]

std::vector<simgap::test::RecordedMessage> recorded(const simgap::CsvTable& table) {
  using simgap::test::Wire;
  const auto time = table.quantity("time", "s"), velocity = table.quantity("motor_velocity", "rad_s"),
             position = table.quantity("joint_position", "rad"), current = table.quantity("motor_current", "A"),
             torque = table.quantity("external_torque", "Nm");
  std::vector<simgap::test::RecordedMessage> messages;
  for (std::size_t i = 0; i < std::min(kRows, table.rows()) && (i == 0 || time[i] > time[i - 1]); ++i) {
    const std::int64_t now = kBegin + std::llround(1e9 * time[i]);
    messages.push_back({"/joint_states", "sensor_msgs/msg/JointState", "cdr", now,
                        simgap::test::jointState(Wire::kCdrLittle, now, {"bend"}, {position[i]}, {velocity[i]}, {})});
    messages.push_back(
        {"/motor/current", "std_msgs/msg/Float64", "cdr", now, simgap::test::float64(Wire::kCdrLittle, current[i])});
    messages.push_back(
        {"/load/torque", "std_msgs/msg/Float64", "cdr", now, simgap::test::float64(Wire::kCdrLittle, torque[i])});
  }
  return messages;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto table = simgap::CsvTable::load(std::string(argv[1]) + "/data/logs/bend-friction.csv.gz");
  simgap::writeFileAtomically(argv[2], simgap::test::mcapBytes(recorded(table), {.messages_per_chunk = 3 * kRows}));
}
