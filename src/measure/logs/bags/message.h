/// \file
/// The numbers of one message.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bag_file.h"

namespace simgap::bags {

/// One number and where it stands: "elbow.position"; "" and "3" for a plain number and an array's.
struct NamedNumber {
  std::string name;
  double value;
};

struct Message {
  std::int64_t stamp_ns = 0;  ///< of the header; not above 0 where there is none
  std::vector<NamedNumber> numbers;
};

/// True for the types and encodings that readMessage knows.
bool isReadable(const BagTopic& topic);
/// For a sentence: types and encodings.
std::string readableTypes();

/// sensor_msgs/JointState, std_msgs/Float64, Float32, Float64MultiArray and Float32MultiArray, as CDR (ROS 2), in the
/// serialisation of ROS 1, or as JSON, where the keys say what it is.
/// \param message  overwritten. \throws Malformed
void readMessage(const BagTopic& topic, std::string_view data, Message& message);

}  // namespace simgap::bags
