#pragma once
#include <any>

#include "rclcpp/rclcpp.hpp"

namespace rclcpp_lifecycle {
struct State {};

namespace node_interfaces {
class LifecycleNodeInterface {
public:
    enum class CallbackReturn : unsigned char { SUCCESS = 97, FAILURE = 98, ERROR = 99 };
    virtual ~LifecycleNodeInterface() = default;
    virtual CallbackReturn on_configure(const State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_activate(const State &) { return CallbackReturn::SUCCESS; }
};
}  // namespace node_interfaces

class LifecycleNode {
public:
    const char *get_name() const { return "the_node"; }
    rclcpp::Logger get_logger() const { return {}; }
    std::shared_ptr<rclcpp::Clock> get_clock() { return clock; }

    template <typename Message>
    std::shared_ptr<rclcpp::Publisher<Message>> create_publisher(const std::string &topic, const rclcpp::SystemDefaultsQoS &)
    {
        auto made = std::make_shared<rclcpp::Publisher<Message>>();
        made->topic = topic;
        ends[topic] = made;
        return made;
    }

    std::map<std::string, std::any> ends, parameters;
    std::shared_ptr<rclcpp::Clock> clock = std::make_shared<rclcpp::Clock>();
};
}  // namespace rclcpp_lifecycle
