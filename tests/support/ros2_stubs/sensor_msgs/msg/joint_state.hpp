#pragma once
#include "rclcpp/rclcpp.hpp"

namespace sensor_msgs::msg {
struct JointState {
    struct { builtin_interfaces::msg::Time stamp; } header;
    std::vector<std::string> name;
    std::vector<double> position;
};
}  // namespace sensor_msgs::msg
