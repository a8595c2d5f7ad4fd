// Replacement of parts of rclcpp, with the signatures of ROS 2 Jazzy, for tests of exported packages.
#pragma once
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace builtin_interfaces::msg {
struct Time { double seconds = 0.0; };
}

namespace rclcpp {
struct Duration {};
struct Time {
    double seconds = 0.0;
    operator builtin_interfaces::msg::Time() const { return {seconds}; }
};
struct SystemDefaultsQoS {};
struct Logger {};
struct Clock {};

template <typename Message>
struct Publisher {
    using SharedPtr = std::shared_ptr<Publisher>;
    std::string topic;
    Message last;
    int count = 0;
    void publish(const Message &message) { last = message; ++count; }
};
}  // namespace rclcpp

#define RCLCPP_WARN_THROTTLE(logger, clock, milliseconds, ...) \
    do { const rclcpp::Logger l_ = (logger); rclcpp::Clock &c_ = (clock); (void)l_; (void)c_; (void)(milliseconds); \
         std::fprintf(stderr, __VA_ARGS__); std::fputc('\n', stderr); } while (0)
