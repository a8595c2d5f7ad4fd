#pragma once
#include "rclcpp/rclcpp.hpp"

namespace realtime_tools {
template <class MessageT>
class RealtimePublisher {
public:
    explicit RealtimePublisher(typename rclcpp::Publisher<MessageT>::SharedPtr publisher) : publisher_(publisher) {}
    bool try_publish(const MessageT &message) { publisher_->publish(message); return true; }

private:
    typename rclcpp::Publisher<MessageT>::SharedPtr publisher_;
};
}  // namespace realtime_tools
